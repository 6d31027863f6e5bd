"""The robots of a training phase in their arenas: agents, spaces and pictures (section 4.5)."""

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray
from pettingzoo.utils.env import AECEnv

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arena_pool import Arenas
from khepera_forage.envs.arguments import FoodOdds, checked_decisions, whole_number
from khepera_forage.envs.backends import PYMUNK
from khepera_forage.envs.forager import Forager
from khepera_forage.envs.paired_arenas import PairedArenas
from khepera_forage.envs.rendering import RENDER_MODES, Screen, View, training_view
from khepera_forage.envs.training_episode import TrainingEpisode, observation_box
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.task.states import Behaviour

TEACHER = "teacher_0"


class PairedRobotsEnv(AECEnv[str, NDArray[np.int64], int | None]):
    """A teacher and its learners, each in its own copy of an arena; `TrainingEnv` adds what happens in a round.

    Its arguments are described there.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 (PettingZoo's own form)
        "name": "paired_corridors_v1",
        "render_modes": list(RENDER_MODES),
        "render_fps": 1 / DEFAULT_DECISIONS.round_duration,
        "is_parallelizable": True,
    }
    default_decisions = DEFAULT_DECISIONS

    def __init__(
        self,
        num_learners: int = 1,
        max_cycles: int = 600,
        arena: Arenas = "corridor",
        noise: Noise | str | None = None,
        food_types: FoodOdds = None,
        patience: int | None = None,
        render_mode: str | None = None,
        world: World | None = None,
        decisions: Decisions | None = None,
        backend: str = PYMUNK,
    ) -> None:
        super().__init__()
        learners = whole_number("num_learners", num_learners, 1)
        self.max_cycles = whole_number("max_cycles", max_cycles, 1)
        self.decisions = checked_decisions(self.default_decisions if decisions is None else decisions)
        self.metadata = self.metadata | {"render_fps": 1 / self.decisions.round_duration}
        self.patience = self.decisions.patience if patience is None else whole_number("patience", patience, 1)
        self.render_mode = render_mode
        self._screen = Screen(render_mode, self.decisions.round_duration)
        self._paired = PairedArenas(learners + 1, arena, noise, food_types, world, self.decisions, backend)
        self._key: int | None = None
        self._episode = -1
        self.possible_agents = [TEACHER, *(f"learner_{i}" for i in range(learners))]
        self.agents: list[str] = []
        self.observation_spaces = {a: observation_box(self._paired.diagonal) for a in self.possible_agents}
        self.action_spaces = {a: spaces.Discrete(len(Behaviour)) for a in self.possible_agents}
        self._attempt: TrainingEpisode | None = None

    def observation_space(self, agent: str) -> spaces.Box:
        """The space of every agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete[np.int64]:
        """The space of every agent's actions."""
        return self.action_spaces[agent]

    @property
    def backend(self) -> str:
        """What simulates the bodies: "pymunk", "compiled", or "laboratory" for real or virtual robots."""
        return self._paired.backend

    @property
    def world(self) -> World:
        """As given, or simulated; with several arenas, that of the present attempt."""
        return self._paired.world

    @property
    def arenas(self) -> tuple[Arena, ...]:
        """The arenas of the world, the teacher's first."""
        return self._paired.arenas

    def arena_of(self, seed: int) -> Arena:
        """The teacher's arena in the attempt that `reset(seed=seed)` starts."""
        return self._paired.arena_of(key_of(seed), 0)

    @property
    def home_radius(self) -> int:
        """Of every home, in pixels."""
        return self._paired.home_radius

    @property
    def foragers(self) -> list[Forager]:
        """The robots at their task, the teacher first."""
        return self._begun.foragers

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        return self._screen.show(self.view)

    def view(self) -> View:
        """What a picture of the present round shows."""
        return training_view(self.arenas, self.world, self._begun, self.possible_agents, self.max_cycles)

    def close(self) -> None:
        """Stop the robots and close the window."""
        self.world.close()
        self._screen.close()

    @property
    def _begun(self) -> TrainingEpisode:
        if self._attempt is None:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")
        return self._attempt
