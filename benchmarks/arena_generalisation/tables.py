"""The tables of the page, one a question, and all values as CSV."""

from collections.abc import Iterator
from dataclasses import replace

from arena_generalisation.analysis import (
    BEYOND,
    CORRECTED,
    DELIVERED,
    POISON,
    SCORE,
    STRAIGHT,
    VECTORS,
    WRONG,
    Analysis,
    arena_title,
    title,
)
from arena_generalisation.attribution import CHANGES
from arena_generalisation.pictures import TRAINED, change_title
from arena_generalisation.recall_arenas import NAMED
from arena_generalisation.replication import PATH
from arena_generalisation.rows import IMITATOR, RANDOM, TEACHER, UNTRAINED
from arena_generalisation.trainings import CORRIDOR, TRAININGS, VARIED, WHOLE
from khepera_forage.experiments.measures import mean, means_table
from khepera_forage.experiments.tables import Column, Table, Value

INTERVALS = "Brackets: 95 % intervals over replications."


def arenas_table(found: Analysis) -> Table:
    """Every learner in the arenas that have a name."""
    columns = [Column("learner"), Column("trained in")]
    columns += [Column(f"{arena_title(name)} (%)", 0, estimate=True) for name in (*found.arenas[:2],)]
    columns += [Column("family (%)", 0, estimate=True), Column("family: score (%)", 0, estimate=True)]
    rows: list[tuple[Value, ...]] = []
    for learner, training in _lines(found):
        values = [found.delivered(learner, training, arena=name) for name in found.arenas[:2]]
        family = found.rows(learner, training, group=NAMED)
        values += [found.estimate(family), found.estimate(family, SCORE)]
        rows.append((title(learner), _training(learner, training), *values))
    names = ", ".join(arena_title(name) for name in found.named)
    note = (
        f"Food delivered, as a share of the food that is not poisonous, and scores. Family: {names}, each of which "
        "counts as much as any other. The score counts steps in which a learner does what the teacher would have done "
        "(5.4): a learner that forages in a different way scores low and may still deliver all food. "
        f"{INTERVALS}"
    )
    return Table("arenas", "Each learner in each arena", note, tuple(columns), rows)


def trainings_table(found: Analysis) -> Table:
    """The imitator after every training."""
    columns = [Column("training"), Column("vectors", 0), Column("corridor (%)", 0, estimate=True)]
    columns += [Column("family (%)", 0, estimate=True)]
    columns += [Column(f"{name} (%)", 0, estimate=True) for name in found.difficulties]
    rows: list[tuple[Value, ...]] = []
    for training in TRAININGS:
        own = found.rows(IMITATOR, training)
        values = [found.delivered(IMITATOR, training, arena=CORRIDOR)]
        values += [found.delivered(IMITATOR, training, group=group) for group in (NAMED, *found.difficulties)]
        rows.append((training, mean(own, VECTORS, found.rng).value, *values))
    note = (
        "Food delivered by the thesis's imitator. Other places: start and food at random in each training episode, as "
        "in recalls. Varied: one episode in each of ten procedural training arenas, of every difficulty in turn; as "
        "many vectors of them as the ten episodes in the corridor have, drawn at random, or all vectors. "
        f"{INTERVALS}"
    )
    return Table("trainings", "What the imitator is trained in", note, tuple(columns), rows)


def difficulty_table(found: Analysis) -> Table:
    """Every learner in procedural test arenas."""
    columns = [Column("learner"), Column("trained in")]
    columns += [Column(f"{name} (%)", 0, estimate=True) for name in found.difficulties]
    rows: list[tuple[Value, ...]] = [
        (
            title(learner),
            _training(learner, training),
            *(found.delivered(learner, training, group=group) for group in found.difficulties),
        )
        for learner, training in _lines(found)
    ]
    note = f"Food delivered in procedural test arenas. {INTERVALS}"
    return Table("difficulty", "Rising difficulty", note, tuple(columns), rows)


def changes_table(found: Analysis) -> Table:
    """The imitator's wrong decisions with each change to its distance."""
    columns = (
        Column("trained in"),
        Column("distance"),
        Column("wrong decisions (%)", estimate=True),
        Column("wrong ones corrected (%)", estimate=True),
    )
    rows: list[tuple[Value, ...]] = []
    for training in TRAINED:
        for change in CHANGES:
            own = found.wrong_rows(training, change)
            values = (mean(own, WRONG, found.rng), mean(own, CORRECTED, found.rng))
            rows.append((training, change_title(change), *values))
    note = (
        "Decisions of the thesis's imitator along its own recalls, in all arenas, drawn again in the same states with "
        "a changed distance. Wrong: not the teacher's behaviour. Corrected: right when drawn again, as a share of the "
        f"wrong ones; in the lines `{CHANGES[0]}` by chance alone, where confidence levels are between 0 and 1. "
        "Setting an attribute that is larger than in all experience to the nearest value of the training would change "
        "nothing: the distance to every experience vector shrinks by the same amount. The vectors recorded furthest "
        f"from home, say, are nearest in this attribute before and after. {INTERVALS}"
    )
    return Table("changes", "Which attribute fails", note, columns, rows)


def path_table(found: Analysis) -> Table:
    """The imitator with straight distances and with distances along the path."""
    columns = [Column("trained in"), Column("distances"), Column("family (%)", 0, estimate=True)]
    columns += [Column("family: score (%)", 0, estimate=True)]
    columns += [Column(f"{name} (%)", 0, estimate=True) for name in found.difficulties]
    rows: list[tuple[Value, ...]] = []
    for training in (CORRIDOR, VARIED, WHOLE):
        for distances in (STRAIGHT, PATH.distances):
            family = found.rows(IMITATOR, training, distances, group=NAMED)
            values = [found.estimate(family), found.estimate(family, SCORE)]
            values += [
                found.delivered(IMITATOR, training, distances, group=group) for group in found.difficulties
            ]
            rows.append((training, distances, *values))
    note = (
        "Food delivered by the thesis's imitator with either value of the decision `distances`, in training and in "
        f"recall. The arenas of training and recall, and the places in them, are the same. {INTERVALS}"
    )
    return Table("path", "Distances along the path", note, tuple(columns), rows)


def all_recalls(found: Analysis) -> Table:
    """Everything that was recalled, by arena."""
    by = {"learner": "learner", "training": "trained in", "distances": "distances", "group": "group"}
    rows = [
        replace(row, arena=row.group) if row.group in found.difficulties else row for row in found.recalls
    ]
    measures = (DELIVERED, SCORE, POISON)
    by["arena"] = "arena"
    return means_table("recalls", "All recalls", "", by, rows, measures, found.rng)


def all_decisions(found: Analysis) -> Table:
    """The imitator's decisions by state and change."""
    by = {"training": "trained in", "group": "arenas", "state": "state", "change": "distance"}
    measures = (WRONG, CORRECTED, BEYOND)
    return means_table("decisions", "Wrong decisions", "", by, found.wrong, measures, found.rng)


def _lines(found: Analysis) -> Iterator[tuple[str, str]]:
    """Learners and trainings, in the order of tables."""
    yield TEACHER, CORRIDOR
    for learner in found.learners:
        for training in TRAINED:
            yield learner, training
    yield RANDOM, CORRIDOR


def _training(learner: str, training: str) -> str:
    return UNTRAINED if learner in (TEACHER, RANDOM) else training
