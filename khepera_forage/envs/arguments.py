"""What environments accept: arenas, odds, actions, counts; with errors that quote the offending value."""

import math
import numbers
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.extras import require
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN
from khepera_forage.robots.model import KHEPERA, RobotModel, model_of
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.named import ARENAS, FAMILY, named_arena
from khepera_forage.sim.arenas.thesis import SetUp
from khepera_forage.sim.waypoints import check_paths
from khepera_forage.sim.world import Timing, World
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import arena_number
from khepera_forage.task.states import FoodType

PYMUNK, COMPILED = "pymunk", "compiled"
BACKENDS = (PYMUNK, COMPILED)
"""Rigid bodies of pymunk; or kernels that numba compiles, faster and for many worlds at once."""

FoodOdds = str | FoodType | Mapping[Any, float] | None
"""How users give the odds of food types: one type, or odds by type; None is all PICKABLE (5.2)."""

Arenas = Arena | str | Sequence[Arena | str]
"""How users give arenas: an `Arena`, one of the names in `ARENAS`, or a sequence of both: `["corridor", "doors"]`.

A sequence may create its arenas when they are first used. If it has an attribute `diagonal`, in mm, no arena of it may
have a larger diagonal; an environment then need not look at all arenas to know how large distances can become.
"""

_DRAWABLE = tuple(FoodType)[1:]


class Settings(NamedTuple):
    """Where robots forage, and under which conditions: what users say to every environment.

    Attributes:
        arena: See `Arenas`.
        noise: Of all devices.
        food_types: See `FoodOdds`.
        decisions: Of the task.
        model: Kind of the simulated robots.
    """

    arena: Arenas
    noise: Noise
    food_types: FoodOdds
    decisions: Decisions
    model: RobotModel

    @classmethod
    def of(
        cls,
        arena: Arenas = "corridor",
        noise: Noise | str | None = "laboratory",
        food_types: FoodOdds = None,
        decisions: Decisions | None = None,
        robot: str = KHEPERA.name,
    ) -> "Settings":
        """The settings that a user gave; arena and food types are checked when they are used.

        Raises:
            ValueError: Noise, decisions or robot is not allowed.
        """
        return cls(arena, checked_noise(noise), food_types, checked_decisions(decisions), model_of(robot))


def check_backend(backend: Any) -> str:
    """The backend that a user asked for.

    Raises:
        ValueError: Not one of `BACKENDS`.
        ImportError: The backend "compiled" without numba.
    """
    if backend not in BACKENDS:
        raise ValueError(f"backend is {backend!r}; allowed: {', '.join(map(repr, BACKENDS))}")
    if backend == COMPILED:
        instead = "; the backend 'pymunk' works without (in make_vec: vectorization_mode='sync' or 'async')"
        require("the backend 'compiled'", "fast", otherwise=instead)
    return str(backend)


def motor_action(action: Any, who: str = "") -> NDArray[np.float64]:
    """An action of the Wheels environments: left wheel, right wheel, arm, jaw.

    Args:
        action: Any value.
        who: Whose action, for the message.

    Raises:
        ValueError: Not four finite numbers in -1..1.
    """
    try:
        values = np.asarray(action, dtype=np.float64)
        right = values.shape == (4,) and np.all(np.abs(values) <= 1.0)  # NaN fails the comparison too
    except (TypeError, ValueError):
        right = False
    if not right:
        of_whom = f" of {who}" if who else ""
        raise ValueError(f"action{of_whom} is {action!r}; allowed: four numbers in -1..1 (left, right, arm, jaw)")
    return values


