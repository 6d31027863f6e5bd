"""Conversion between experience and Minari datasets, a standard of offline learning (extra `minari`).

An experience file becomes an episode with the observations and actions of the recall environment of its arena, such as
`Corridor-v1` or `TMaze-v1`, so that a learner from Minari datasets can forage there. The environment variable
MINARI_DATASETS_PATH is the folder in which Minari stores datasets.
"""

import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

import khepera_forage
from khepera_forage.envs.arena_settings import environment_name, settings_of
from khepera_forage.experience import Experience, ExperienceError
from khepera_forage.experience.text_format import header_decisions, header_decisions_text
from khepera_forage.extras import require
from khepera_forage.rollouts.raw_episodes import RawEpisode
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.sim.arenas.procedural import LEVELS, SPLITS, level_of
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, StateVector

DATASET_ID = r"([\w-][\w/-]*[\w-]/)?[\w-]+-v\d+"
ALLOWED_IDS = "allowed: NAME-vNUMBER, or FOLDER/NAME-vNUMBER with a FOLDER of two characters or more"


def to_minari(
    experiences: Iterable[Experience],
    dataset_id: str,
    *,
    arena: Arena | str | None = None,
    allow_other_decisions: bool = False,
    rewards: Sequence[ArrayLike] | None = None,
    episodes: Sequence[RawEpisode] | None = None,
    truncated: Sequence[bool] | None = None,
    limit: int | None = None,
    **about: Any,
) -> Any:
    """Write experience as a new Minari dataset, with one episode for each `Experience`.

    Values that experience does not contain are filled in: rewards are 0 unless they are given; the last observation is
    repeated, because Minari has one more observation than actions; the last step terminates, because incomplete
    training episodes are discarded (5.2). With `episodes` the dataset has raw data and motors in their place, as in
    `CorridorWheels-v1`, of every round. The decisions of the training are metadata of every episode, which
    `from_minari` reads. Minari's `recover_environment()` returns an environment under the same decisions, or under the
    default ones if those of the episodes differ.

    Args:
        experiences: At least one vector each, all of the same arena, or of procedural levels of one difficulty and
            split.
        dataset_id: Minari's name of the dataset, such as `khepera/corridor-v0`.
        arena: The arena of the experience. Experience of an arena of your own has only its name, and needs it.
        allow_other_decisions: Accept experience of different decisions in one dataset.
        rewards: Of each experience, one a vector, such as `RawEpisode.rewards_of_vectors`.
        episodes: What was recorded with each experience, from `rollouts.raw_episodes`.
        truncated: Whether each episode was out of time, so that its last step truncates; by default as `episodes` say.
        limit: Of the recovered environment, in steps, as the rewards have it; by default that of the arena.
        **about: Further metadata for Minari: `author`, `author_email`, `code_permalink`, `description`.

    Returns:
        The `minari.MinariDataset`.

    Raises:
        ExperienceError: There is no experience, one is empty, the arenas differ or are not known, or a value is outside
            the observation space, or the decisions differ.
        ImportError: Minari is not installed.
        ValueError: The name is invalid, or Minari already has a dataset of that name.
    """
    minari = _minari()
    if not re.fullmatch(DATASET_ID, dataset_id):  # Minari checks after it made a folder, and then lists no dataset
        raise ValueError(f"dataset_id is {dataset_id!r}; {ALLOWED_IDS}")
    parts = list(experiences)
    if not parts or not all(parts):
        raise ExperienceError(f"{[len(part) for part in parts]} experience vectors; allowed: at least one in each")
    if not allow_other_decisions:
        for part in parts[1:]:
            part.require_decisions(parts[0].decisions)
    decisions, *others = {part.decisions for part in parts}
    names = {part.arena for part in parts}
    if truncated is None:
        truncated = [False] * len(parts) if episodes is None else [episode.truncated for episode in episodes]
    env = _environment(names, arena, None if others else decisions, limit, wheels=episodes is not None)
    buffers = []
    for number, part in enumerate(parts):
        given: Any = [0.0] * len(part) if rewards is None else rewards[number]
        recorded: dict[str, Any] = {"actions": part.arrays()[1]}
        if episodes is None:
            recorded["observations"] = _observations(number, part, env.observation_space)
        else:
            raw = episodes[number]
            given, recorded = raw.rewards, {"actions": raw.actions, "observations": raw.observations}
            recorded["infos"] = {"heard": np.append(raw.heard, Behaviour.WAIT)}
        if len(given) != len(recorded["actions"]):
            found = f"{len(given)} rewards with {len(recorded['actions'])} actions"
            raise ExperienceError(f"experience {number}: {found}; allowed: equal numbers")
        before, cut = [False] * (len(recorded["actions"]) - 1), bool(truncated[number])
        options = {
            "arena": part.arena,
            "episodes": part.episodes,
            "seed": str(part.seed),  # not Minari's, which has 64 bits and resets a single environment
            "decisions": header_decisions_text(part.decisions),
        }
        buffers.append(
            minari.data_collector.EpisodeBuffer(
                id=number,
                rewards=np.asarray(given, np.float64).tolist(),
                terminations=[*before, not cut],
                truncations=[*before, cut],
                options=options,
                **recorded,
            )
        )
    about.setdefault("algorithm_name", "the teacher, heard in training")
    with warnings.catch_warnings():
        # Minari warns about a missing author and code link, which a private dataset does not need.
        warnings.filterwarnings("ignore", "`.*` is set to None", UserWarning)
        return minari.create_dataset_from_buffers(dataset_id=dataset_id, buffer=buffers, env=env, **about)


