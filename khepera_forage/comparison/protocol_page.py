"""Runs the protocol and writes its page."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from khepera_forage.comparison.learning import REFERENCES, Compared, settings_of, unable
from khepera_forage.comparison.protocol import (
    GROUPS,
    NAME,
    OFFLINE,
    RANDOM,
    TEACHING,
    THESIS,
    THINNED,
    TRACKS,
    VARIED,
    Demonstrations,
    Tested,
    plan,
    searches,
)
from khepera_forage.comparison.workers import BACKENDS
from khepera_forage.estimates import (
    UNKNOWN,
    Column,
    Estimate,
    Measure,
    Table,
    Value,
    interval,
    mean,
    pick,
    plain,
)
from khepera_forage.policies.learners import LEARNERS, FromVectors
from khepera_forage.study import Arguments, Page, Rows, collect, finish

FOUND = "searches.jsonl.gz"
"""File of a run's folder with the demonstrations that were searched for."""
SHARE = Measure[Tested]("food delivered (%)", lambda row: 100.0 * row.delivered / row.foods)
"""Every place counts alike."""


def run(given: Arguments, learners: Mapping[str, Compared]) -> int:
    """Do what is missing of the protocol, and write the page.

    Args:
        given: The arguments of `khepera-forage compare --protocol`.
        learners: Those that may take part, by name.

    Raises:
        ValueError: A learner was asked for that is on none of the tracks.
    """
    if given.out == Path("results/learners"):
        given.out = Path(f"results/{NAME}")
    given.name = NAME
    chosen = list(dict.fromkeys(given.track or TRACKS))
    concerned = {name for track in chosen for name in TRACKS[track].learners}
    concerned |= {
        name for name, one in learners.items() if name not in LEARNERS and isinstance(one, FromVectors)
    }
    for name in learners.keys() - REFERENCES.keys() if given.only or given.learner else ():
        if name not in concerned:
            raise ValueError(
                f"--only or --learner is {name!r}; allowed on these tracks: {', '.join(sorted(concerned))}, and your "
                "own ones from experience vectors"
            )
    missing = {name: why for name, one in learners.items() if name in concerned and (why := unable(one))}
    for name, why in missing.items():
        print(f"{name} is left out: {why}")
    able = {name: one for name, one in learners.items() if name not in missing}
    settings = {"protocol": NAME} | {f"learner {name}": settings_of(one) for name, one in able.items()}
    most = given.seeds if given.seeds_given else max(track.seeds for track in TRACKS.values())
    with BACKENDS[given.backend](given.jobs, given.address) as workers:
        found = Rows(())
        if TEACHING in chosen:
            tables = {Demonstrations: "demonstrations"}
            units = searches(able, given.seed, given.quick, most)
            found = collect(given, units, tables, workers.execute, settings, others=True, file=FOUND)
        tests = [
            unit
            for track in chosen
            for unit in plan(track, able, given.seed, given.quick, most, found.of(Demonstrations))
        ]
        rows = collect(given, tests, {Tested: "rows"}, workers.execute, settings, others=True).of(Tested)
    return finish(given, page(rows, given.seed, given.quick))


def page(rows: Sequence[Tested], seed: int, quick: bool) -> Page:
    """The page of all tracks that have rows.

    Args:
        rows: Of all runs in the folder.
        seed: Of the resamples.
        quick: Whether it was done in small, which says nothing about learners.
    """
    tables = []
    for name, track in TRACKS.items():
        own = pick(rows, track=name)
        if own:
            tables.append(_table(name, track.question, own, seed))
            if name == TEACHING:
                tables.append(_transfer(own, seed))
    if quick:
        return Page(f"{NAME}, in small", ["With `--quick` this is a smoke test: it says nothing.", *tables])
    findings = [line for line in (_offline(rows, seed), *_teaching(rows, seed)) if line]
    text = "\n".join(f"- {line}" for line in findings)
    return Page(NAME, [*([f"## Results\n\n{text}"] if findings else []), *tables])


def _mean(rows: Sequence[Tested], seed: int) -> Estimate:
    return mean(rows, SHARE, np.random.default_rng(seed)) if rows else UNKNOWN