def food_odds(food_types: FoodOdds, has_gripper: bool, arena: Arenas) -> tuple[float, ...]:
    """Odds of each food type but UNKNOWN, in the order of `FoodType`, adding up to 1.

    Args:
        food_types: One type, or odds by type; by default PICKABLE, or PUSHABLE for robots without a gripper.
        has_gripper: Whether the robots can pick up food. Without, what the arena's own odds give as PICKABLE is
            PUSHABLE.
        arena: Whose own odds they may be.

    Raises:
        ValueError: An unknown type; odds that are negative, not finite, or all zero; or food to pick up for robots
            without a gripper.
    """
    if food_types is None:
        food_types = FoodType.PICKABLE if has_gripper else FoodType.PUSHABLE
    given = food_types.items() if isinstance(food_types, Mapping) else [(food_types, 1.0)]
    odds = {_food_type(name): share for name, share in given}
    for food_type, share in odds.items():
        if not (isinstance(share, numbers.Real) and math.isfinite(share) and share >= 0):
            raise ValueError(f"odds of {food_type.name} are {share!r}; allowed: a number >= 0")
    if not has_gripper and food_types == _own_food_types(arena):
        pickable = odds.pop(FoodType.PICKABLE, 0.0)
        odds[FoodType.PUSHABLE] = odds.get(FoodType.PUSHABLE, 0.0) + pickable
    total = sum(odds.values())
    if not total > 0:
        raise ValueError(f"food_types {food_types!r} give no type any odds; allowed: at least one above 0")
    if not has_gripper and odds.get(FoodType.PICKABLE, 0.0) > 0:
        raise ValueError(f"food_types is {food_types!r}; allowed for robots without a gripper: PUSHABLE and POISONOUS")
    return tuple(odds.get(food_type, 0.0) / total for food_type in _DRAWABLE)


def _own_food_types(arena: Arenas) -> Mapping[str, float] | None:
    """The odds of food types of a named arena, or of procedural ones; None of others."""
    if isinstance(arena, str):
        return FAMILY[arena].food_types if arena in FAMILY else None
    return getattr(arena, "food_types", None)


def checked_decisions(decisions: Any) -> Decisions:
    """The decisions that a user gave, by default ours.

    Raises:
        ValueError: Something else than `Decisions`.
    """
    if decisions is None:
        return Decisions()
    if isinstance(decisions, Decisions):
        return decisions
    raise ValueError(f"decisions is {decisions!r}; allowed: a khepera_forage.Decisions, or None")


def given_arena(arena: Arena | str, decisions: Decisions, what: str = "arena") -> Arena:
    """An arena that a user gave, or named; not checked for ways that are too narrow.

    Args:
        arena: An `Arena`, or one of the names in `ARENAS`.
        decisions: Where start, food and home are in one of the thesis's arenas (figure 5.1).
        what: What the arena is, for the message.

    Raises:
        ValueError: An unknown name, or something else.
    """
    if isinstance(arena, Arena):
        return arena
    if isinstance(arena, str) and arena in ARENAS:
        return named_arena(arena, set_up_of(decisions))
    raise ValueError(f"{what} is {arena!r}; allowed: an Arena, or one of {', '.join(map(repr, ARENAS))}")


def checked_arena(arena: Arena | str, decisions: Decisions, what: str = "arena") -> Arena:
    """An arena that a user gave, or named, in which a robot can reach everything; arguments as for `given_arena`.

    Raises:
        ValueError: As `given_arena`, or an arena that is too narrow.
    """
    given = given_arena(arena, decisions, what)
    if given is arena:
        check_paths(given)
    return given


_MOST_KEPT = 10_000
"""Arenas that are kept after their first episode, each of some 5 kB."""


