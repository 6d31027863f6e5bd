"""Teacher and learner beside each other (4.5), in every pair of a block: `task.pairing`, `Teacher` and `Listener`.

Following and separation are the functions of `task.following`, compiled as they stand.
"""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.envs.compiled import compiled_rules  # noqa: F401 (the first is needed before any kernel)
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.task import raw_of, site_of, tell
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.compiled import pair_rows as pair
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task import following
from khepera_forage.task.behaviours import command
from khepera_forage.task.following import follow, recover, separated
from khepera_forage.task.states import CARRY_HEIGHT, Behaviour, FoodType

for _function in (following.separated, following.follow, following.recover, following._arc):
    inline(_function)

_WAIT = float(Behaviour.WAIT)
_POISONOUS = float(FoodType.POISONOUS)


@kernel
def speak(teachers: Worlds, learners: Worlds, c: NDArray[np.float64]) -> None:
    """The teacher's decision, which the learner hears in the same round; silence for a learner that is apart (4.5)."""
    s, shown, heard = teachers.bodies.robots, teachers.tasks, learners.tasks
    for i in range(LANES):
        # Before its first frame a robot has perceived nothing.
        silent = c[pair.APART * LANES + i] != 0.0 or s[body.NEW * LANES + i] != 0.0
        behaviour = _WAIT if silent else shown[at.STATE * LANES + i]
        shown[at.BEHAVIOUR * LANES + i] = behaviour
        heard[at.BEHAVIOUR * LANES + i] = behaviour


@kernel
def record(t: NDArray[np.float64], c: NDArray[np.float64], diagonal: int, records: NDArray[np.int16]) -> None:
    """The learners' own state vectors, each with the behaviour it hears; nothing in silence.

    Args:
        t: The learners' task rows.
        c: The company's rows.
        diagonal: Of the arena: what is observed is never further.
        records: A place for each training episode's vectors.
    """
    for i in range(LANES):
        episode = int(c[pair.EPISODE * LANES + i])
        heard = t[at.BEHAVIOUR * LANES + i]
        if episode < 0 or heard == _WAIT:
            continue
        row = int(c[pair.VECTORS * LANES + i])
        records[episode, row, 0] = int(t[at.PRESENCE * LANES + i])
        records[episode, row, 1] = min(int(t[at.HOME_DISTANCE * LANES + i]), diagonal)
        records[episode, row, 2] = int(t[at.VECTOR_TYPE * LANES + i])
        records[episode, row, 3] = int(t[at.VECTOR_ARM * LANES + i])
        records[episode, row, 4] = min(int(t[at.FOOD_DISTANCE * LANES + i]), diagonal)
        records[episode, row, pair.HEARD] = int(heard)
        c[pair.VECTORS * LANES + i] = row + 1.0


@kernel
def drive_pair(
    s: NDArray[np.float64],
    t: NDArray[np.float64],
    c: NDArray[np.float64],
    place: NDArray[np.float64],
    led: bool,
) -> None:
    """What the behaviour commands for the coming round, a learner's motors bent towards the teacher (4.5.2).

    Args:
        s: The robots' rows.
        t: The task's rows.
        c: The company's rows.
        place: What a robot knows of its arena.
        led: Whether these are the learners.
    """
    site = site_of(place)
    for i in range(LANES):
        behaviour = int(t[at.BEHAVIOUR * LANES + i])
        own = command(behaviour, raw_of(s, t, i, site))
        x, y, degrees = s[body.OWN_X * LANES + i], s[body.OWN_Y * LANES + i], s[body.OWN_DEGREES * LANES + i]
        there_x, there_y = c[pair.TEACHER_X * LANES + i], c[pair.TEACHER_Y * LANES + i]
        if not led:
            bent = own
        elif c[pair.APART * LANES + i] != 0.0 and behaviour == Behaviour.WAIT:
            bent = recover(own, x, y, degrees, there_x, there_y)
        else:
            bent = follow(own, x, y, degrees, there_x, there_y, c[pair.TEACHER_DEGREES * LANES + i])
        tell(s, i, applicable(bent))


