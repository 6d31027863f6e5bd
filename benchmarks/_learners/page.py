"""The page: the picture, what came out, the table, and every learner's settings."""

import math
from collections.abc import Mapping, Sequence

from _learners.curves import ENOUGH, Curve
from _learners.lessons import REFERENCES, Compared
from _learners.rows import ARENAS
from _learners.units import told
from khepera_forage.policies.learners import FromSteps, Needs
from khepera_forage.thesis.tables import Column, Table, Value, interval

ENOUGH_NAME = f"steps to {100 * ENOUGH:.0f} % of the food"
HOW = """Everyone learns in the corridor and nowhere else, and then forages alone in the corridor and in the rectangle:
the thesis has no pair of rectangles, so only trial and error could have learned there, and its rows would be of another
task. The rectangle thus shows what is carried over. Places of food and robot are drawn anew for every recall; they are
the same for all learners, and after every amount of learning.

- **Imitators** (experience vectors) get growing numbers of the same training episodes (5.3). Their steps are the
  rounds of all attempts, with those that were incomplete and forgotten. Training always has the marks of figure 5.1,
  one start and one place of the food; recalls have not. Moving food and start in training helps an imitator a lot: that
  is a question of its own, in `benchmarks/further_work.py --only variety`.
- **Those who ask** (expert queries: DAgger) forage in the corridor with places drawn anew, as in the recalls, and the
  teacher says at every step what it would have done. A query is a step, and a vector to learn from. The teacher is
  always there, and sees what the learner sees: a laboratory would have to provide that.
- **Trial and error** (environment steps: stable-baselines3) forages there too, for the environment's reward: +1 a
  delivery, -1 for poison, a little less for every step. It is shown nothing. One training, looked at as it goes on; an
  amount is reached to within what the algorithm takes at a time.

A step is 0.1 s of one robot's life. Seconds are wall time of one process, simulation included. The score counts steps
in which a learner does what the teacher would have done (5.4): whoever forages in another way scores low and may still
bring all food home, and with motors in place of behaviours hardly any step counts. Food is
what all can be compared by."""
TUNING = """Settings stand in `khepera_forage/policies/learners.py`, each learner's in one place. `python
benchmarks/learners.py --tune` compares them with four others each, for all that learn from vectors or queries but the
thesis' imitator, which stays as it is: over seeds that no table here uses, in the corridor, after the largest amount of
learning. Trial and error has no part in that, as a grid of full trainings would take days: how its settings were found
stands beside them."""


def main_table(curves: Sequence[Curve], learners: Mapping[str, Compared]) -> Table:
    """Every learner in both arenas, after all of its learning."""
    return Table(
        "table_learners",
        "After all of the learning",
        f"Means with 95 % bootstrap intervals over replications. {ENOUGH_NAME.capitalize()}: steps lived through when "
        "a batch of recalls first delivered as much, the median over replications; ∞ if more than half never did. "
        "Gain: how much more of the food than after the first amount of learning.",
        (
            Column("learner"),
            Column("learns from"),
            Column("arena"),
            Column("seeds"),
            Column("score (%)", estimate=True),
            Column("food delivered (%)", estimate=True),
            Column("steps a recall", 0, estimate=True),
            Column("steps lived through", 0, estimate=True),
            Column("vectors", 0, estimate=True),
            Column(ENOUGH_NAME, 0, estimate=True),
            Column("gain (points)", estimate=True),
            Column("learning (s)", 2, estimate=True),
        ),
        [_line(curve, learners[curve.learner]) for curve in curves],
    )


def amounts_table(curves: Sequence[Curve], learners: Mapping[str, Compared]) -> Table:
    """The same after every amount of learning: what the picture shows."""
    return Table(
        "table_amounts",
        "After every amount of learning",
        "What the picture shows.",
        (
            Column("learner"),
            Column("arena"),
            Column("amount"),
            Column("seeds"),
            Column("steps lived through", 0, estimate=True),
            Column("vectors", 0, estimate=True),
            Column("score (%)", estimate=True),
            Column("food delivered (%)", estimate=True),
            Column("learning (s)", 2, estimate=True),
        ),
        [
            (
                curve.learner,
                curve.arena,
                p.amount,
                p.batches,
                p.steps,
                p.vectors,
                p.score,
                p.delivered,
                p.seconds,
            )
            for curve in curves
            for p in curve.points
        ],
    )


