"""Every mistake raises one clear error that quotes the value and what is allowed."""

import math
import re
from collections import UserList
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from khepera_forage import Decisions, Noise
from khepera_forage.envs import paired_arenas_v1, paired_corridors_v1, paired_procedural_v1
from khepera_forage.envs import paired_corridors_wheels_v1 as wheels
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.wrappers import ActionRepeat
from tests.arenas import BLOCKS, HALL
from tests.sim.test_waypoints import CLOSED
from tests.version_0_1 import CORRIDOR, V0_1

pytest.importorskip("numba")

PROCEDURAL = "khepera_forage/Procedural-v1"


def make(name: str = "Corridor", **kwargs: Any) -> Any:
    return gym.make(f"khepera_forage/{name}-v1", disable_env_checker=True, **kwargs)


def make_vec(name: str = "Corridor", **kwargs: Any) -> Any:
    return gym.make_vec(f"khepera_forage/{name}-v1", **({"num_envs": 2} | kwargs))


MAKERS: dict[str, Callable[..., Any]] = {
    "pymunk": make,
    "compiled": partial(make, backend="compiled"),
    "vector": make_vec,
    "kernel": partial(run_teacher, episodes=1),
    "training": paired_corridors_v1.env,
    "class": BehavioursEnv,
    "arenas": paired_arenas_v1.env,
    "learners": partial(train_learners, n=1),
    "procedural": partial(gym.make, PROCEDURAL),
    "paired procedural": paired_procedural_v1.env,
    "pairs": partial(paired_corridors_v1.vector_env, 1),
}
ENVS = ("pymunk", "compiled", "vector")
RECALLS = (*ENVS, "kernel")
PAIRED = ("training", "learners", "pairs")
ALL = (*RECALLS, *PAIRED)
BACKENDS = "allowed: 'pymunk', 'compiled'"
LEAST_1 = "allowed: a whole number of at least 1"
ARENAS = "allowed: an Arena, or one of 'corridor', 'rectangle', 't_maze'"
FOODS = "allowed: a whole number from 1 to 16"
MOST = "is 10{30}; allowed: a whole number from 1 to 1,000,000,000"


class OneArena(UserList[Any]):
    """A sequence of an arena of 1304 mm that says which diagonal no arena exceeds."""

    def __init__(self, diagonal: Any) -> None:
        super().__init__([BLOCKS])
        self.diagonal = diagonal