@kernel
def share_types(told: NDArray[np.float64], hearing: NDArray[np.float64], foods: int) -> None:
    """Corresponding food is of one type: what one register has identified, the other knows too.

    Args:
        told: Register rows of one side.
        hearing: Of the other.
        foods: Number of food objects in a world.
    """
    for food in range(foods):
        known = (food * at.TASK_FOOD_ROWS + at.KNOWN) * LANES
        for i in range(LANES):
            hearing[known + i] = told[known + i]


@kernel
def keep_company(
    teachers: NDArray[np.float64],
    learners: NDArray[np.float64],
    c: NDArray[np.float64],
    place: NDArray[np.float64],
    learners_place: NDArray[np.float64],
) -> None:
    """Look who is apart after a round.

    Args:
        teachers: The teachers' robot rows.
        learners: The learners'.
        c: The company's rows.
        place: What a teacher knows of its arena.
        learners_place: What a learner knows of its own.
    """
    home_x, home_y, own_home_x, own_home_y = place[0], place[1], learners_place[0], learners_place[1]
    for i in range(LANES):
        x = teachers[body.OWN_X * LANES + i] + own_home_x - home_x
        y = teachers[body.OWN_Y * LANES + i] + own_home_y - home_y
        c[pair.TEACHER_X * LANES + i], c[pair.TEACHER_Y * LANES + i] = x, y
        c[pair.TEACHER_DEGREES * LANES + i] = teachers[body.OWN_DEGREES * LANES + i]
        apart = separated(learners[body.OWN_X * LANES + i], learners[body.OWN_Y * LANES + i], x, y)
        was = c[pair.APART * LANES + i] != 0.0
        c[pair.SEPARATIONS * LANES + i] += 1.0 if apart and not was else 0.0
        c[pair.APART_ROUNDS * LANES + i] = c[pair.APART_ROUNDS * LANES + i] + 1.0 if apart else 0.0
        c[pair.APART * LANES + i] = 1.0 if apart else 0.0


@inline
def _is_done(t: NDArray[np.float64], poison: bool, i: int, home_radius: float) -> bool:
    """Whether a robot has done its part of a training episode (5.3): `envs.training`."""
    with_arm = t[at.PRESENCE * LANES + i] != 0.0 or t[at.VECTOR_ARM * LANES + i] > CARRY_HEIGHT
    finished = t[at.DELIVERED * LANES + i] == t[at.DELIVERABLE * LANES + i]
    return finished and t[at.HOME_DISTANCE * LANES + i] > home_radius and not (poison and with_arm)


@kernel
def judge(
    teachers: Worlds,
    learners: Worlds,
    c: NDArray[np.float64],
    foods: int,
    home_radius: float,
    limit: int,
    patience: int,
) -> bool:
    """Count the round, and tell which attempts have ended: complete, out of time, or separated for too long.

    Returns:
        Whether any has.
    """
    shown, done, q = teachers.tasks, learners.tasks, teachers.registers
    ended = 0.0
    for i in range(LANES):
        poison = False
        for food in range(foods):
            poison = poison or q[(food * at.TASK_FOOD_ROWS + at.KNOWN) * LANES + i] == _POISONOUS
        counts = shown[at.FRESH * LANES + i] == 0.0
        c[pair.ROUNDS * LANES + i] += 1.0 if counts else 0.0
        complete = (
            counts and _is_done(shown, poison, i, home_radius) and _is_done(done, poison, i, home_radius)
        )
        given_up = c[pair.ROUNDS * LANES + i] >= limit or c[pair.APART_ROUNDS * LANES + i] >= patience
        over = counts and (complete or given_up) and c[pair.EPISODE * LANES + i] >= 0.0
        c[pair.COMPLETE * LANES + i] = 1.0 if complete else 0.0
        c[pair.OVER * LANES + i] = 1.0 if over else 0.0
        ended += 1.0 if over else 0.0
    return ended > 0.0
