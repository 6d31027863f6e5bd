"""Compiled paired arenas: the training phase of the thesis (4.5, 5.2, 5.3), many attempts at a time.

Each robot has a world of its own, a copy of the arena at its offset under the same camera, with its own walls, home
and marker. Marker and food of one are never hidden by, or under the cable of, the robot of another: the gap between
the arenas is wider than a marker reaches, and the cables hang from its middle. So the worlds share nothing but what
learners hear, where the teacher is, and the types of corresponding food.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from khepera_forage.compilation import entry, rule, share_out
from khepera_forage.counter_rng import keys_of, random_bits
from khepera_forage.envs.arguments import FoodOdds, Settings, checked_arena, whole_number
from khepera_forage.envs.compiled.arenas import MOST_ROUNDS, arena_at, arena_block, ground_of, map_of, settings_record
from khepera_forage.envs.compiled.step import (
    WorldRecords,
    carry_out,
    drive,
    motors_of,
    new_worlds,
    stand_ready,
    world_of,
)
from khepera_forage.envs.layouts import (
    arena_map_of,
    arenas_with_marks,
    checked_options,
    no_room_on_marks,
    paired_copies,
)
from khepera_forage.envs.training_episode import observation_box
from khepera_forage.noise import Noise
from khepera_forage.records import dtype_of
from khepera_forage.robots.model import KHEPERA
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.layout_checks import cable_anchor, check_layout
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.episode import has_done_its_part
from khepera_forage.task.food_tracking import share_identified
from khepera_forage.task.pairing import AttemptState, Pairing, end_round, lead, update_pairing
from khepera_forage.task.placement import Place, Start, draw_food_types, food_type_key, layout_key, place_by_hand
from khepera_forage.task.states import Behaviour

_LEAST = 256
"""Pairs for which another thread pays."""
_WAIT = Behaviour.WAIT.value
pairing_dtype = dtype_of(Pairing)


class Sides(NamedTuple):
    """What paired worlds have in common; one element of each array a robot, the teacher's first.

    Attributes:
        blocks: Bytes of the arenas, see `arena_at`.
        places: Where the block of each begins.
        settings: `settings_dtype` records.
        marks: `Start` records: where the robots are put down.
        food_marks: `Place` records, shape (robots, foods): where food is put down.
    """

    blocks: Any
    places: Any
    settings: Any
    marks: Any
    food_marks: Any


def paired_sides(
    robots: int, settings: Settings, max_cycles: int, patience: int | None, options: Mapping[str, Any] | None = None
) -> tuple[tuple[Arena, ...], Sides, NDArray[Any]]:
    """The copies of an arena, one a robot; what their worlds have in common; and one `AttemptState` record.

    The arguments are those of `rollouts.compiled.training.train_learners`, and how many robots there are.

    Raises:
        ValueError: An argument out of range, arenas out of sight, or marks that nothing can stand on.
    """
    noise, decisions = settings.noise, settings.decisions
    arena: Any = settings.arena
    arenas = tuple(arenas_with_marks(paired_copies(checked_arena(arena, decisions), robots), checked_options(options)))
    check_layout(arenas, Layout(tuple(a.start for a in arenas), tuple(food for a in arenas for food in a.foods)))
    foods, anchor = len(arenas[0].foods), cable_anchor(arenas)
    blocks = [arena_block(side, anchor) for side in arenas]
    # The teacher has the marker of one hole.
    records = [settings_record(settings, foods, max_cycles, holes=min(i + 1, 2)) for i in range(robots)]
    attempt = np.zeros(1, dtype_of(AttemptState))
    attempt["limit"] = max_cycles
    patience = decisions.patience if patience is None else patience
    attempt["patience"] = whole_number("patience", patience, 1, MOST_ROUNDS)
    attempt["error"], attempt["heading_error"] = (noise.placement_error, np.radians(noise.placement_heading_error))
    sides = Sides(
        np.concatenate(blocks),
        np.cumsum([0, *map(len, blocks[:-1])]),
        np.concatenate(records),
        np.array([tuple(side.start) for side in arenas], dtype_of(Start)),
        np.array([[tuple(food) for food in side.foods] for side in arenas], dtype_of(Place)),
    )
    return arenas, sides, attempt


@rule
def put_on_marks(worlds: WorldRecords, first: int, sides: Sides, attempt: Any, pairings: Any, key: Any) -> bool:
    """Begin an attempt: robots and food on their marks, as well as an operator can put them there.

    Args:
        worlds: Of the robots, the teacher's the one with number `first`.
        first: See there.
        sides: What they have in common.
        attempt: The `AttemptState` record.
        pairings: `Pairing` records, one a robot.
        key: Of the attempt's random numbers.

    Returns:
        Whether there was room.
    """
    attempt.rounds, attempt.since_done, attempt.complete = 0, 0, False
    room = True
    for j in range(len(sides.settings)):
        pairings[j].separated, pairings[j].separated_rounds, pairings[j].separations = False, 0, 0
        world, settings = world_of(worlds, first + j), sides.settings[j]
        robot = world.robots[0]
        robot.key, robot.round = random_bits(key, j), 0
        room &= place_by_hand(
            robot,
            world.foods,
            random_bits(layout_key(key, 0), j),
            sides.marks[j],
            sides.food_marks[j],
            attempt.error,
            attempt.heading_error,
            ground_of(arena_at(sides.blocks, sides.places[j])),
        )
        stand_ready(world, settings)
        draw_food_types(world.objects, food_type_key(key, 0), settings.odds)
    return room


@rule
def carry_out_pair(worlds: WorldRecords, first: int, sides: Sides, attempt: Any, pairings: Any, actions: Any) -> bool:
    """One round of paired robots; returns whether the attempt has ended. Its first round only takes the first frame.

    Arguments as for `put_on_marks`; `actions` has the behaviour of each robot.
    """
    robots, teacher = len(sides.settings), worlds.raw[first, 0]
    begins = worlds.robots[first, 0].first_frame
    for j in range(robots):
        world, settings = world_of(worlds, first + j), sides.settings[j]
        arena = arena_at(sides.blocks, sides.places[j])
        motors = motors_of(world, map_of(arena), settings, actions[j])
        if j > 0:
            motors = lead(pairings[j], motors, actions[j], world.raw[0], settings.decisions)
        drive(world, motors, actions[j])
        carry_out(world, arena, settings)
        # What one identifies, the next ones know at once, and the others a round later.
        for other in range(robots):
            if other != j:
                share_identified(world.objects, worlds.objects[first + other])
    done, longest = True, 0
    decisions, teacher_map = sides.settings[0].decisions, map_of(arena_at(sides.blocks, sides.places[0]))
    for j in range(robots):
        forager = worlds.foragers[first + j, 0]
        if j > 0:
            own_map = map_of(arena_at(sides.blocks, sides.places[j]))
            update_pairing(pairings[j], worlds.raw[first + j, 0], own_map, teacher, teacher_map, decisions)
            longest = max(longest, pairings[j].separated_rounds)
        done &= has_done_its_part(
            worlds.trackers[first + j, 0], worlds.objects[first + j], forager.vector, teacher_map.home_radius, decisions
        )
    if begins:
        return False
    attempt.rounds += 1
    return bool(end_round(attempt, done, longest, decisions))


@entry
def _step_pairs(
    first: int,
    last: int,
    worlds: WorldRecords,
    sides: Sides,
    attempts: Any,
    pairings: Any,
    keys: Any,
    actions: Any,
    waiting: Any,
    free: Any,
) -> None:
    """One round of the pairs from `first` to `last`, or the start of an attempt where they wait for one.

    Afterwards those wait whose attempt has ended.
    """
    robots = len(sides.settings)
    for i in range(first, last):
        attempt = attempts[i]
        if waiting[i]:
            key = random_bits(keys[i], attempt.number)
            attempt.number += 1
            free[i] = put_on_marks(worlds, i * robots, sides, attempt, pairings[i], key)
            for j in range(robots):
                actions[i, j] = _WAIT
        waiting[i] = carry_out_pair(worlds, i * robots, sides, attempt, pairings[i], actions[i])


class PairedBatch:
    """Paired corridors by the thousand, for learners that train all agents together: `parallel_env` for many pairs.

    Agents, spaces, rewards and the ends of attempts are those of `paired_corridors_v1.parallel_env`. Observations,
    rewards and so on are dictionaries by agent with one row a pair. What a learner hears is what the teacher did a
    round ago. After the end of an attempt the next step ignores the actions of that pair and begins its next attempt.
    There are `num_envs` teachers with their learners, in copies of one arena; the other arguments are as there.

    Attributes:
        possible_agents: Names of the agents, the teacher first.

    Raises:
        ValueError: An argument out of range.
    """

    def __init__(
        self,
        num_envs: int,
        num_learners: int = 1,
        max_cycles: int = 600,
        arena: Arena | str = "corridor",
        noise: Noise | str | None = "laboratory",
        food_types: FoodOdds = None,
        patience: int | None = None,
        decisions: Decisions | None = None,
        robot: str = KHEPERA.name,
    ) -> None:
        self.num_envs = whole_number("num_envs", num_envs, 1)
        self.max_cycles = whole_number("max_cycles", max_cycles, 1, MOST_ROUNDS)
        robots = whole_number("num_learners", num_learners, 1) + 1
        self._settings = Settings.of(arena, noise, food_types, decisions, robot)
        self.decisions = self._settings.decisions
        self.possible_agents = ["teacher_0", *(f"learner_{i}" for i in range(robots - 1))]
        self._arenas, self._sides, attempt = paired_sides(robots, self._settings, self.max_cycles, patience)
        self._worlds = new_worlds(self.num_envs * robots, len(self._arenas[0].foods))
        self._attempts = np.repeat(attempt, self.num_envs)
        self._pairings = np.zeros((self.num_envs, robots), pairing_dtype)
        self._actions = np.full((self.num_envs, robots), _WAIT)
        self._waiting, self._free = np.ones(self.num_envs, np.bool_), np.ones(self.num_envs, np.bool_)
        self._keys: NDArray[np.uint64] | None = None
        self._space = observation_box(arena_map_of(self._arenas[0]).diagonal)

    def observation_space(self, agent: str) -> spaces.Box:
        """The space of one row of an agent's observations."""
        return self._space

    def action_space(self, agent: str) -> spaces.Discrete:
        """The space of one of an agent's actions."""
        return spaces.Discrete(len(Behaviour))

    def reset(self, seed: int | None = None) -> tuple[dict[str, NDArray[np.int64]], dict[str, dict[str, NDArray[Any]]]]:
        """Begin a new attempt in every pair.

        Args:
            seed: Pair i then has the attempts of learner i of `train_learners(seed=seed)`. Without a seed, attempts
                go on.

        Returns:
            Observations and infos by agent.
        """
        if seed is None and self._keys is None:
            seed = int(np.random.SeedSequence().generate_state(1)[0])
        if seed is not None:
            first = whole_number("seed", seed, 0)
            self._keys = random_bits(keys_of(range(first, first + self.num_envs)), np.uint64(1))
            self._attempts["number"] = 0
        self._waiting[:] = True
        self._run()
        return self._observations(), self._infos()

    def step(
        self, actions: Mapping[str, ArrayLike]
    ) -> tuple[
        dict[str, NDArray[np.int64]],
        dict[str, NDArray[np.float64]],
        dict[str, NDArray[np.bool_]],
        dict[str, NDArray[np.bool_]],
        dict[str, dict[str, NDArray[Any]]],
    ]:
        """One round of every pair.

        Args:
            actions: For each agent one behaviour a pair, 0 to 10.

        Returns:
            Observations, rewards, terminations (the attempt is complete), truncations and infos, by agent.

        Raises:
            ResetNeeded: Before the first reset.
            ValueError: An agent has no actions or is unknown, or an action is not in its space; or marks had no room,
                and all pairs need a reset.
        """
        if self._keys is None:
            raise ResetNeeded("no episode is under way; call reset() to start one")
        if set(actions) != set(self.possible_agents):
            raise ValueError(
                f"actions are of {list(actions)}; allowed: one array each of {', '.join(self.possible_agents)}"
            )
        given = np.empty_like(self._actions)
        for j, agent in enumerate(self.possible_agents):
            own = np.asarray(actions[agent])
            if own.shape != (self.num_envs,) or own.dtype.kind not in "iu" or own.min() < 0 or own.max() > _WAIT:
                raise ValueError(
                    f"actions of {agent} are {actions[agent]!r}; allowed: {self.num_envs} whole numbers from 0 "
                    f"to {_WAIT}"
                )
            given[:, j] = own
        self._actions[:] = given
        self._run()
        complete = self._attempts["complete"] & self._waiting
        truncated = self._waiting & ~complete
        rewards = self._of_robots(self._worlds.foragers["episode"]["reward"]).copy()
        agents = self.possible_agents
        return (
            self._observations(),
            {agent: rewards[:, j] for j, agent in enumerate(agents)},
            {agent: complete.copy() for agent in agents},
            {agent: truncated.copy() for agent in agents},
            self._infos(),
        )

    def state(self) -> NDArray[np.int64]:
        """The observations of all agents in a row, one row a pair, for learners with a critic of all agents."""
        return np.concatenate(list(self._observations().values()), axis=1)

    def close(self) -> None:
        """Nothing is open."""

    def _run(self) -> None:
        share_out(
            _step_pairs,
            self.num_envs,
            *(self._worlds, self._sides, self._attempts, self._pairings, self._keys),
            *(self._actions, self._waiting, self._free),
            least=_LEAST,
        )
        if not self._free.all():
            self._keys = None  # another reset is needed
            raise no_room_on_marks(self._arenas[0], self._settings.noise)

    def _of_robots(self, values: NDArray[Any]) -> NDArray[Any]:
        """A field of records of robots, shape (pairs, robots)."""
        return values.reshape(self.num_envs, -1)

    def _observations(self) -> dict[str, NDArray[np.int64]]:
        vectors, separated = self._worlds.foragers["vector"], self._pairings["separated"].copy()
        separated[:, 0] = separated.any(axis=1)
        rows = np.empty((*self._actions.shape, 7), np.int64)
        for k, name in enumerate(vectors.dtype.names):
            rows[..., k] = self._of_robots(vectors[name])
        rows[..., 5], rows[..., 6] = self._actions[:, :1], separated
        rows[:, 0, 5] = _WAIT
        return {agent: rows[:, j] for j, agent in enumerate(self.possible_agents)}

    def _infos(self) -> dict[str, dict[str, NDArray[Any]]]:
        """What an attempt counts, by agent: numbers of the agent's own, but for `complete` and `steps`."""
        foragers, robots, common = self._worlds.foragers, self._worlds.robots, self._attempts
        fields = {
            "correct_behaviour": foragers["state"],
            "x": robots["marker_x"],
            "y": robots["marker_y"],
            "orientation": robots["marker_heading"],
            "delivered": foragers["episode"]["delivered"],
            "poison_home": foragers["episode"]["poison_home"],
        }
        own = {name: self._of_robots(values).copy() for name, values in fields.items()}
        own |= {name: self._pairings[name].copy() for name in ("separations", "separated_rounds")}
        return {
            agent: {name: values[:, j] for name, values in own.items()}
            | {"steps": common["rounds"].copy(), "complete": common["complete"].copy()}
            for j, agent in enumerate(self.possible_agents)
        }