WRONG: list[tuple[tuple[str, ...], dict[str, Any], str]] = [
    (ALL, {"food_types": "CHEESE"}, "'CHEESE'.*allowed.*PICKABLE, PUSHABLE, POISONOUS"),
    (ALL, {"food_types": {"PICKABLE": math.nan}}, "nan.*allowed: a number >= 0"),
    (ALL, {"food_types": {"PICKABLE": 0}}, "{'PICKABLE': 0}.*allowed.*at least one above 0"),
    (ALL, {"food_types": {"PICKABLE": "a"}}, "odds of PICKABLE are 'a'; allowed: a number"),
    (ALL, {"food_types": ["PICKABLE"]}, r"food type \['PICKABLE'\] is unknown; allowed: PICK"),
    *((ALL, {"noise": wrong}, "noise is .*; allowed: a Noise, 'laboratory' or 'none'") for wrong in (
        "quiet", 0.5, {"wheel_slip": 0})),
    (ALL, {"arena": "circle"}, f"arena is 'circle'; {ARENAS}"),
    (ALL, {"arena": 7}, "arena is 7; allowed: an Arena"),
    ((*RECALLS, "training"), {"arena": ()}, "at least one arena"),
    (RECALLS, {"arena": (HALL, "nowhere")}, "arena 1 of a sequence is 'nowhere'; allowed: an Arena, or one of 'corr"),
    (RECALLS, {"arena": ["corridor", 3]}, "arena 1 of a sequence is 3; allowed: an Arena, or one of 'corridor'"),
    (("pymunk",), {"arena": {**asdict(BLOCKS), "foods": []}}, "foods has 0 places"),
    ((*RECALLS, "training"), {"arena": OneArena(1300)},
     "arena 0 of a sequence has a diagonal of 1303.84 mm; allowed: at most 1300, the"),
    *((RECALLS, {"arena": OneArena(wrong)}, f"diagonal of a sequence of arenas is {wrong!r}; allowed: a finite number")
      for wrong in ("x", math.nan, math.inf, 0, -5)),
    (RECALLS, {"arena": CLOSED}, "closed: there is no way between the start"),
    (("pymunk",), {"arena": {"name": "blocks"}}, r"arena is \{'name': 'blocks'\}; allowed: an Arena"),
    (("learners",), {"arena": CORRIDOR.shifted(3000.0, 0.0)}, "what the camera sees"),
    *((ALL, {"decisions": wrong}, r"allowed: a khepera_forage\.Decisions, or None") for wrong in (
        17, "next_to_food=17", {"next_to_food": 17}, asdict(V0_1) | {"next_to_foot": 17}, Noise.none(), Decisions)),
    (RECALLS, {"foods": 17}, f"foods is 17; {FOODS}"),
    (RECALLS, {"foods": 1.5}, f"foods is 1.5; {FOODS}"),
    (("kernel",), {"foods": 16}, "no room for a robot and 16 food objects"),
    (RECALLS, {"limit": -3}, "limit is -3; allowed: a whole number"),
    (("compiled", "vector", "kernel"), {"limit": 10**30}, f"limit {MOST}"),
    *((("learners", "pairs"), {name: 10**30}, f"{name} {MOST}") for name in ("max_cycles", "patience")),
    (("pymunk", "class", "training"), {"world": 5}, "world is 5; allowed: a World"),
    (("class",), {"render_mode": "ansi"}, "'ansi'; allowed: .*rgb_array"),
    (("vector",), {"render_mode": "human"}, "render_mode is 'human'"),
    (ENVS, {"robot": "nao"}, "robot is 'nao'; allowed: 'khepera', 'e-puck2', 'toio'"),
    (ENVS, {"robot": []}, r"robot is \[\]; allowed: 'khepera'"),
    (ENVS, {"robot": "toio", "food_types": {"PICKABLE": 0.1, "PUSHABLE": 0.9}},
     "PICKABLE.*allowed for robots without a gripper: PUSHABLE and POISONOUS"),
    *((ENVS, {"backend": wrong}, BACKENDS) for wrong in ("batch", "Compiled", "", None, 1, ["compiled"])),
    (("vector",), {"backend": "pymunk"},
     "backend is 'pymunk'; allowed here: 'compiled' .*vectorization_mode='sync' or 'async'"),
    *((("vector",), {"num_envs": wrong}, f"num_envs is {wrong}; {LEAST_1}") for wrong in (0, -1, 1.5)),
    (("vector",), {"autoreset_mode": "SAME_STEP"}, "'SAME_STEP'; allowed: AutoresetMode, or 'NextStep', 'SameStep'"),
    (("vector",), {"vector_wrappers": [ActionRepeat]}, r"a single environment \(VectorActionRepeat is for many\)"),
    (("vector",), {"vector_wrappers": [print]}, "has <built-in function print>, which returns None; allowed: func"),
    (("vector",), {"max_episode_steps": 0}, f"max_episode_steps is 0; {LEAST_1}"),
    (("kernel", "learners"), {"episodes": 0}, "episodes is 0"),
    (("learners",), {"n": 0}, "n is 0"),
    (("learners",), {"seed": -1}, "seed is -1"),
    (("training", "pairs"), {"num_learners": 0}, "num_learners is 0; allowed"),
    (("training", "pairs"), {"num_learners": 99}, "num_learners is 99; allowed: at most 31, because the camera"),
    (PAIRED, {"max_cycles": 0}, "max_cycles is 0; allowed"),
    (PAIRED, {"patience": -1}, "patience is -1; allowed"),
    (("arenas",), {"arena": ["t_maze", "doors"]}, "max_cycles is None; allowed with several arenas: a whole number"),
    (("learners",), {"options": {"foods": [(90.0, 115.0)]}, "decisions": V0_1}, "overlaps"),
    (("learners",), {"options": 5}, "options is 5; allowed: a mapping"),
    (("learners",), {"options": {"place": 1}}, "reset option 'place'"),
    (("learners",), {"noise": Noise(placement_error=1e6)}, "too near a wall or each other for a placement error"),
    (("procedural", "paired procedural"), {"split": "dev"}, "split is 'dev'; allowed: 'train', 'test'"),
    (("procedural", "paired procedural"), {"arena": "corridor"}, "arena is 'corridor'; allowed here: none"),
    (("procedural",), {"foods": 3}, "foods is 3; allowed here: none"),
    (("procedural",), {"difficulty": asdict(DIFFICULTIES["easy"]) | {"food_types": "NONE"}}, "food type 'NONE'"),
]  # fmt: skip