def from_minari(dataset: Any, arena: str | None = None) -> list[Experience]:
    """Read a Minari dataset as experience, with one `Experience` for each episode.

    Args:
        dataset: A `minari.MinariDataset`, or its name. It was written by `to_minari`, or recorded in an environment
            whose observations are state vectors and whose actions are behaviours.
        arena: Name of the arena; by default the one in the dataset.

    An episode without decisions has those of the environment in which it was recorded, or those of version 0.1 if that
    is none of this package.

    Raises:
        ExperienceError: An episode has no state vectors or no behaviours, neither argument nor dataset names an arena,
            or the decisions in the dataset cannot be read.
        ImportError: Minari is not installed.
    """
    if isinstance(dataset, str):
        dataset = _minari().load_dataset(dataset)
    parts = []
    spec = dataset.env_spec
    recorded = _decisions_of(spec)
    metadata = dataset.storage.get_episode_metadata(dataset.episode_indices)
    for episode, about in zip(dataset.iterate_episodes(), metadata, strict=True):
        options = about.get("options", {})
        name = arena or options.get("arena") or _arena_name(getattr(spec, "kwargs", {}).get("arena"))
        if not isinstance(name, str):
            raise ExperienceError(f"episode {episode.id}: the dataset has no arena; pass arena=")
        seed = options.get("seed", "None")
        try:
            decisions = header_decisions(str(options["decisions"])) if "decisions" in options else recorded
        except ValueError as error:
            raise ExperienceError(f"episode {episode.id}: {error}") from None
        parts.append(
            Experience(
                _vectors(episode.observations, len(episode.actions), episode.id),
                np.asarray(episode.actions),
                name,
                None if seed == "None" else int(seed),
                int(options.get("episodes", 1)),
                decisions,
            )
        )
    return parts


def _decisions_of(spec: Any) -> Decisions:
    """The decisions of the environment that a spec describes; those of version 0.1 if it is none of this package."""
    registered = gym.registry.get(getattr(spec, "id", ""))
    if registered is None or registered.namespace != khepera_forage.__name__:
        return Decisions.v0_1()
    try:
        env: Any = gym.make(registered, decisions=spec.kwargs.get("decisions")).unwrapped
    except ValueError as error:
        raise ExperienceError(f"the environment of the dataset: {error}") from None
    decisions: Decisions = env.decisions
    return decisions


def _observations(number: int, part: Experience, space: Any) -> dict[str, NDArray[np.int64]]:
    vectors, _ = part.arrays()
    shown: dict[str, NDArray[np.int64]] = {}
    for key, column in zip(StateVector._fields, np.vstack((vectors, vectors[-1])).T, strict=True):
        is_flat = isinstance(space[key], gym.spaces.Discrete)  # others are arrays with one element
        low, high = (0, space[key].n - 1) if is_flat else (space[key].low.item(), space[key].high.item())
        if column.min() < low or column.max() > high:
            raise ExperienceError(
                f"experience {number}: {key} is {column.min()}..{column.max()}; allowed: {low}..{high}"
            )
        shown[key] = column.copy() if is_flat else column[:, None].copy()
    return shown


def _vectors(observations: Any, count: int, number: int) -> NDArray[np.int64]:
    try:
        columns = [np.asarray(observations[key]).reshape(-1)[:count] for key in StateVector._fields]
        return np.column_stack(columns)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise ExperienceError(f"episode {number} has no state vectors: {error!r}") from None


def _minari() -> Any:
    require("a Minari dataset", "minari")
    return import_module("minari")


def _environment(
    names: Iterable[str], arena: Arena | str | None, decisions: Decisions | None, limit: int | None, wheels: bool
) -> gym.Env[Any, Any]:
    """The environment of behaviours, or of motors, in the arena of some experience, which the names may tell."""
    found = sorted(set(names))
    if arena is not None and found != [own := _arena_name(arena)]:
        raise ExperienceError(f"experience of {found}; allowed: of {own!r}, the argument arena")
    settings: dict[str, Any] = {}
    if isinstance(arena, Arena):
        name, settings = "Corridor", settings_of(arena)
    elif len(found) == 1 and found[0] in ARENAS:
        name = environment_name(found[0])
    else:
        name, settings = "Procedural", _levels(found)
    kind = "Wheels-v1" if wheels else "-v1"
    settings |= {} if limit is None else {"limit": limit}
    return gym.make(f"khepera_forage/{name}{kind}", decisions=decisions, **settings)


def _arena_name(arena: Any) -> Any:
    """The name of an arena in a spec: of an `Arena`, of its fields as JSON stores them, or the name itself."""
    if isinstance(arena, Mapping):
        return arena.get("name")
    return arena.name if isinstance(arena, Arena) else arena


def _levels(names: Sequence[str]) -> dict[str, Any]:
    """The arguments of `Procedural-v1` in which all named levels are."""
    levels = [level_of(name) or ("", -1) for name in names]
    numbers = sorted(number for _, number in levels)
    splits = {first // LEVELS: split for split, first in SPLITS.items()}
    (difficulty, split), *others = {(difficulty, splits.get(number // LEVELS)) for difficulty, number in levels}
    if others or split is None:
        raise ExperienceError(
            f"experience of {names}; allowed: one arena, of {', '.join(ARENAS)}, or one of your own with the argument "
            "arena (--arena FILE); or procedural levels of one difficulty and split"
        )
    num_levels, start_level = numbers[-1] - numbers[0] + 1, numbers[0] % LEVELS
    return {"difficulty": difficulty, "split": split, "num_levels": num_levels, "start_level": start_level}
