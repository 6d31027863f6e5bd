"""What the robots of a virtual laboratory would perceive on undisturbed lines.

Every robot has a second perception on the same camera scene, with senses from the simulated body instead of the line.
"""

from collections.abc import Sequence
from typing import NamedTuple

from khepera_forage.envs.arguments import food_odds
from khepera_forage.envs.layouts import arena_map_of, tracker_of
from khepera_forage.envs.recalls import Forager, perceive_all
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.khepera import PULSE, SPEED_UNIT, Motors, Senses, applicable
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.task.placement import draw_food_types
from khepera_forage.task.states import StateVector


class RoundFailures(NamedTuple):
    """Failures in a round of all robots.

    Attributes:
        halted: A body did not turn its wheels as its driver commanded.
        misread: A driver reported a proximity, object presence, arm or jaw that was not its body's.
        miscounted: A driver reported a wrong turn of the wheels in this round.
    """

    halted: bool
    misread: bool
    miscounted: bool


class _Body:
    """A simulated body that is sensed here and driven by its driver, over the line."""

    has_gripper = True

    def __init__(self, body: SimulatedKhepera) -> None:
        self._body = body

    def sense(self) -> Senses:
        return self._body.sense()

    def drive(self, motors: Motors) -> Motors:
        return applicable(motors)

    def stop(self) -> None: ...

    def close(self) -> None: ...


class Truth:
    """True perception of all robots from the beginning of an episode; the food has the default type.

    Args:
        lab: The laboratory with the bodies.
        foragers: Those of the episode, at its beginning.
    """

    def __init__(self, lab: VirtualLaboratory, foragers: Sequence[Forager]) -> None:
        self._lab = lab
        self._pulses_a_unit = SPEED_UNIT * lab.round_duration / PULSE
        self._reported = foragers
        self._foragers: list[Forager] = []
        for body, arena, reported in zip(lab.simulation.robots, lab.arenas, foragers, strict=True):
            arena_map = arena_map_of(arena)
            tracker = tracker_of(arena.foods, arena_map)
            draw_food_types(tracker.foods, 0, food_odds(None))
            self._foragers.append(
                Forager(_Body(body), arena_map, reported.holes, tracker, reported.decisions)
            )
        perceive_all(self._foragers, lab.camera.look())
        self._before = [(f.senses, true.senses) for f, true in self._pairs()]

    def end_round(self) -> RoundFailures:
        """Perceive at the end of a round, and compare."""
        halted = misread = miscounted = False
        for reported, true in self._pairs():
            true.applied = reported.applied
        perceive_all(self._foragers, self._lab.camera.look())
        for i, (reported, true) in enumerate(self._pairs()):
            reported_before, true_before = self._before[i]
            turned = _turned(true_before, true.senses)
            wanted = tuple(round(self._pulses_a_unit * speed) for speed in reported.applied[:2])
            halted = halted or turned != wanted
            miscounted = miscounted or _turned(reported_before, reported.senses) != turned
            misread = misread or _rest(reported.senses) != _rest(true.senses)
            self._before[i] = reported.senses, true.senses
        return RoundFailures(halted, misread, miscounted)

    def vector(self, robot: int) -> StateVector:
        """The true state vector, as an environment shows it."""
        forager = self._foragers[robot]
        presence, home, food_type, arm, food = forager.vector
        diagonal = forager.arena.diagonal
        return StateVector(presence, min(home, diagonal), food_type, arm, min(food, diagonal))

    def _pairs(self) -> list[tuple[Forager, Forager]]:
        return list(zip(self._reported, self._foragers, strict=True))


def _turned(before: Senses, after: Senses) -> tuple[int, int]:
    """Pulses of both wheels in a round."""
    return after.left_pulses - before.left_pulses, after.right_pulses - before.right_pulses


def _rest(senses: Senses) -> Senses:
    """All but the counters, whose start values differ."""
    return senses._replace(left_pulses=0, right_pulses=0)