@pytest.mark.parametrize(("makers", "kwargs", "message"), WRONG, ids=lambda value: str(value)[:60])
def test_wrong_arguments_are_refused(makers: tuple[str, ...], kwargs: dict[str, Any], message: str) -> None:
    for maker in makers:
        with pytest.raises(ValueError, match=message) as error:
            MAKERS[maker](**kwargs)
        if kwargs.keys() <= {"decisions", "backend"}:
            assert repr(*kwargs.values()) in str(error.value)


Form = tuple[Callable[[], Any], list[Any], str, list[Any], str]
"""A form of environment: how it is made, actions to its end, how the next step is then refused, and wrong ones."""

BEHAVIOURS = [10, -1, 2.5, math.nan, None, "3", True, np.array([1, 2])]
WHEELS = [[0, 0, 0], [2, 0, 0, 0], [math.nan, 0, 0, 0], [math.inf] * 4, "drive", None]
SAID: Any = {"teacher_0": 0, "learner_0": 0}
EACH = {agent: [0, 1] for agent in SAID}
WHOLE_10 = "{wrong!r}; allowed: a whole number from 0 to 10"
ONE_EACH = r"actions are of \[.*\]; allowed: one each of teacher_0, learner_0"
NUMBER_9, FOUR = "{wrong!r}; allowed: a whole number from 0 to 9", r"allowed: four numbers in -1\.\.1"


def single(action: Any, wrong: list[Any], message: str, name: str = "Corridor", backend: str = "pymunk") -> Form:
    made = partial(make, name, backend=backend, limit=2)
    return made, [action] * 2, "ended after 2 steps", wrong, message