def page(
    curves: Sequence[Curve],
    learners: Mapping[str, Compared],
    missing: Mapping[str, str],
    tuned: str,
    command: str,
) -> str:
    """All of it, in Markdown.

    Args:
        curves: One a learner and arena.
        learners: All there are, by name.
        missing: Why some are left out.
        tuned: What came of the comparison of settings, which then has a page in the folder `tuning`; empty if none is
            there.
        command: That made it.
    """
    names = list(dict.fromkeys(curve.learner for curve in curves))
    settings = "\n".join(
        f"| `{name}` | {learners[name].title} | `{told(learners[name])}` |"
        for name in names
        if name not in REFERENCES
    )
    absent = "".join(
        f"\n`{name}` was left out: {reason}.\n" for name, reason in missing.items() if name not in names
    )
    outcome = f"What came of it ([all settings](tuning/tuning.md)): {tuned}\n\n" if tuned else ""
    return (
        "# Every learner side by side\n\n"
        "**How much experience does it take to forage, and who gets by with little?**\n\n"
        "![Food delivered against steps lived through](learners.png)\n"
        f"{absent}\n"
        f"## What came out\n\n{_reading(curves, learners)}\n\n"
        f"## How\n\n{HOW}\n\n"
        f"{main_table(curves, learners).markdown()}\n"
        "The same after every amount of learning is in `table_amounts.csv`, every batch of recalls in `rows.csv`.\n\n"
        f"## Settings\n\n{TUNING}\n\n{outcome}| name | learner | settings |\n|---|---|---|\n{settings}\n\n"
        f"## Command\n\n    {command}\n\n"
        "A run that is killed goes on with the same command. `--backend ray` and `--backend dask` do the same work on "
        "a cluster, with `--address` on one that is there already.\n"
    )


def _line(curve: Curve, learner: Compared) -> tuple[Value, ...]:
    end = curve.end
    return (
        learner.title,
        learner.needs.value if learner.needs else "-",
        curve.arena,
        end.batches,
        end.score,
        end.delivered,
        end.recall_steps,
        end.steps,
        end.vectors,
        curve.enough,
        curve.gain,
        end.seconds,
    )


def _reading(curves: Sequence[Curve], learners: Mapping[str, Compared]) -> str:
    """For each arena and kind of learner: who delivers most in the end, and who is first to deliver enough."""
    lines = [
        "The best of a kind is the one with the highest mean: where intervals overlap, others may be as good. First is "
        "who needs the smallest amount of learning asked for; those with the same amount are level, even if one takes "
        "some more steps at a time. An interval below 0 among the gains is a learner that forages worse for having "
        "learned more.\n"
    ]
    for arena in ARENAS:
        for needs in Needs:
            own = [c for c in curves if c.arena == arena and learners[c.learner].needs is needs]
            if not own:
                continue
            lines.append(
                f"- **{arena.capitalize()}, {needs.value}.** Most food in the end: {_best(own, learners)}. "
                f"{_earliest(own, learners)}"
            )
    lines += _on_wheels(curves, learners)
    lines += [
        f"- **{curve.arena.capitalize()}, {_share(curve, learners)}** of the food, with nothing to learn."
        for curve in curves
        if curve.learner in REFERENCES
    ]
    return "\n".join(lines)


def _share(curve: Curve, learners: Mapping[str, Compared]) -> str:
    return f"{learners[curve.learner].title}, {interval(curve.end.delivered)} %"


def _best(curves: Sequence[Curve], learners: Mapping[str, Compared]) -> str:
    most = max(curve.end.delivered.value for curve in curves)
    return "; ".join(
        f"{_share(curve, learners)} after {curve.end.steps.value:,.0f} steps"
        for curve in curves
        if curve.end.delivered.value == most
    )


def _earliest(curves: Sequence[Curve], learners: Mapping[str, Compared]) -> str:
    asked = min(curve.enough_asked for curve in curves)
    if not math.isfinite(asked):
        return f"None of the {len(curves)} delivers {100 * ENOUGH:.0f} % in half of its replications."
    first = [curve for curve in curves if curve.enough_asked == asked]
    named = "; ".join(f"{learners[c.learner].title}, after {c.enough.value:,.0f} steps" for c in first)
    return f"First to deliver {100 * ENOUGH:.0f} %{', level' if len(first) > 1 else ''}: {named}."


def _on_wheels(curves: Sequence[Curve], learners: Mapping[str, Compared]) -> list[str]:
    """Whether trial and error with motors in place of behaviours has learned to forage where it learns."""
    own = [(curve, learners[curve.learner]) for curve in curves if curve.arena == ARENAS[0]]
    wheels = [curve for curve, learner in own if isinstance(learner, FromSteps) and learner.wheels]
    if not wheels:
        return []
    learned = sum(math.isfinite(curve.enough.value) for curve in wheels)
    steps = f"{max(curve.end.amount for curve in wheels):,} steps"
    verdict = (
        f"{learned} of {len(wheels)} learn to forage within {steps}"
        if learned
        else f"Within {steps} none learns to forage"
    )
    ends = "; ".join(_share(curve, learners) for curve in wheels)
    return [
        f"- **{ARENAS[0].capitalize()}, trial and error on wheels.** {verdict} ({100 * ENOUGH:.0f} % of the food in "
        f"half of the replications). Food delivered in the end: {ends}."
    ]