def _table(name: str, question: str, rows: Sequence[Tested], seed: int) -> Table:
    """Food delivered by learner, condition and amount, in every group of places."""
    groups = {group: set(GROUPS[group]) for group in TRACKS[name].places}
    lines: list[tuple[Value, ...]] = []
    for learner, condition, amount in _kinds(rows):
        own = pick(rows, learner=learner, condition=condition, amount=amount)
        shares = [_mean([row for row in own if row.place in group], seed) for group in groups.values()]
        trainings = len({(row.replication, row.seconds) for row in own})
        measured = float(np.mean([row.vectors for row in own])), float(np.mean([row.seconds for row in own]))
        lines.append((learner, condition or "-", amount, trainings, *shares, *map(plain, measured)))
    columns = [Column("learner"), Column("condition"), Column("amount"), Column("trainings")]
    columns += [Column(f"{group} (%)", estimate=True) for group in groups]
    columns += [Column("vectors", 0, estimate=True), Column("seconds", 2, estimate=True)]
    note = (
        f"{question} Food delivered that is not poisonous, with 95 % intervals over replications; every place of a "
        "group counts alike. `teacher` is the upper bound and `random` the lower one."
    )
    return Table(name, f"Track: {name}", note, tuple(columns), lines)


def _transfer(rows: Sequence[Tested], seed: int) -> Table:
    """How much of the gap to 100 % demonstrations close, by learner and teacher."""
    lines = []
    for learner, condition, amount in _kinds(rows):
        if (
            learner not in REFERENCES
            and amount == TRACKS[TEACHING].amounts[THESIS][0]
            and condition != THESIS
        ):
            share = _mean(pick(rows, learner=learner, condition=condition, amount=amount), seed)
            usual = _mean(pick(rows, learner=learner, condition=THESIS, amount=amount), seed).value
            gap = Estimate(*(100 * (value - usual) / max(100 - usual, 1e-9) for value in share))
            lines.append((learner, condition, plain(usual), share, gap))
    columns = (
        Column("learner"),
        Column("teacher"),
        Column("thesis's teacher (%)", estimate=True),
        Column("this teacher (%)", estimate=True),
        Column("gap closed (%)", estimate=True),
    )
    note = (
        "Five demonstrations. Gap closed: 0 is the thesis's teacher, 100 is all food. Best for: demonstrations "
        "that were searched for one learner, tested with each. Intervals are over replications, or over searches, "
        "with the mean of the thesis's teacher held."
    )
    return Table("transfer", "Five demonstrations", note, columns, lines)


def _kinds(rows: Sequence[Tested]) -> list[tuple[str, str, int]]:
    """Learners, conditions and amounts, in the order of the protocol; the references first."""
    kinds = dict.fromkeys((row.learner, row.condition, row.amount) for row in rows)
    names = list(dict.fromkeys([*REFERENCES, *(name for name, _, _ in kinds)]))
    return sorted(kinds, key=lambda kind: names.index(kind[0]))


def _offline(rows: Sequence[Tested], seed: int) -> str:
    """Who delivers most after each amount of training."""
    parts = []
    for amount in TRACKS[OFFLINE].amounts[THESIS]:
        some = pick(rows, track=OFFLINE, amount=amount)
        shares = {
            name: _mean(pick(some, learner=name), seed) for name in dict.fromkeys(r.learner for r in some)
        }
        if shares:
            best = max(shares, key=lambda name: shares[name].value)
            parts.append(f"{amount}: {best}, {interval(shares[best])}")
    return f"**{OFFLINE}**: most food in all places after episodes: {'; '.join(parts)} %." if parts else ""


def _teaching(rows: Sequence[Tested], seed: int) -> list[str]:
    """Variety against quantity; and what varied arenas do."""
    own, few, many = pick(rows, track=TEACHING), *TRACKS[TEACHING].amounts[THESIS]

    def share(learner: str, condition: str, amount: int = few) -> str:
        return interval(_mean(pick(own, learner=learner, condition=condition, amount=amount), seed))

    return [
        f"**{TEACHING}, {learner}**: {few} demonstrations of the thesis's teacher {share(learner, THESIS)} %, {many} "
        f"{share(learner, THESIS, many)} %; {few} random ones {share(learner, RANDOM)} %; {few} found for it "
        f"{share(learner, f'best for {learner}')} %. {few} varied arenas {share(learner, VARIED)} %, thinned to as "
        f"many vectors as the thesis's teacher gives {share(learner, THINNED)} %."
        for learner in dict.fromkeys(row.learner for row in own if row.learner not in REFERENCES)
    ]
