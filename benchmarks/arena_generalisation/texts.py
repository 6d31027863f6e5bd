"""The paragraphs of the page, with figures from the rows."""

from collections.abc import Sequence

from arena_generalisation.analysis import BEYOND, POISON, STRAIGHT, WRONG, Analysis, title, titles
from arena_generalisation.attribution import CHANGES
from arena_generalisation.learning import querying_learners
from arena_generalisation.pictures import change_title
from arena_generalisation.recall_arenas import NAMED
from arena_generalisation.replication import PATH, QUERYING
from arena_generalisation.rows import AS_IT_IS, IMITATOR, RANDOM, TEACHER
from arena_generalisation.trainings import CORRIDOR, MOVED, VARIED, WHOLE
from khepera_forage.experiments.measures import mean
from khepera_forage.experiments.statistics import Estimate
from khepera_forage.experiments.tables import interval


def answer(found: Analysis) -> str:
    """The answer to the question of 4.9 and 5.5."""
    home = interval(found.delivered(IMITATOR, CORRIDOR, arena=CORRIDOR), 0)
    family = interval(found.delivered(IMITATOR, CORRIDOR, group=NAMED), 0)
    teacher = interval(found.delivered(TEACHER, CORRIDOR, group=NAMED), 0)
    random = interval(found.delivered(RANDOM, CORRIDOR, group=NAMED), 0)
    varied = interval(found.delivered(IMITATOR, VARIED, group=NAMED), 0)
    dagger = interval(found.delivered(QUERYING, CORRIDOR, group=NAMED), 0)
    return (
        "After reading this page you can say how much of what is learned in one arena is of use in others.\n\n"
        '**Does imitation work in "any kind of environment" (4.9, 5.5)? Only in part.** Trained in the corridor, the '
        f"thesis's imitator delivers {home} % of the food there and {family} % in the arenas of the family (the "
        f"teacher: {teacher} %; random behaviours: {random} %). In procedural arenas it delivers "
        f"{_series(found, IMITATOR, CORRIDOR)} (the teacher: {_series(found, TEACHER, CORRIDOR)}). Trained with as "
        f"many vectors from varied arenas, it delivers {varied} % in the family, and "
        f"{_series(found, IMITATOR, VARIED)}. Neither the corridor nor the state vector is the limit: a decision tree "
        "that queried the teacher in the same corridor, in the states into which its own behaviours led it, delivers "
        f"{dagger} % in the family.{_other_students(found)}{_without_a_teacher(found)}"
    )


def arenas(found: Analysis) -> str:
    """How much each learner reaches in each arena."""
    ranked = {training: _ranked(found, training, NAMED) for training in (CORRIDOR, VARIED)}
    parts = []
    for training, name in ((CORRIDOR, "the corridor"), (VARIED, "varied arenas")):
        best, worst = ranked[training][0], ranked[training][-1]
        parts.append(
            f"Trained in {name}, most of the family's food is delivered by {_share(found, best, training)}, least by "
            f"{_share(found, worst, training)}."
        )
    gains = {learner: found.gain(learner, (VARIED, STRAIGHT)) for learner in found.learners}
    better = [learner for learner, gain in gains.items() if gain.low > 0]
    worse = [learner for learner, gain in gains.items() if gain.high < 0]
    parts.append(
        f"Varied arenas in place of the corridor measurably help: {titles(better)}. They measurably harm: "
        f"{titles(worse)}. (The 95 % interval of the difference excludes 0.)"
    )
    moved = interval(found.delivered(IMITATOR, MOVED, group=NAMED), 0)
    parts.append(
        f"With other places of start and food in the same corridor, the imitator delivers {moved} % in the family."
    )
    if found.reinforced:
        failures = "; ".join(
            f"{title(learner)}, {_failures(found, learner, CORRIDOR)} trained in the corridor and "
            f"{_failures(found, learner, VARIED)} in varied arenas"
            for learner in found.reinforced
        )
        parts.append(
            f"Replications in which a reinforcement learner delivers nothing in the family: {failures}."
        )
    return "## How much does each learner reach in each arena?\n\n" + " ".join(parts)


def difficulty(found: Analysis) -> str:
    """How results fall with difficulty."""
    first, last = found.difficulties[0], found.difficulties[-1]
    parts = [
        f"From {first} to {last} arenas, the teacher delivers {_series(found, TEACHER, CORRIDOR)} of the food that is "
        "not poisonous."
    ]
    for training, name in ((CORRIDOR, "the corridor"), (VARIED, "varied arenas")):
        best = _ranked(found, training, last)[0]
        parts.append(
            f"Trained in {name}, most of the food in {last} arenas is delivered by {title(best)}: "
            f"{_series(found, best, training)}. Poisonous food objects that it brings home there in a recall: "
            f"{_poison(found, best, training, last)} (the teacher: {_poison(found, TEACHER, training, last)})."
        )
        if found.reinforced and best not in found.reinforced:
            best = _ranked(found, training, last, found.reinforced)[0]
            parts.append(
                f"Of the reinforcement learners, most of it is delivered by {title(best)}: "
                f"{_series(found, best, training)}."
            )
    return "## How do results fall with difficulty?\n\n" + " ".join(parts)


