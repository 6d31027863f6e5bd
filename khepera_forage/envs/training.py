"""Teacher and learners in identical corridors, round by round (section 4.5, figure 4.3)."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo.utils import BaseParallelWrapper, OrderEnforcingWrapper
from pettingzoo.utils.conversions import aec_to_parallel
from pettingzoo.utils.env import AECEnv, ParallelEnv

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import PYMUNK, Arenas, FoodOdds, Settings, whole_number
from khepera_forage.envs.forager import Forager, ForagingWorld
from khepera_forage.envs.layouts import arenas_with_marks, checked_options, training_layout
from khepera_forage.envs.rendering import RENDER_MODES, Screen, View, training_view
from khepera_forage.envs.training_episode import TrainingEpisode, observation_box
from khepera_forage.noise import Noise
from khepera_forage.robots.model import KHEPERA
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.world import LOST, World
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.task.placement import layout_key
from khepera_forage.task.states import Behaviour, behaviour_number

__all__ = ["TEACHER", "TrainingEnv"]

TEACHER = "teacher_0"


class TrainingEnv(AECEnv[str, Any, Any]):
    """A teacher forages and shouts; learners hear, do the same, and stay where the teacher is.

    ## Description
    The training phase of the thesis (4.5). Each robot has its own copy of the arena, at an offset. A round (MultiStep)
    is one step of every robot, the teacher first; what they command takes effect together, at its end. After a
    learner's action the environment applies *following* (4.5.2): an arc towards the place where the teacher is. When
    a learner is separated, the teacher should WAIT, which is silence, and the learner recovers.

    ## Agents
    `teacher_0`, then `learner_0`, `learner_1`, ...

    ## Action space
    `Discrete(11)` for every agent: the ten behaviours of table 4.1, and 10 WAIT.

    ## Observation space
    `Box((7,), int64)` for every agent: object_presence 0/1, robot_home_distance, food_type, arms_height,
    robot_food_distance (pixels of 5 mm, as in `Corridor-v1`), heard (a behaviour; 10 is silence), separated 0/1 (for
    the teacher: any of its learners). `state()` has the observations of all agents in a row.

    ## Rewards
    +1 for food delivered, -1 for poison brought home, -1/max_cycles a round, each agent its own.

    ## Starting state
    Every robot and food object on its mark in figure 5.1, as well as an operator can put it there
    (`Noise.placement_error`). `reset(options={"start": (x, y, degrees), "foods": [(x, y), ...]})` sets other marks, in
    mm of the teacher's arena; those of the learners' arenas are the same ones at their offsets.

    ## Episode end
    Terminated (complete, 5.3) when every robot has delivered its food, or left it as poisonous with its arm up again,
    and is outside its home. Truncated after `max_cycles` rounds, after `patience` rounds of a learner's separation, or
    when a real robot or camera is lost: all robots are then stopped, and the last observations repeated.

    ## Info
    Plain numbers: `state`, `correct_behaviour`, `x`, `y`, `orientation` (pixels, degrees, as the camera reports
    them), the three as `pose`, as in the recall environments, `score`, `correct`, `steps`, `delivered`,
    `poison_home`, `complete`, `separated_rounds`, `separations`; when a real robot or camera was lost also
    `robot_lost`, the reason.

    ## Arguments
    `num_learners`, `max_cycles`, `arena`, `noise`, `food_types` (all as in the recall environments; corresponding
    food of all arenas is of one type), `patience`, `render_mode`, `world` (another `World` than the simulated one,
    with an arena for each robot; give `noise=Noise.none()` with a real one, so that its operator puts everything on
    the marks themselves), `decisions` (a `Decisions`), `backend` ("pymunk", or "compiled", which needs numba), `robot`
    ("khepera", "e-puck2" or "toio"; the last two push food, and pick up none).

    ## Version history
    - v1: the default of `decisions` is `Decisions()`, as in this class: inferred from the thesis's corridor tables
      (`docs/decisions.md`).
    - v0: first version. The default of `decisions` is `Decisions.v0_1()`: those of version 0.1 of the package.
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
        noise: Noise | str | None = "laboratory",
        food_types: FoodOdds = None,
        patience: int | None = None,
        render_mode: str | None = None,
        world: World | None = None,
        decisions: Decisions | None = None,
        backend: str = PYMUNK,
        robot: str = KHEPERA.name,
    ) -> None:
        super().__init__()
        learners = whole_number("num_learners", num_learners, 1)
        self.max_cycles = whole_number("max_cycles", max_cycles, 1)
        decisions = self.default_decisions if decisions is None else decisions
        settings = Settings.of(arena, noise, food_types, decisions, robot)
        self.decisions, self._noise = settings.decisions, settings.noise
        self.metadata = self.metadata | {"render_fps": 1 / self.decisions.round_duration}
        self.patience = self.decisions.patience if patience is None else whole_number("patience", patience, 1)
        self.render_mode = render_mode
        self._screen = Screen(render_mode, self.decisions.round_duration)
        markers = (1,) + (2,) * learners  # the teacher has the marker of one hole
        self._paired = ForagingWorld(markers, settings, world, backend)
        self.np_random: np.random.Generator | None = None
        self._generator: np.random.Generator | None = None
        """The `np_random` that the attempts follow from."""
        self._key, self._episode = 0, 0
        self.possible_agents = [TEACHER, *(f"learner_{i}" for i in range(learners))]
        self.agents: list[str] = []
        self.observation_spaces = {a: self._observation_space() for a in self.possible_agents}
        self.action_spaces = {a: self._action_space() for a in self.possible_agents}
        boxes: list[Any] = list(self.observation_spaces.values())
        low, high = (np.concatenate([getattr(box, end) for box in boxes]) for end in ("low", "high"))
        self.state_space = spaces.Box(low, high, dtype=boxes[0].dtype)
        self._attempt: TrainingEpisode | None = None

    def _observation_space(self) -> spaces.Space[Any]:
        return observation_box(self._paired.diagonal)

    def _action_space(self) -> spaces.Space[Any]:
        return spaces.Discrete(len(Behaviour))

    def observation_space(self, agent: str) -> Any:
        """The space of every agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
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
        return self._paired.arenas_of(key_of(seed), 0)[0]

    @property
    def home_radius(self) -> int:
        """Of every home, in pixels."""
        return whole_pixels(self.arenas[0].home_radius)

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

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt at a training episode.

        Args:
            seed: Makes the attempt repeatable, bit for bit. Without a seed, attempts go on, or follow from an
                `np_random` that was set meanwhile.
            options: `start` (x mm, y mm, heading degrees) and `foods`, one (x mm, y mm) an object, in the teacher's
                arena; what is left out stays on the marks of figure 5.1.

        Raises:
            ValueError: Options that are unknown or place something off the free floor. The attempt then goes on.
        """
        if seed is not None or self.np_random is None:
            self.np_random, _ = seeding.np_random(seed)
        if self.np_random is not self._generator:
            self._generator = self.np_random
            self._key = key_of(int(self.np_random.integers(2**62)) if seed is None else seed)
            self._episode = 0
        key, number = self._key, self._episode
        arenas = self._paired.arenas_of(key, number)
        layout = training_layout(
            arenas_with_marks(arenas, checked_options(options)), self._noise, layout_key(key, number)
        )
        self._paired.enter(arenas)
        self.agents, self._episode = [], number + 1  # after an error from here on, another reset is needed
        self.world.reset(self.np_random.spawn(1)[0], layout)
        foragers = self._paired.foragers(layout, key, number)
        self._attempt = TrainingEpisode(self.world, foragers, self.max_cycles, self.patience, self.decisions)
        self.agents = self.possible_agents[:]
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos = {agent: self._attempt.info(i) for i, agent in enumerate(self.agents)}
        self.agent_selection = self.agents[0]
        if self.render_mode == "human":
            self.render()

    def observe(self, agent: str) -> Any:
        """What an agent perceives: its state vector, what it hears, whether it is separated; a fresh array."""
        return self._begun.observe(self.possible_agents.index(agent))

    def state(self) -> NDArray[Any]:
        """The observations of all agents in a row, for learners with a critic of all agents; a fresh array."""
        return np.concatenate([self.observe(agent) for agent in self.possible_agents])

    def step(self, action: Any) -> None:
        """The selected agent's step; the last agent's ends the round.

        Raises:
            ResetNeeded: Before the first reset.
            ValueError: An action that is not in the agent's action space.
        """
        attempt = self._begun
        if not self.agents:
            raise ResetNeeded(f"the episode ended after {attempt.account.rounds} rounds; call reset() to start another")
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            self._was_dead_step(action)
            return
        i = self.possible_agents.index(agent)
        self._take(attempt, i, self.checked_action(action, agent))
        self._cumulative_rewards[agent] = 0.0
        if i < len(attempt.foragers) - 1:
            self._clear_rewards()
            self.agent_selection = self.possible_agents[i + 1]
        else:
            self._round(attempt)
            self.agent_selection = self.agents[0]
        self._accumulate_rewards()

    def checked_action(self, action: Any, agent: str) -> Any:
        """An action, once it is known to be in the agent's action space.

        Raises:
            ValueError: It is not.
        """
        return behaviour_number(action, len(Behaviour), agent)

    def _take(self, attempt: TrainingEpisode, i: int, action: Any) -> None:
        """Take down what a robot decided on."""
        attempt.foragers[i].behaviour = action

    def resume_beside(self, agent: str) -> None:
        """Pause and resume (5.3.1): put a learner where the teacher is, in its own arena, and go on.

        A real robot or camera that is lost meanwhile ends the episode, as in a round.

        Raises:
            ValueError: Not a learner, or its arena has no room there.
        """
        learners = self.possible_agents[1:]
        if agent not in learners:
            raise ValueError(f"agent {agent!r} cannot be resumed; allowed: {', '.join(learners)}")
        try:
            self._begun.place_beside_teacher(self.possible_agents.index(agent))
        except LOST as lost:
            self._cut_short(lost)

    def _round(self, attempt: TrainingEpisode) -> None:
        """Everybody's commands take effect together."""
        try:
            over = attempt.round()
        except LOST as lost:
            self._cut_short(lost)
            return
        complete = attempt.account.complete
        if over:
            self.world.stop()
        self.rewards = {agent: attempt.foragers[i].episode.reward for i, agent in enumerate(self.agents)}
        self.terminations = dict.fromkeys(self.agents, complete)
        self.truncations = dict.fromkeys(self.agents, over and not complete)
        self.infos = {agent: attempt.info(i) for i, agent in enumerate(self.agents)}
        if self.render_mode == "human":
            self.render()

    def _cut_short(self, lost: Exception) -> None:
        """End the episode where a robot or the camera was lost; nothing new is perceived."""
        for i, agent in enumerate(self.agents):
            self.rewards[agent] = -1.0 / self.max_cycles
            self.truncations[agent] = True
            self.infos[agent] = {**self._begun.info(i), "robot_lost": str(lost)}