class ArenaPool:
    """The arenas of an environment, checked when an episode first takes place in them.

    Args:
        arenas: See `Arenas`.
        decisions: Where start, food and home are in the thesis's arenas (figure 5.1).

    Raises:
        ValueError: An unknown name, an empty sequence, a sequence whose diagonal is no length, or something else.
    """

    def __init__(self, arenas: Arenas, decisions: Decisions) -> None:
        self._decisions = decisions
        self._checked: dict[int, Arena] = {}
        if isinstance(arenas, Sequence) and not isinstance(arenas, str):
            if not len(arenas):
                raise ValueError(f"arena is {arenas!r}; allowed: at least one arena in a sequence")
            # Another sequence than a list or a tuple may create its arenas when they are used.
            self._arenas: Sequence[Arena | str] = tuple(arenas) if type(arenas) is list else arenas
            if type(self._arenas) is tuple:
                self._given()
        else:
            self._checked[0] = checked_arena(arenas, decisions)
            self._arenas = (self._checked[0],)
        self._declared = known = getattr(self._arenas, "diagonal", None)
        if known is not None and not (isinstance(known, numbers.Real) and 0 < float(known) < math.inf):
            raise ValueError(f"diagonal of a sequence of arenas is {known!r}; allowed: a finite number of mm above 0")

    def __len__(self) -> int:
        return len(self._arenas)

    def __getitem__(self, number: int) -> Arena:
        """The arena with this number.

        Raises:
            ValueError: It is no arena, its name is unknown, it is too narrow, or it has a larger diagonal than the
                sequence says.
        """
        if number not in self._checked:
            if len(self._checked) == _MOST_KEPT:
                self._checked.clear()
            arena = checked_arena(self._arenas[number], self._decisions, _name_of(number))
            if self._declared is not None and whole_pixels(arena.diagonal) > self.diagonal:
                raise ValueError(
                    f"{_name_of(number)} has a diagonal of {arena.diagonal:g} mm; allowed: at most {self._declared:g}, "
                    "the diagonal of the sequence"
                )
            self._checked[number] = arena
        return self._checked[number]

    def number(self, key: int, episode: int) -> int:
        """Number of the arena in which an episode of a world takes place; see `task.placement.arena_number`."""
        return int(arena_number(key, episode, len(self))) if len(self) > 1 else 0

    @cached_property
    def diagonal(self) -> int:
        """The largest diagonal of all arenas, in pixels."""
        known = self._declared
        return whole_pixels(max(arena.diagonal for arena in self._given()) if known is None else known)

    def _given(self) -> list[Arena]:
        """All arenas of the sequence, not yet checked for ways that are too narrow.

        Raises:
            ValueError: One is no arena, or its name is unknown.
        """
        return [given_arena(arena, self._decisions, _name_of(number)) for number, arena in enumerate(self._arenas)]


def _name_of(number: int) -> str:
    """What messages call an arena of a sequence."""
    return f"arena {number} of a sequence"


def set_up_of(decisions: Decisions) -> SetUp:
    """Where start, food and home are in a named arena (figure 5.1)."""
    return SetUp(*(getattr(decisions, name) for name in SetUp._fields))


def timing_of(decisions: Decisions) -> Timing:
    """How long a round of a world lasts, and how fast arm and jaw move."""
    return Timing(
        decisions.round_duration,
        (ARM_DOWN - ARM_RAISED) / decisions.arm_travel_time,
        (JAW_OPEN - JAW_CLOSED) / decisions.jaw_travel_time,
    )


def arenas_of(world: World, count: int, decisions: Decisions) -> tuple[Arena, ...]:
    """The arenas of a world that a user gave, one a robot.

    Raises:
        ValueError: Not as many robots and arenas as the environment needs, or rounds that do not last as long as the
            decisions say.
    """
    if not math.isclose(world.round_duration, decisions.round_duration):
        raise ValueError(
            f"a round of this world lasts {world.round_duration:g} s, and decision round_duration is "
            f"{decisions.round_duration:g} s; allowed: the same (in a laboratory, `period` of lab.toml)"
        )
    if not len(world.arenas) == len(world.markers) == count:
        raise ValueError(
            f"world has {len(world.markers)} robots in {len(world.arenas)} arenas; allowed: {count}, one in each"
        )
    return tuple(world.arenas)


def whole_number(name: str, value: Any, least: int, most: int | None = None) -> int:
    """A count that a user gave.

    Raises:
        ValueError: Not a whole number from `least` to `most`; of at least `least` without `most`.
    """
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        number = int(value)
        if number >= least and (most is None or number <= most):
            return number
    allowed = f"of at least {least}" if most is None else f"from {least} to {most:,}"
    raise ValueError(f"{name} is {value!r}; allowed: a whole number {allowed}")


def _food_type(name: Any) -> FoodType:
    for food_type in _DRAWABLE:
        # Where a spec was stored as JSON, types are numbers, and as keys of a mapping texts of numbers.
        if name is food_type or str(name).upper() in (food_type.name, str(food_type.value)):
            return food_type
    allowed = ", ".join(t.name for t in _DRAWABLE)
    raise ValueError(f"food type {name!r} is unknown; allowed: {allowed}")
