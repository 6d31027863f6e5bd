"""One attempt at a training episode, round by round: what `TrainingEnv` wraps in PettingZoo's form (4.5, 5.3)."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.envs.forager import Forager, perceive_all
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, Motors
from khepera_forage.sim.arena import Pose
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.episode import begin_episode, end_step, has_done_its_part
from khepera_forage.task.pairing import AttemptState, Pairing, end_round, lead, update_pairing
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene


def observation_box(diagonal: int) -> spaces.Box:
    """The space of what `TrainingEpisode.observe` returns.

    Args:
        diagonal: Of the arena, in pixels.
    """
    low = np.array((0, 0, 0, ARM_RAISED, 0, 0, 0))
    high = np.array((1, diagonal, len(FoodType) - 1, ARM_DOWN, diagonal, Behaviour.WAIT, 1))
    return spaces.Box(low, high, (7,), np.int64)


class TrainingEpisode:
    """Robots side by side in copies of one arena, the teacher first, and the account of what they do.

    Args:
        world: Already reset.
        foragers: Each in its own copy of the arena; they perceive the world's first frame here.
        limit: As of `AttemptState`.
        patience: As of `AttemptState`.
        decisions: Of the task.

    Attributes:
        foragers: As given.
        pairings: Each robot and its teacher; the teacher's own means nothing.
        motors: What each robot commands itself; None where its behaviour commands the motors.
        account: Of the rounds that are over.
        decided: For each robot what it did in the last round, and what the teacher would have done; empty before.
    """

    def __init__(
        self, world: World, foragers: Sequence[Forager], limit: int, patience: int, decisions: Decisions
    ) -> None:
        self._world = world
        self._decisions = decisions.values()
        self.foragers = list(foragers)
        self.pairings = [Pairing() for _ in self.foragers]
        self.motors: list[Motors | None] = [None] * len(self.foragers)
        self.account = AttemptState(limit=limit, patience=patience)
        self.decided: list[tuple[Behaviour, Behaviour]] = []
        self._perceive(world.camera.look())
        for forager in self.foragers:
            begin_episode(forager.episode, forager.tracker)

    def observe(self, i: int) -> NDArray[np.int64]:
        """What a robot perceives: its state vector, what it hears, whether it is separated; a fresh array."""
        heard = self.foragers[0].behaviour if i else Behaviour.WAIT
        separated = any(pairing.separated for pairing in (self.pairings[i : i + 1] if i else self.pairings))
        return np.array((*self.foragers[i].vector, heard, separated), np.int64)

    def round(self) -> bool:
        """Carry out one round: all commands take effect together; returns whether the attempt has ended."""
        self.account.rounds += 1
        self.decided = [(Behaviour(forager.behaviour), forager.correct_behaviour) for forager in self.foragers]
        try:
            for i, forager in enumerate(self.foragers):
                forager.drive(self._motors_of(i, forager))
            self._world.advance()
            self._perceive(self._world.camera.look())
        finally:  # A round in which a robot is lost counts too.
            for forager, (done, correct) in zip(self.foragers, self.decided, strict=True):
                end_step(forager.episode, forager.tracker, done == correct, self.account.limit)
        all_done = all(
            has_done_its_part(f.tracker, f.food.objects, f.vector, f.arena.home_radius, f.decisions)
            for f in self.foragers
        )
        longest = max(pairing.separated_rounds for pairing in self.pairings)
        return end_round(self.account, all_done, longest, self._decisions)

    def place_beside_teacher(self, i: int) -> None:
        """Put a learner where the teacher is, in its own arena.

        Raises:
            ValueError: There is no room.
        """
        pairing = self.pairings[i]
        x, y, degrees = pairing.teacher_x, pairing.teacher_y, pairing.teacher_orientation
        self._world.place(i, Pose(x * MM_PER_PIXEL, y * MM_PER_PIXEL, math.radians(degrees)))
        pairing.separated_rounds = 0

    def command(self, i: int, motors: Motors) -> None:
        """Let a robot command its own motors in this round."""
        self.foragers[i].decide_on_motors(motors)
        self.motors[i] = motors

    def info(self, i: int) -> dict[str, Any]:
        """A robot's info, in plain numbers."""
        forager, pairing = self.foragers[i], self.pairings[i]
        raw, state, tracker, episode = forager.raw, int(forager.state), forager.tracker, forager.episode
        return {
            "state": state,
            "correct_behaviour": state,
            "x": raw.x,
            "y": raw.y,
            "orientation": raw.orientation,
            "pose": (raw.x, raw.y, raw.orientation),
            "score": episode.score,
            "correct": episode.correct,
            "steps": episode.steps,
            "delivered": tracker.delivered,
            "poison_home": tracker.poison_home,
            "complete": int(self.account.complete),
            "separated_rounds": pairing.separated_rounds,
            "separations": pairing.separations,
        }

    def _perceive(self, scene: Scene) -> None:
        """Let every robot perceive, and update the pairs."""
        perceive_all(self.foragers, scene)
        teacher = self.foragers[0]
        for pairing, forager in zip(self.pairings[1:], self.foragers[1:], strict=True):
            update_pairing(pairing, forager.raw, forager.arena, teacher.raw, teacher.arena, self._decisions)

    def _motors_of(self, i: int, forager: Forager) -> Motors:
        behaviour, motors = forager.behaviour, self.motors[i]
        if motors is None:
            motors = forager.motors_for(behaviour)
        elif i > 0:
            behaviour = self.foragers[0].behaviour  # what it hears decides how it is led
        if i == 0:
            return motors
        return lead(self.pairings[i], motors, behaviour, forager.raw, forager.decisions)