FORMS: dict[str, Form] = {
    "pymunk": single(3, BEHAVIOURS, NUMBER_9),
    "compiled": single(3, BEHAVIOURS, NUMBER_9, backend="compiled"),
    "wheels on pymunk": single(np.zeros(4), WHEELS, FOUR, "CorridorWheels"),
    "compiled wheels": single(np.zeros(4), WHEELS, FOUR, "CorridorWheels", "compiled"),
    "vector": (partial(make_vec, num_envs=5), [np.zeros(5, np.int64)], "",
               [np.zeros(4, np.int64), np.full(5, 10), np.zeros(5)], "allowed: 5 whole numbers from 0 to 9"),
    "vector of wheels": (partial(make_vec, "CorridorWheels"), [np.zeros((2, 4))], "", [np.full((2, 4), 1.5)],
                         r"allowed: numbers in -1\.\.1"),
    "training": (partial(paired_corridors_v1.raw_env, max_cycles=1), [10, 10, None, None], "ended after 1 rounds",
                 [11, -1, 2.5, "search"], f"action of teacher_0 is {WHOLE_10}"),
    "parallel": (partial(paired_corridors_v1.parallel_env, max_cycles=1), [SAID], "call reset",
                 [{}, {"teacher_0": 0}, SAID | {"learner_1": 0}], ONE_EACH),
    "parallel, one wrong": (partial(paired_corridors_v1.parallel_env, max_cycles=1), [SAID], "call reset",
                            [SAID | {"learner_0": 11}, SAID | {"learner_0": None}],
                            "action of learner_0 is (11|None); allowed: a whole number from 0 to 10"),
    "parallel wheels": (partial(wheels.parallel_env, max_cycles=1), [dict.fromkeys(SAID, np.ones(4))], "call reset",
                        [dict.fromkeys(SAID, np.full(4, 2.0))], f"action of teacher_0 is .*{FOUR}"),
    "pairs": (partial(paired_corridors_v1.vector_env, 2), [EACH], "",
              [{}, {"teacher_0": [0, 1]}, EACH | {"learner_0": [0, 11]}, EACH | {"learner_0": [0]}], "allowed: "),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_wrong_actions_change_nothing_and_steps_need_an_episode(form: str) -> None:
    maker, actions, ended, wrong, message = FORMS[form]
    env, other = maker(), maker()
    with pytest.raises(ResetNeeded):
        env.step(actions[0])
    env.reset(seed=1)
    other.reset(seed=1)
    for action in wrong:
        with pytest.raises(ValueError, match=message.replace("{wrong!r}", re.escape(repr(action)))):
            env.step(action)
    for action in actions:
        np.testing.assert_equal(env.step(action), other.step(action))
        if form == "training" and env.agents:
            np.testing.assert_equal(env.last(), other.last())
    if ended:
        with pytest.raises(ResetNeeded, match=ended):
            env.step(actions[0])


def test_wrong_seeds_and_masks_of_many_worlds_are_refused() -> None:
    env = make_vec(num_envs=5)
    with pytest.raises(ResetNeeded, match="reset_mask"):
        env.reset(options={"reset_mask": np.ones(5, np.bool_)})
    env.reset(seed=0)
    with pytest.raises(ValueError, match="reset_mask is"):
        env.reset(options={"reset_mask": np.zeros(5, np.bool_)})
    with pytest.raises(ValueError, match="4 seeds for 5 worlds"):
        env.reset(seed=[1, 2, 3, 4])
    for wrong in (-1, 1.5):
        with pytest.raises(ValueError, match=f"seed is {wrong}; allowed: a whole number of at least 0"):
            env.reset(seed=[1, wrong, None, 3, 4])


@pytest.mark.parametrize("maker", ENVS)
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"foods": [(300, 300), (310, 300)]}, r"food at \(310, 300\) mm overlaps food at \(300, 300\) mm"),
        ({"start": (300, 300, 0), "foods": [(325, 300), (500, 100)]}, "overlaps robot at .*: at least 45 mm apart"),
        ({"start": (10, 300, 0)}, r"start at \(10, 300\) mm is 10 mm from a wall"),
        ({"start": (0, 0, 0)}, "start at .* allowed: on the floor"),
        ({"start": (1, 2)}, "allowed: .x mm, y mm, heading degrees."),
        ({"start": None}, "'start' has None; allowed: .x mm, y mm, heading degrees."),
        ({"foods": 5}, "'foods' has 5; allowed: .x mm, y mm."),
        ({"foods": [(5, 5), (300, 300)]}, "food at .5, 5. mm"),
        ({"foods": [(math.nan, 5), (300, 300)]}, "nan.*finite"),
        ({"foods": [(300, 300)]}, "1 foods given; allowed: 2"),
        (5, "options is 5; allowed: a mapping of 'start' and 'foods'"),
        ({"food": [(300, 300)]}, "reset option 'food' is unknown; allowed: 'start', 'foods'"),
    ],
)
def test_wrong_reset_options_are_refused_and_the_episode_goes_on(maker: str, options: Any, message: str) -> None:
    env, other = MAKERS[maker]("Rectangle"), MAKERS[maker]("Rectangle")
    env.reset(seed=1)
    other.reset(seed=1)
    with pytest.raises(ValueError, match=message):
        env.reset(seed=2, options=options)
    action = env.action_space.sample()
    np.testing.assert_equal(env.step(action), other.step(action))


@pytest.mark.parametrize("maker", ENVS)
def test_arena_without_room_is_refused_and_the_episode_goes_on(maker: str) -> None:
    env, other = (MAKERS[maker](foods=5, limit=3) for _ in range(2))
    with pytest.raises(ValueError, match="no room for a robot and 5 food objects"):
        env.reset(seed=2)
    np.testing.assert_equal(env.reset(seed=0), other.reset(seed=0))
    for seed in (2, None, None):
        with pytest.raises(ValueError, match="no room"):
            env.reset(seed=seed)
        action = env.action_space.sample()
        np.testing.assert_equal(env.step(action), other.step(action))
    if maker == "vector":  # the next episode of the first world has no room
        other.reset(seed=0)
        for _ in range(3):
            other.step(action)
        with pytest.raises(ValueError, match="no room"):
            other.step(action)
        with pytest.raises(ResetNeeded):
            other.step(action)
        other.reset(seed=0)


def test_pairs_whose_marks_have_no_room_need_a_reset() -> None:
    env = paired_corridors_v1.vector_env(1, noise=Noise(placement_error=1e6))
    with pytest.raises(ValueError, match="too near a wall"):
        env.reset(seed=0)
    with pytest.raises(ResetNeeded):
        env.step({agent: [0] for agent in SAID})
