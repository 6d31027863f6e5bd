"""The paragraphs of the page on how learners were trained and tested, and the limits of that."""

from collections.abc import Mapping

from arena_generalisation.analysis import VECTORS, Analysis, title, titles
from arena_generalisation.learning import querying_learners
from arena_generalisation.reinforcement import reinforcement_learners, wheels_learners
from arena_generalisation.rows import IMITATOR
from arena_generalisation.trainings import CORRIDOR
from khepera_forage.experiments.measures import mean


def method(found: Analysis) -> str:
    """What every learner has in common, and the training of imitators."""
    return f"""\
Each replication trains and tests once: imitators in ten episodes of paired training (5.3) in the corridor, or in
one episode in each of ten procedural training arenas, of which as many experience vectors are kept as the corridor
gave: {_vectors(found, IMITATOR)} on average. Every learner then forages alone in the arenas of the thesis, in the
family, and in procedural test arenas that no learner was trained in. Places are random, and the same for all
learners. Distances to the home and to food are straight, as in 4.3, unless the text says otherwise. The corridor's
food is all pickable, as in the thesis. The arenas of the family have pickable food, except for mixed foods; procedural
arenas also have pushable food (from medium on) and poison (from hard on). Everything but queries to the teacher runs
on compiled worlds. Noise is the laboratory's; easy arenas have half of it, extreme ones 1.5 times as much."""


def left_out(reasons: Mapping[str, str]) -> str:
    """Learners that need something which is not installed.

    Args:
        reasons: By name.
    """
    return "\n\n".join(f"`{name}` was left out: {reason}." for name, reason in reasons.items())


def querying(found: Analysis) -> str:
    """How learners that query the teacher are trained; empty without them."""
    if not found.querying:
        return ""
    known = querying_learners()
    fitted = "; ".join(f"{title(name)} ({known[name].learner.title})" for name in found.querying)
    return (
        f"These learners query the teacher (in brackets: what is fitted to its answers): {fitted}. Behavioural cloning "
        "is a small network. At first the teacher acts, then the learner itself; in every step, the teacher says what "
        f"it would do there. Each training has {_vectors(found, found.querying[0])} queries: all of them in the "
        f"corridor, or equal shares in {len(found.difficulties)} procedural training arenas, one of each difficulty."
    )


def reinforcement(found: Analysis, steps: int) -> str:
    """How reinforcement learners are trained; empty without them.

    Args:
        found: Estimates.
        steps: Environment steps of each training.
    """
    if not found.reinforced:
        return ""
    known = reinforcement_learners()
    holds = " or ".join(map(str, sorted({known[name].hold for name in found.reinforced})))
    return (
        f"Reinforcement learners ({titles(found.reinforced)}) see no teacher. In each replication they are "
        "trained for the environment's reward: +1 for a delivery, -1 for poison, and a small cost for every step. "
        f"They are trained once in the corridor for {steps:,} steps, which algorithms may overshoot, and once for "
        "as many steps in the ten procedural arenas in which the replication's imitators are trained. Places are "
        f"random in every episode. Behaviours of reinforcement learners hold for {holds} rounds, also in recalls; all "
        "other learners decide in every round, and so do random behaviours."
    )


def limits(found: Analysis) -> str:
    """What the results do not show."""
    points = [
        f"Learners on wheels ({titles(wheels_learners())}) were left out, because they command motors and not "
        "behaviours. [Compare learners](comparison.md) has their results in corridor and rectangle."
    ]
    if found.querying:
        points.append(
            f"Learners that query the teacher had {len(found.difficulties)} varied arenas, all others ten. Their "
            "queries were answered on pymunk."
        )
    if found.reinforced:
        points.append(
            "Reinforcement learners have as many steps in varied arenas as in the corridor, not as many episodes. "
            "Their networks get distances divided by the corridor's diagonal in every arena."
        )
    points += [
        "Bodies, the radius of the home (80 mm), the teacher and the settings of learners were not varied. The "
        "settings were chosen in the corridor.",
        "Difficulty changes several things at once: size, walls, number and types of food, and noise.",
        "Learners that use the arena's diagonal (4.6.1) were fitted with the corridor's and forage with that of the "
        "arena.",
        "Each replication has few recalls, and one set of training files for all of them. Intervals are therefore "
        "wide.",
    ]
    return "\n".join(["## Limits", "", *(f"- {point}" for point in points)])


def _vectors(found: Analysis, learner: str) -> str:
    """How many state vectors a learner learns from in the corridor."""
    return f"{mean(found.rows(learner, CORRIDOR), VECTORS, found.rng).value:,.0f}"