class CheckedActions(BaseParallelWrapper[str, Any, Any]):
    """Checks the actions of all agents before any of them acts, so that an error leaves the environment as it was."""

    def step(self, actions: Mapping[str, Any]) -> Any:
        """A round of all agents.

        Args:
            actions: One for every agent.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An agent has no action or is unknown, or an action is not in its action space.
        """
        agents = getattr(self.env, "agents", [])  # PettingZoo's own conversion has none before the first reset
        if not agents:
            raise ResetNeeded("no episode is under way; call reset() to start one")
        if set(actions) != set(agents):
            raise ValueError(f"actions are of {list(actions)}; allowed: one each of {', '.join(agents)}")
        check = self.env.unwrapped.checked_action
        checked = {agent: check(actions[agent], agent) for agent in agents}
        return super().step(checked)


AecMaker = Callable[..., AECEnv[str, Any, Any]]
ParallelMaker = Callable[..., ParallelEnv[str, Any, Any]]


def makers(raw_env: Callable[..., TrainingEnv]) -> tuple[AecMaker, ParallelMaker]:
    """The functions `env` and `parallel_env` of a module.

    Args:
        raw_env: Makes the environment without wrappers; the functions have its arguments.

    Returns:
        `env`, which checks the order of calls (actions are checked by the environment itself), and `parallel_env` with
        simultaneous actions. What a learner hears is in the latter what the teacher did a round ago.
    """

    def env(**kwargs: Any) -> AECEnv[str, Any, Any]:
        """The environment with PettingZoo's usual wrappers; the arguments are those of `raw_env`."""
        return OrderEnforcingWrapper(raw_env(**kwargs))

    def parallel_env(**kwargs: Any) -> ParallelEnv[str, Any, Any]:
        """The same with simultaneous actions. What a learner hears is then what the teacher did a round ago."""
        return CheckedActions(aec_to_parallel(env(**kwargs)))

    return env, parallel_env