def attributes(found: Analysis) -> str:
    """Which attribute fails."""
    parts = []
    for training, name in ((CORRIDOR, "the corridor"), (VARIED, "varied arenas")):
        plain = _wrong(found, training, AS_IT_IS)
        changed = {change: _wrong(found, training, change) for change in CHANGES if change != AS_IT_IS}
        best = min(changed, key=lambda change: changed[change].value)
        worst = max(changed, key=lambda change: changed[change].value)
        beyond = mean(found.wrong_rows(training), BEYOND, found.rng)
        parts.append(
            f"Trained in {name}, the imitator is wrong in {interval(plain)} % of its decisions; "
            f"{interval(beyond, 0)} % of the wrong ones are at distances beyond the training's, and "
            f"{_most_wrong(found, training)}. The change after which "
            f"fewest are wrong is `{change_title(best)}` ({interval(changed[best])} %), the one after which most are "
            f"wrong `{change_title(worst)}` ({interval(changed[worst])} %)."
        )
    parts.append(
        "In the corridor, food to push and poison never occur: trained there, the imitator has heard neither PUSH FOOD "
        "nor AVOID FOOD, and all its decisions in these states are wrong."
    )
    return "## Which attribute of the state vector fails where?\n\n" + " ".join(parts)


def path(found: Analysis) -> str:
    """What distances along the path change."""
    gains = {
        training: interval(found.gain(IMITATOR, (training, PATH.distances), (training, STRAIGHT)), 1)
        for training in (CORRIDOR, VARIED, WHOLE)
    }
    text = (
        "In the corridor both distances are the same, and what is learned there differs in recalls only. Distances "
        f"along the path then change the family's food delivered by {gains[CORRIDOR]} points; after training in varied "
        f"arenas by {gains[VARIED]} points, and with all their vectors by {gains[WHOLE]} points."
    )
    return "## What do distances along the path change?\n\n" + text


def _series(found: Analysis, learner: str, training: str) -> str:
    """Shares at every difficulty."""
    shares = [
        f"{found.delivered(learner, training, group=group).value:.0f} % ({group})"
        for group in found.difficulties
    ]
    return ", ".join(shares)


def _other_students(found: Analysis) -> str:
    """What is delivered in the family if something else than a tree is fitted to the teacher's answers."""
    known = querying_learners()
    shares = {
        known[name].learner.title: interval(found.delivered(name, CORRIDOR, group=NAMED), 0)
        for name in found.querying
        if name != QUERYING
    }
    return "".join(
        f" With {student} in place of the tree it is {share} %." for student, share in shares.items()
    )


def _without_a_teacher(found: Analysis) -> str:
    """What reinforcement learners deliver in the family; empty without them."""
    if not found.reinforced:
        return ""
    corridor, varied = (
        ", ".join(_share(found, learner, training) for learner in found.reinforced)
        for training in (CORRIDOR, VARIED)
    )
    return (
        " Reinforcement learners, which have no teacher, deliver in the family, trained in the corridor: "
        f"{corridor}; trained in varied arenas: {varied}."
    )


def _failures(found: Analysis, learner: str, training: str) -> str:
    """Replications in which a learner delivers nothing in the family."""
    delivered: dict[int, int] = {}
    for row in found.rows(learner, training, group=NAMED):
        delivered[row.replication] = delivered.get(row.replication, 0) + row.delivered
    return f"{list(delivered.values()).count(0)} of {len(delivered)}"


def _poison(found: Analysis, learner: str, training: str, group: str) -> str:
    """Poisonous food objects that a learner brings home in a recall."""
    return interval(found.estimate(found.rows(learner, training, group=group), POISON), POISON.digits)


def _ranked(found: Analysis, training: str, group: str, learners: Sequence[str] | None = None) -> list[str]:
    """Learners, those first that deliver most; by default all of them."""
    shares = {
        learner: found.delivered(learner, training, group=group).value
        for learner in (found.learners if learners is None else learners)
    }
    return sorted(shares, key=lambda learner: -shares[learner])


def _share(found: Analysis, learner: str, training: str) -> str:
    return f"{title(learner)} ({interval(found.delivered(learner, training, group=NAMED), 0)} %)"


def _most_wrong(found: Analysis, training: str) -> str:
    """The two states in which most of the wrong decisions are taken."""
    wrong: dict[str, float] = {}
    for row in found.wrong_rows(training):
        wrong[row.state] = wrong.get(row.state, 0.0) + row.wrong
    total = sum(wrong.values())
    shares = [
        f"{100 * wrong[state] / total:.0f} % in the state {state.replace('_', ' ')}"
        for state in sorted(wrong, key=lambda state: -wrong[state])[:2]
    ]
    return " and ".join(shares)


def _wrong(found: Analysis, training: str, change: str) -> Estimate:
    return mean(found.wrong_rows(training, change), WRONG, found.rng)
