"""The page: results in words, the picture, the tables, and every learner's settings."""

import math
from collections.abc import Mapping, Sequence

from khepera_forage.comparison.curves import SUCCESS, Curve
from khepera_forage.comparison.picture import figure
from khepera_forage.comparison.results_file import ReadLearner, Shown
from khepera_forage.comparison.rows import ARENAS
from khepera_forage.comparison.units import settings_of
from khepera_forage.experiments.page import Page, Picture
from khepera_forage.experiments.tables import Column, Table, interval
from khepera_forage.policies.learners import FromSteps, Needs
from khepera_forage.task.decisions import DEFAULT_DECISIONS

SHARE = f"{100 * SUCCESS:.0f} %"
STEP = f"{DEFAULT_DECISIONS.round_duration:g} s"
METHOD = f"""## Method

Every learner learns in the corridor only, and then forages alone in the corridor and in the rectangle. The thesis has
no pair of rectangles, so only reinforcement learning could learn there, and its rows would not be comparable. The
rectangle therefore shows transfer. Places of food and robot are random in every recall, and the same for all learners
and after every amount of learning.

- **Imitators** (experience vectors) get growing numbers of the same training episodes (5.3). Their steps are the rounds
  of all attempts, including the incomplete ones whose experience is dropped. Training always starts with the marks of
  figure 5.1, one start and one place of the food; recalls do not. Variety of the training helps imitators a lot:
  `benchmarks/further_work.py --only spatial_variety` measures it.
- **Learners that query the teacher** (expert queries, DAgger) forage in the corridor with random places, as in the
  recalls, and the teacher names the behaviour that it would have chosen at every step. A query is a step, and a vector
  to learn from. The teacher must be present all the time and perceive what the learner perceives, which a laboratory
  would have to provide.
- **Reinforcement learners** (environment steps, stable-baselines3) forage there, too, for the environment's reward: +1
  for a delivery, -1 for poison, and a small cost for every step. They see no demonstration. Each is trained once and
  tested during the training. Algorithms may overshoot the requested number of steps.

A step is {STEP} of one robot's life. Seconds are wall time of one process, simulation included. The score counts steps
in which a learner does what the teacher would have done (5.4). A learner that forages in a different way scores low and
may still deliver all food, and with motor commands in place of behaviours hardly any step counts. All learners can be
compared by the food that they deliver."""
TUNING = """The settings of a learner stand in one place, `khepera_forage/policies/learners.py`.
`khepera-forage compare --tune` compares them with four others each, for all learners from vectors or queries except
the thesis's imitator, which is fixed: with seeds that no table here uses, in the corridor, after the largest amount of
learning. Reinforcement learners are left out, because a grid of full trainings would take days. The comments beside
their settings say how they were found."""
AFTERWARDS = """A run that was killed is continued by the same command. `--backend ray` and `--backend dask` do the same
work on a cluster; `--address` names one that exists already."""


def main_table(curves: Sequence[Curve], learners: Mapping[str, Shown]) -> Table:
    """Every learner in both arenas, after all of its learning."""
    rows = []
    for curve in curves:
        learner, end = learners[curve.learner], curve.end
        name = (learner.title, learner.needs.value if learner.needs else "-", curve.arena, end.batches)
        values = (end.score, end.delivered, end.recall_steps, end.steps, end.vectors)
        rows.append((*name, *values, curve.steps_to_success, curve.gain, end.seconds))
    return Table(
        "learners",
        "After all of the learning",
        f"Means with 95 % bootstrap intervals over replications. Steps to {SHARE} of the food: environment steps when "
        "a batch of recalls first delivered this share, the median over replications; ∞ if more than half never did. "
        "Gain: food delivered minus that after the first amount of learning.",
        (
            Column("learner"),
            Column("learns from"),
            Column("arena"),
            Column("seeds"),
            Column("score (%)", estimate=True),
            Column("food delivered (%)", estimate=True),
            Column("steps a recall", 0, estimate=True),
            Column("steps of learning", 0, estimate=True),
            Column("vectors", 0, estimate=True),
            Column(f"steps to {SHARE} of the food", 0, estimate=True),
            Column("gain (points)", estimate=True),
            Column("learning (s)", 2, estimate=True),
        ),
        rows,
    )


def amounts_table(curves: Sequence[Curve]) -> Table:
    """The values of the picture: after every amount of learning."""
    return Table(
        "amounts",
        "After every amount of learning",
        "The values of the picture.",
        (
            Column("learner"),
            Column("arena"),
            Column("amount"),
            Column("seeds"),
            Column("steps of learning", 0, estimate=True),
            Column("vectors", 0, estimate=True),
            Column("score (%)", estimate=True),
            Column("food delivered (%)", estimate=True),
            Column("learning (s)", 2, estimate=True),
        ),
        [
            (c.learner, c.arena, p.amount, p.batches, p.steps, p.vectors, p.score, p.delivered, p.seconds)
            for c in curves
            for p in c.points
        ],
    )


