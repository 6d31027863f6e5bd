"""The comparison of learners: who takes part, the rows that are missing, and what is written."""

from collections.abc import Mapping
from shutil import get_terminal_size

from khepera_forage.comparison import tuning
from khepera_forage.comparison.learning import (
    ARENAS,
    Compared,
    RecallBatch,
    Size,
    all_learners,
    check_form,
    in_order,
    plan,
    settings_of,
    steps_up_to,
    unable,
)
from khepera_forage.comparison.page import SMOKE_TEST, page
from khepera_forage.comparison.results import (
    ReadLearner,
    Results,
    as_json,
    beside,
    curves,
    read_results,
)
from khepera_forage.comparison.workers import BACKENDS
from khepera_forage.files import replacing
from khepera_forage.policies.learner_registry import installed_learners, learner_at
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.study import UNITS, Arguments, Page, collect, command_line, machine, write

TUNING = "tuning"
"""The folder in `--out` that `--tune` writes to."""
RESULTS = "results.json"
BASELINES = ("teacher", "imitator")
"""What a learner of `--learner` is compared with, without `--only`."""
EPISODES, QUICK_EPISODES = (1, 2, 3, 5, 10), (1, 2)
QUERIES, QUICK_QUERIES = (100, 200, 300, 500, 1_000), (100, 200)


def known_learners() -> str:
    """All learners that are known here, one a line: name, title, what it learns from, and settings."""
    lines = [
        (name, learner.title, learner.needs.value if learner.needs else "-", settings_of(learner))
        for name, learner in all_learners().items()
    ]
    widths = [max(len(line[i]) for line in lines) for i in range(3)]
    return "\n".join(
        "  ".join([*(cell.ljust(width) for cell, width in zip(line, widths, strict=False)), line[-1]])
        for line in lines
    )


def compare(given: Arguments) -> int:
    """Compare learners.

    Args:
        given: The arguments of `khepera-forage compare`.

    Raises:
        ValueError: A learner that is unknown or cannot be used, or a file that holds no results.
    """
    against = read_results(given.against) if given.against else None
    own = _own_learners(given.learner or [])
    known = all_learners() | own
    for name in given.only or ():
        if name not in known:
            raise ValueError(f"--only is {name!r}; allowed: {', '.join(known)}")
    chosen = [*(given.only or (BASELINES if own else known)), *own]
    if given.protocol:
        from khepera_forage.comparison.protocol_page import run as run_protocol  # needs numba

        return run_protocol(given, {name: one for name, one in known.items() if name in chosen})
    missing = {name: reason for name in chosen if (reason := unable(known[name], given.arenas or ARENAS))}
    if not given.only and not own:
        missing |= installed_learners().broken
    for name, reason in missing.items():
        print(f"{name} is left out: {reason}")
    learners = {name: learner for name, learner in known.items() if name in chosen and name not in missing}
    if not learners:
        raise ValueError("no learner is left")
    rows = _rows(learners, known, range(given.seeds), _size(given), given)
    found = curves(rows, given.seed)
    shown = {curve.learner: known[curve.learner] for curve in found}
    results = Results(
        f"{machine()} {command_line()}",
        {name: ReadLearner(one.title, one.needs, settings_of(one)) for name, one in shown.items()},
        found,
    )
    written = page(*beside(found, shown, against), missing, _tuning_result(given), given.quick)
    write(given.out, given.name, written)
    with replacing(given.out / RESULTS) as path:
        path.write_text(as_json(results), encoding="utf-8")
    return _printed(given, written)


def tune(given: Arguments) -> int:
    """Compare settings with those of the registry.

    Raises:
        ValueError: No learner of `--only` has other settings.
    """
    known = tuning.candidates()
    wanted = given.only or list(known)
    learners = {name: learner for name, learner in known.items() if name.split(".")[0] in wanted}
    if not learners:
        allowed = ", ".join(tuning.CANDIDATES)
        raise ValueError(f"--only is {', '.join(wanted)}; allowed with --tune: {allowed}")
    given.out /= TUNING
    size = _size(given)
    size = size._replace(episodes=size.episodes[-1:], queries=size.queries[-1:], arenas=ARENAS)
    first = tuning.FIRST_REPLICATION
    rows = _rows(learners, known, range(first, first + given.seeds), size, given)
    written = tuning.page(rows, known, given.seed)
    write(given.out, TUNING, written)
    return _printed(given, written)


def _own_learners(places: list[str]) -> dict[str, Compared]:
    """The learners of `--learner`, by name."""
    found: dict[str, Compared] = {}
    for place in places:
        try:
            name, learner = learner_at(place)
            check_form(place, learner)
        except ValueError as error:
            raise ValueError(f"--{error}") from None
        if name in all_learners() or name in found:
            raise ValueError(f"--learner is {place!r}, a name that another learner has; allowed: a new name")
        found[name] = learner
    return found


def _size(given: Arguments) -> Size:
    return Size(
        recalls=given.recalls,
        episodes=QUICK_EPISODES if given.quick else EPISODES,
        queries=QUICK_QUERIES if given.quick else QUERIES,
        steps=steps_up_to(given.steps),
        arenas=tuple(dict.fromkeys(given.arenas or ARENAS)),
    )


def _rows(
    learners: Mapping[str, Compared],
    known: Mapping[str, Compared],
    replications: range,
    size: Size,
    given: Arguments,
) -> list[RecallBatch]:
    """All rows of the folder, after the missing ones have been made.

    Args:
        learners: To be done now.
        known: All that may have rows in the folder.
        replications: Of each.
        size: Of the run.
        given: Folder, processes and settings.
    """
    units = plan(learners, replications, size, given.seed)
    settings = {f"learner {name}": settings_of(learner) for name, learner in learners.items()}
    settings["arenas"] = " ".join(size.arenas)
    with BACKENDS[given.backend](given.jobs, given.address) as workers:
        rows = collect(given, units, {RecallBatch: "rows"}, workers.execute, settings, others=True)
    found = rows.of(RecallBatch)
    for row in found:
        if row.learner not in known:
            raise ValueError(f"{given.out / UNITS}: learner is {row.learner!r}; allowed: {', '.join(known)}")
    return in_order(found, list(known))


def _tuning_result(given: Arguments) -> str:
    """The result of an earlier run with `--tune` in the same folder; empty without one."""
    folder = given.out / TUNING
    if not (folder / "tuning.md").exists():
        return ""
    known = tuning.candidates()
    kept = [row for row in read_rows(folder / "rows.csv", RecallBatch) if row.learner in known]
    gains = tuning.differences(in_order(kept, list(known)), given.seed)
    return tuning.result(gains, known)


def _printed(given: Arguments, written: Page) -> int:
    if given.quick:
        print(SMOKE_TEST)
    print(written.tables[0].text(get_terminal_size().columns))
    print(f"Page, picture, all tables and rows are in {given.out}")
    return 0
