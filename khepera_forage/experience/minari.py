"""Experience as a Minari data set, the standard of offline learning, and back (extra `minari`).

An experience file becomes an episode: observations and actions as `Corridor-v0` or `Rectangle-v0` have them, so that
whatever learns from Minari data sets can forage there. Where Minari keeps its data sets, its variable
MINARI_DATASETS_PATH says.
"""

import warnings
from collections.abc import Iterable
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

import khepera_forage  # noqa: F401 - registers the environments, whose spaces the data set takes
from khepera_forage.experience import Experience, ExperienceError
from khepera_forage.task.states import StateVector

FLAT = ("object_presence", "food_type")
"""Attributes that the environments show as a number; the others are arrays of one."""


def to_minari(experiences: Iterable[Experience], dataset_id: str, **about: Any) -> Any:
    """Write experience as a new Minari data set, one episode each.

    What experience does not hold is filled in: the reward is 0 everywhere, the last observation is there twice (Minari
    has one more observation than actions), and the last step terminates, as incomplete episodes are not kept (5.2).

    Args:
        experiences: At least one vector each, all of the same arena.
        dataset_id: As Minari has it, such as `khepera/corridor-v0`.
        **about: More for Minari's metadata: `author`, `author_email`, `code_permalink`, `description`.

    Returns:
        The `minari.MinariDataset`.

    Raises:
        ExperienceError: No experience, an empty one, different arenas, one that no environment has, or a value that
            its environment does not show.
        ImportError: Minari is not installed; the message says how to install it.
        ValueError: Minari has a data set of that name, or the name is none.
    """
    minari = _minari()
    parts = list(experiences)
    if not parts or not all(parts):
        raise ExperienceError(
            f"{[len(part) for part in parts]} experience vectors; allowed: at least one in each"
        )
    arenas = sorted({part.arena for part in parts})
    if len(arenas) > 1 or arenas[0] not in ("corridor", "rectangle"):
        raise ExperienceError(f"experience of {arenas}; allowed: one arena, corridor or rectangle")
    import gymnasium as gym

    env = gym.make(f"khepera_forage/{arenas[0].capitalize()}-v0")
    buffers = [_buffer(minari, number, part, env.observation_space) for number, part in enumerate(parts)]
    about.setdefault("algorithm_name", "the teacher, heard in training")
    with warnings.catch_warnings():
        # It asks for an author and a link to code, which a private data set does not need.
        warnings.filterwarnings("ignore", "`.*` is set to None", UserWarning)
        return minari.create_dataset_from_buffers(dataset_id=dataset_id, buffer=buffers, env=env, **about)


def from_minari(dataset: Any, arena: str | None = None) -> list[Experience]:
    """Read a Minari data set as experience, one for each episode.

    Args:
        dataset: Its name, or a `minari.MinariDataset`; of `to_minari`, or recorded in an environment that shows state
            vectors and takes behaviours.
        arena: Of the experience; by default the one written in the data set.

    Raises:
        ExperienceError: An episode that holds no state vectors or no behaviours, or an arena that nobody tells.
        ImportError: Minari is not installed.
    """
    if isinstance(dataset, str):
        dataset = _minari().load_dataset(dataset)
    parts = []
    told = dataset.storage.get_episode_metadata(dataset.episode_indices)
    for episode, about in zip(dataset.iterate_episodes(), told, strict=True):
        options = about.get("options", {})
        name = arena or options.get("arena") or getattr(dataset.env_spec, "kwargs", {}).get("arena")
        if not isinstance(name, str):
            raise ExperienceError(f"episode {episode.id}: the data set tells no arena; give one")
        seed = options.get("seed", "None")
        parts.append(
            Experience(
                _vectors(episode.observations, len(episode.actions), episode.id),
                np.asarray(episode.actions),
                name,
                None if seed == "None" else int(seed),
                int(options.get("episodes", 1)),
            )
        )
    return parts


def _buffer(minari: Any, number: int, part: Experience, space: Any) -> Any:
    vectors, behaviours = part.arrays()
    shown: dict[str, NDArray[np.int64]] = {}
    for key, column in zip(StateVector._fields, np.vstack((vectors, vectors[-1])).T, strict=True):
        low, high = (0, space[key].n - 1) if key in FLAT else (space[key].low.item(), space[key].high.item())
        if column.min() < low or column.max() > high:
            raise ExperienceError(
                f"experience {number}: {key} is {column.min()}..{column.max()}; allowed: {low}..{high}"
            )
        shown[key] = column.copy() if key in FLAT else column[:, None].copy()
    last = np.arange(len(part)) == len(part) - 1
    return minari.data_collector.EpisodeBuffer(
        id=number,
        # Not Minari's own seed, which has 64 bits and makes an episode of one environment repeatable.
        options={"arena": part.arena, "episodes": part.episodes, "seed": str(part.seed)},
        observations=shown,
        actions=behaviours,
        rewards=[0.0] * len(part),
        terminations=last.tolist(),
        truncations=[False] * len(part),
    )


def _vectors(observations: Any, count: int, number: int) -> NDArray[np.int64]:
    try:
        columns = [np.asarray(observations[key]).reshape(-1)[:count] for key in StateVector._fields]
        return np.column_stack(columns)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise ExperienceError(f"episode {number} holds no state vectors: {error!r}") from None


def _minari() -> Any:
    try:
        import_module("h5py")
        return import_module("minari")
    except ImportError as error:
        raise ImportError("Minari data sets need pip install 'khepera-forage[minari]'") from error