def page(
    curves: Sequence[Curve], learners: Mapping[str, Shown], missing: Mapping[str, str], tuning: str
) -> Page:
    """All of it.

    Args:
        curves: One a learner and arena.
        learners: All learners, by name.
        missing: Why some are left out.
        tuning: Result of the comparison of settings, which has a page in the folder `tuning`; empty without one.
    """
    names = list(dict.fromkeys(curve.learner for curve in curves))
    settings = Table(
        "settings",
        "Settings",
        f"{TUNING} Result ([all settings](tuning/tuning.md)): {tuning}" if tuning else TUNING,
        (Column("name"), Column("learner"), Column("settings")),
        [
            (f"`{name}`", learners[name].title, f"`{_settings(learners[name])}`")
            for name in names
            if learners[name].needs is not None
        ],
    )
    absent = [f"`{name}` was left out: {why}." for name, why in missing.items() if name not in names]
    return Page(
        "All learners side by side",
        [
            "**How much experience does a learner need to forage?**",
            Picture("learners", "food delivered against steps of learning", figure(curves, learners)),
            *absent,
            f"## Results\n\n{results(curves, learners)}",
            METHOD,
            main_table(curves, learners),
            "The same after every amount of learning is in `table_amounts.csv`, every batch of recalls in `rows.csv`.",
            settings,
            AFTERWARDS,
        ],
        (amounts_table(curves),),
    )


def results(curves: Sequence[Curve], learners: Mapping[str, Shown]) -> str:
    """For each arena and kind of learner: which delivers most in the end, and which is first to succeed."""
    lines = [
        "Best: the highest mean. Learners whose intervals overlap may be equally good. First: the smallest requested "
        "amount of learning. Learners that need the same amount tie, even if their numbers of steps differ a little. A "
        "gain below 0 means that a learner became worse with more learning.\n"
    ]
    curves = [curve for curve in curves if not isinstance(learners[curve.learner], ReadLearner)]
    for arena in ARENAS:
        for needs in Needs:
            own = [c for c in curves if c.arena == arena and learners[c.learner].needs is needs]
            if own:
                kind = f"**{arena.capitalize()}, {needs.value}.**"
                lines.append(f"- {kind} Best: {_best(own, learners)}. {_first(own, learners)}")
    lines += _wheels(curves, learners)
    lines += [
        f"- **{curve.arena.capitalize()}, without learning.** {_share(curve, learners)} of the food."
        for curve in curves
        if learners[curve.learner].needs is None
    ]
    return "\n".join(lines)


def _share(curve: Curve, learners: Mapping[str, Shown]) -> str:
    return f"{learners[curve.learner].title}, {interval(curve.end.delivered)} %"


def _best(curves: Sequence[Curve], learners: Mapping[str, Shown]) -> str:
    most = max(curve.end.delivered.value for curve in curves)
    best = [curve for curve in curves if curve.end.delivered.value == most]
    return "; ".join(f"{_share(c, learners)} after {c.end.steps.value:,.0f} steps" for c in best)


def _first(curves: Sequence[Curve], learners: Mapping[str, Shown]) -> str:
    smallest = min(curve.amount_to_success for curve in curves)
    if not math.isfinite(smallest):
        return f"None of the {len(curves)} delivers {SHARE} in half of its replications."
    first = [curve for curve in curves if curve.amount_to_success == smallest]
    named = "; ".join(
        f"{learners[c.learner].title}, after {c.steps_to_success.value:,.0f} steps" for c in first
    )
    return f"First to deliver {SHARE}{' (tied)' if len(first) > 1 else ''}: {named}."


def _wheels(curves: Sequence[Curve], learners: Mapping[str, Shown]) -> list[str]:
    """Whether reinforcement learners that command motors in place of behaviours learn to forage in the corridor."""
    own = [(curve, learners[curve.learner]) for curve in curves if curve.arena == ARENAS[0]]
    wheels = [curve for curve, learner in own if isinstance(learner, FromSteps) and learner.wheels]
    if not wheels:
        return []
    learned = sum(math.isfinite(curve.steps_to_success.value) for curve in wheels)
    steps = max(curve.end.amount for curve in wheels)
    ends = "; ".join(_share(curve, learners) for curve in wheels)
    return [
        f"- **{ARENAS[0].capitalize()}, reinforcement learning on wheels.** {learned} of {len(wheels)} learn to forage "
        f"within {steps:,} steps ({SHARE} of the food in half of the replications). Food delivered in the end: {ends}."
    ]


def _settings(learner: Shown) -> str:
    return learner.settings if isinstance(learner, ReadLearner) else settings_of(learner)
