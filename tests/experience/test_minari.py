"""Conversion of experience to a Minari dataset and back."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import minari
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from khepera_forage.envs import backends
from khepera_forage.envs.arena_settings import settings_of
from khepera_forage.envs.backends import EntryPoint
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.experience import Experience, ExperienceError
from khepera_forage.experience.minari import from_minari, to_minari
from khepera_forage.policies import NearestNeighbourImitator, Teacher, state_vector_of
from khepera_forage.rollouts.raw_episodes import teacher_alone
from khepera_forage.sim.arenas.procedural import LEVELS
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import StateVector
from tests.arenas import BLOCKS

OTHER = Decisions(next_to_food=17, equal_distance="farther state")
VECTORS = st.builds(
    lambda home, thing, arm, food: StateVector(int(thing > 0), home, max(thing - 1, 0), arm, food),
    st.integers(0, 138),
    st.integers(0, 4),
    st.integers(215, 255),
    st.integers(0, 138),
)
EXPERIENCE = st.builds(
    lambda rows, seed, episodes, decisions: Experience(
        [vector for vector, _ in rows], [heard for _, heard in rows], "corridor", seed, episodes, decisions
    ),
    st.lists(st.tuples(VECTORS, st.integers(0, 9)), min_size=1, max_size=12),
    st.none() | st.integers(-(10**30), 10**30),
    st.integers(1, 9),
    st.sampled_from([Decisions(), OTHER, None]),
)
SOME = Experience([(0, 60, 0, 215, 40), (0, 60, 0, 255, 18)], [0, 2], "corridor", 7)
# Minari warns if these are missing.
ABOUT: dict[str, Any] = dict.fromkeys(
    ("author", "author_email", "code_permalink", "algorithm_name", "description"), "nobody"
)


@pytest.fixture(autouse=True)
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))


@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(EXPERIENCE, min_size=1, max_size=4))
def test_conversion_to_minari_and_back_gives_equal_experience(parts: list[Experience]) -> None:
    dataset = to_minari(parts, "khepera/back-v0", allow_other_decisions=True)
    try:
        assert dataset.total_episodes == len(parts)
        assert dataset.total_steps == sum(map(len, parts))
        assert from_minari(dataset) == parts
        assert from_minari("khepera/back-v0") == parts
    finally:
        minari.delete_dataset("khepera/back-v0")


def test_dataset_has_the_spaces_of_its_environment() -> None:
    other = Experience([(1, 60, 1, 215, 40)], [7], "corridor")
    dataset = to_minari([SOME, other], "khepera/corridor-v0", author="somebody", description="two episodes")
    env = dataset.recover_environment()
    assert env.spec.id == "khepera_forage/Corridor-v1"
    assert dataset.observation_space == env.observation_space
    assert dataset.action_space == env.action_space
    assert dataset.storage.metadata["author"] == {"somebody"}
    for episode, part in zip(dataset.iterate_episodes(), [SOME, other], strict=True):
        assert len(episode.actions) == len(episode.rewards) == len(part)
        assert episode.terminations.tolist() == [False] * (len(part) - 1) + [True]
        assert not episode.truncations.any()
        for i in range(len(part) + 1):
            shown = {
                key: values[i] if values.ndim > 1 else np.int64(values[i])
                for key, values in episode.observations.items()
            }
            assert env.observation_space.contains(shown)
            assert state_vector_of(shown) == part.vectors[min(i, len(part) - 1)]
        assert all(env.action_space.contains(action) for action in episode.actions)
    env.close()


def test_episode_without_decisions_has_those_of_its_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    v1 = Decisions(patience=7)
    monkeypatch.setattr(backends, "behaviours_v1", EntryPoint(BehavioursEnv, v1))
    dataset = to_minari([SOME], "khepera/plain-v0")
    options = {"options": {"arena": "corridor"}}
    monkeypatch.setattr(dataset.storage, "get_episode_metadata", lambda indices: [options])
    given = gym.make("khepera_forage/Corridor-v1", decisions=OTHER).spec
    assert given is not None
    for spec, decisions in (
        (gym.spec("khepera_forage/Corridor-v0"), Decisions.v0_1()),
        (gym.spec("khepera_forage/Corridor-v1"), v1),
        (given, OTHER),
        (EnvSpec.from_json(given.to_json()), OTHER),
        (gym.spec("CartPole-v1"), Decisions.v0_1()),
        (None, Decisions.v0_1()),
    ):
        monkeypatch.setattr(dataset, "_env_spec", spec)
        (part,) = from_minari(dataset)
        assert part.decisions == decisions


def of_another_recorder(dataset_id: str, env: str, observations: Any, actions: Any) -> Any:
    """A dataset with one episode, as another program records it."""
    count = len(actions)
    buffer = minari.data_collector.EpisodeBuffer(
        observations=observations,
        actions=actions,
        rewards=[0.0] * count,
        terminations=[False] * count,
        truncations=[False] * (count - 1) + [True],
    )
    return minari.create_dataset_from_buffers(dataset_id=dataset_id, buffer=[buffer], env=env, eval_env=env, **ABOUT)


def test_dataset_from_another_recorder_trains_the_imitator() -> None:
    """The dataset holds an episode of the teacher in the rectangle, recorded step by step."""
    env = gym.make("khepera_forage:khepera_forage/Rectangle-v1")
    observation, _ = env.reset(seed=2)
    shown, done = [observation], []
    for _ in range(40):
        done.append(int(Teacher.of(env).act(shown[-1])))
        shown.append(env.step(done[-1])[0])
    env.close()
    observations = {key: [one[key] for one in shown] for key in observation}
    of_another_recorder("elsewhere-v0", "khepera_forage/Rectangle-v1", observations, done)
    (part,) = from_minari("elsewhere-v0")
    assert part.arena == "rectangle"
    assert list(part) == [(state_vector_of(one), heard) for one, heard in zip(shown, done, strict=False)]
    imitator = NearestNeighbourImitator(diagonal=177).fit(*part.arrays())
    assert imitator.act(shown[0], np.random.default_rng(0)) == done[0]


def in_arena(name: str, vector: tuple[int, ...] = SOME.vectors[0], **about: Any) -> Experience:
    """One vector of experience."""
    return Experience([vector], [0], name, **about)


LEVELS_OF_TWO = [in_arena("procedural_easy_3"), in_arena("procedural_hard_3")]
NO_ARENA = "; allowed: one arena, of corridor, rectangle, t_maze"


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ([], "[] experience vectors; allowed: at least one in each"),
        ([SOME, Experience([], [])], "[2, 0] experience vectors; allowed: at least one in each"),
        ([SOME, in_arena("rectangle")], "['corridor', 'rectangle']" + NO_ARENA),
        ([in_arena("garden")], "['garden']" + NO_ARENA),
        (LEVELS_OF_TWO, "['procedural_easy_3', 'procedural_hard_3']" + NO_ARENA),
        ([in_arena("procedural_easy_9999999")], NO_ARENA),
        ([in_arena("procedural_mine_5")], NO_ARENA),
        ([in_arena("corridor", (0, 177, 0, 215, 1))], "robot_home_distance is 177..177; allowed: 0..138"),
        (
            [SOME, in_arena("corridor", decisions=Decisions(separation=20))],
            "recorded under other decisions: separation is 20, not 14; allowed: the same",
        ),
    ],
)
def test_experience_that_has_no_environment_is_an_error(parts: list[Experience], message: str) -> None:
    with pytest.raises(ExperienceError, match=re.escape(message)):
        to_minari(parts, "khepera/bad-v0")
    with pytest.raises(ExperienceError, match="experience 0: 1 rewards with 2 actions; allowed: equal numbers"):
        to_minari([SOME], "khepera/bad-v0", rewards=[[0.5]])


@pytest.mark.parametrize("name", ["khepera/some", "k/some-v0", "../some-v0"])
def test_bad_name_of_a_dataset_leaves_nothing(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=f"dataset_id is '{name}'; allowed: NAME-vNUMBER"):
        to_minari([SOME], name)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["rectangle", "doors", "mixed_foods"])
def test_recovered_environment_has_the_named_arena(name: str) -> None:
    part = Experience(SOME.vectors, SOME.behaviours, name, decisions=OTHER)
    to_minari([part], "khepera/named-v0")
    dataset = minari.load_dataset("khepera/named-v0")
    env = dataset.recover_environment().unwrapped
    assert (env.arena.name, env.decisions) == (name, OTHER)
    assert {"arena": name}.items() <= settings_of(name).items()
    assert (env.foods, env.limit) == (settings_of(name)["foods"], settings_of(name)["limit"])
    assert from_minari(dataset) == [part]


@pytest.mark.parametrize(("first", "split"), [(0, "train"), (LEVELS, "test")])
def test_recovered_environment_has_the_levels_of_the_experience(first: int, split: str) -> None:
    parts = [Experience(SOME.vectors, SOME.behaviours, f"procedural_hard_{first + level}") for level in (7, 3)]
    to_minari(parts, "khepera/levels-v0")
    dataset = minari.load_dataset("khepera/levels-v0")
    env = dataset.recover_environment()
    assert {"split": split, "start_level": 3, "num_levels": 5}.items() <= env.spec.kwargs.items()
    names = set()
    for seed in range(12):
        env.reset(seed=seed)
        names.add(env.unwrapped.arena.name)
    assert len(names) > 1
    assert names <= {f"procedural_hard_{first + level}" for level in range(3, 8)}
    assert from_minari(dataset) == parts


@pytest.mark.parametrize("arena", [BLOCKS, {"name": "blocks"}, "blocks"])
def test_episode_without_an_arena_has_that_of_its_environment(arena: object, monkeypatch: pytest.MonkeyPatch) -> None:
    dataset = to_minari([SOME], "khepera/plain-v0")
    monkeypatch.setattr(dataset.storage, "get_episode_metadata", lambda indices: [{}])
    spec = replace(gym.spec("khepera_forage/Corridor-v1"), kwargs={"arena": arena})
    monkeypatch.setattr(dataset, "_env_spec", spec)
    assert from_minari(dataset)[0].arena == "blocks"


def test_dataset_without_state_vectors_is_an_error() -> None:
    dataset = of_another_recorder("no-v0", "CartPole-v1", np.zeros((3, 4), np.float32), np.zeros(2, np.int64))
    with pytest.raises(ExperienceError, match="episode 0: the dataset has no arena; pass arena="):
        from_minari(dataset)
    with pytest.raises(ExperienceError, match="episode 0 has no state vectors"):
        from_minari(dataset, arena="corridor")


@pytest.mark.parametrize("wheels", [False, True])
def test_an_episode_out_of_time_is_truncated(wheels: bool) -> None:
    env = WheelsEnv(limit=10)
    part, raw = teacher_alone(env, 0)
    env.close()
    given: dict[str, Any] = (
        {"episodes": [raw]} if wheels else {"rewards": [raw.rewards_of_vectors], "truncated": [raw.truncated]}
    )
    (episode,) = to_minari([part], "cut-v0", **given, **ABOUT).iterate_episodes()
    assert (len(episode.rewards), episode.terminations.any()) == (10, False)
    assert episode.truncations.tolist() == [False] * 9 + [True]
