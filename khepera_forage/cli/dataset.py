"""`khepera-forage dataset`: training episodes as a Minari dataset with a data card."""

import argparse
import os
import re
import shutil
from collections import Counter
from collections.abc import Sequence, Set
from typing import Any

import numpy as np

from khepera_forage import __version__
from khepera_forage.cli import options
from khepera_forage.cli.options import command, flag, option
from khepera_forage.envs.arena_settings import settings_of
from khepera_forage.envs.paired_arenas_v1 import raw_env
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.experience import Experience
from khepera_forage.experience.experience import experience_files
from khepera_forage.experience.minari import ALLOWED_IDS, DATASET_ID, to_minari
from khepera_forage.experience.text_format import header_decisions_text
from khepera_forage.extras import require
from khepera_forage.files import replacing
from khepera_forage.option_values import given_path, progress, whole_number
from khepera_forage.rollouts.raw_episodes import recorded
from khepera_forage.sim.arena import Arena
from khepera_forage.task.states import Behaviour, FoodType

CARD = "README.md"
"""Name of the card's file in the folder of the dataset."""
FOLDER_VARIABLE = "MINARI_DATASETS_PATH"
EPISODES = 10
SIMULATED = """Teacher and learner were simulated in copies of the arena {arena}, with pymunk and the noise of the
thesis's laboratory. The teacher of section 4.4 foraged for {food}, and the learner listened."""
TEACHER_ONLY = """The teacher of section 4.4 was simulated alone in the arena {arena}, with pymunk and the noise of the
thesis's laboratory. It foraged for {food}, from random places."""
TAUGHT = """Experience of a learner robot that was taught to forage by imitation: at every step what it perceived, and
what it heard of the teacher, or did."""
ALONE = "Episodes of the teacher, which forages alone."
RAW = """An observation is the raw data (thesis, 4.2.2), and an action the motors as applied: left wheel, right wheel,
arm and jaw, each -1..1, both as in `CorridorWheels-v1`. Every round is in the data. `infos["heard"]` is the behaviour
heard, or executed, in it (thesis, table 4.1; 10 is silence). Those that occur:"""
REWARDS = """Rewards are those of the environment: -1/limit a round, +1 for food that the robot delivers, -1 for poison
that it brings home. With state vectors, rounds in which nothing was heard count for the step before."""
VECTORS = """An observation is the state vector (thesis, 4.3):

| attribute | meaning |
|---|---|
| `object_presence` | 1 if an object is in the gripper's light barrier, else 0 |
| `robot_home_distance` | distance from home, in pixels of 5 mm |
| `food_type` | 0 unknown, 1 pickable, 2 pushable, 3 poisonous |
| `arms_height` | position of the arm: 255 is down, 215 is raised |
| `robot_food_distance` | distance from the nearest food, in pixels of 5 mm |

An action is a behaviour (thesis, table 4.1). Those that occur:"""
STEERS = "The learner steers to stay beside the teacher: the data are not those of a robot that forages alone."
UNKNOWN_REWARDS = "Rewards are 0, because experience files contain none."


def _dataset_name(text: str) -> str:
    """A name of Minari."""
    if not re.fullmatch(DATASET_ID, text):
        raise argparse.ArgumentTypeError(f"{text!r}; {ALLOWED_IDS}")
    return text


_EXPERIENCE = """files of 'khepera-forage train' or of real robots, one episode each, or a folder of them, instead of
new episodes"""


@command(
    option("--name", "Minari's name of the dataset (khepera_forage/ARENA-v1, or ARENA-wheels-v1)", _dataset_name),
    option("--episodes", f"complete training episodes ({EPISODES})", whole_number(1)),
    option("--experience", _EXPERIENCE, given_path, "FILE", nargs="+"),
    flag("--wheels", "raw data and motors of every round, in place of state vectors and behaviours"),
    flag("--alone", "the teacher forages alone, from random places, in place of training episodes"),
    flag("--protocol", "the datasets of the protocol forage-bench-1: those that its learners learn from"),
    options.seed("the same seed gives the same episodes"),
    options.out("datasets", f"folder of Minari datasets, which Minari finds as {FOLDER_VARIABLE}"),
    option("--author", "for the data card (unknown)", default="unknown"),
    option("--licence", "of the data, for the data card (CC0-1.0)", default="CC0-1.0"),
    options.ARENA,
    options.FOOD_TYPE,
    options.DECISION,
    options.ALLOW_OTHER_DECISIONS,
)
def dataset_command(arguments: argparse.Namespace) -> None:
    """Write training episodes as a Minari dataset with a data card."""
    require("khepera-forage dataset", "minari")
    if arguments.protocol:
        _write_protocol(arguments)
        return
    arena = options.arena_of(arguments)
    if arguments.experience:
        ignored = ["--episodes", "--food-type", "--wheels", "--alone", "--decision"]
        options.refuse_ignored(arguments, ignored, "without --experience")
        files = experience_files(arguments.experience)
        parts = [Experience.load(path) for path in files]
        name = _new_name(arguments, {part.arena for part in parts})
        procedure = f"The experience was read from {', '.join(path.name for path in files)}."
        _write(arguments, name, parts, procedure, alone=False, arena=arena if arguments.arena else None)
        return
    arena_name = arena if isinstance(arena, str) else arena.name
    name = _new_name(arguments, {arena_name})
    given: dict[str, Any] = {"decisions": options.decisions_of(arguments)}
    if arguments.food_type:
        given["food_types"] = arguments.food_type
    env = WheelsEnv(**(settings_of(arena) | given)) if arguments.alone else raw_env(arena, **given)
    limit = env.limit if isinstance(env, WheelsEnv) else env.max_cycles
    seeds = np.random.SeedSequence(arguments.seed).spawn(arguments.episodes or EPISODES)
    parts, raw = map(list, zip(*recorded(env, progress(seeds, unit="episode")), strict=True))
    text = TEACHER_ONLY if arguments.alone else SIMULATED
    procedure = text.format(arena=arena_name, food=food_in_training(arguments, arena))
    more: dict[str, Any] = {"episodes": raw}
    if not arguments.wheels:
        rewards = [episode.rewards_of_vectors for episode in raw]
        more = {"rewards": rewards, "truncated": [episode.truncated for episode in raw]}
    _write(arguments, name, parts, procedure, arguments.alone, arena=arena, limit=limit, **more)


def _write_protocol(arguments: argparse.Namespace) -> None:
    """Write the datasets of the protocol."""
    own = ["--name", "--experience", "--wheels", "--alone", "--arena", "--food-type"]
    allowed = "without --protocol, whose datasets have names and arenas of their own"
    options.refuse_ignored(arguments, own, allowed)
    options.refuse_ignored(arguments, ["--decision"], "without --protocol")
    from khepera_forage.comparison.protocol import datasets

    made = datasets(arguments.seed, arguments.episodes)
    for name in made:
        _require_new(arguments, name)
    for name, make in made.items():
        about, parts, more = make()
        procedure = f"Data of the protocol {name.split('/')[0]}: {about}"
        _write(arguments, name, parts, procedure, "alone" in name, **more)


def _write(
    arguments: argparse.Namespace, name: str, parts: Sequence[Experience], procedure: str, alone: bool, **more: Any
) -> None:
    """Write a dataset and its card, and say where they are; `more` are further arguments of `to_minari`."""
    folder = arguments.out.resolve()
    # Minari has no other way to choose a folder.
    os.environ[FOLDER_VARIABLE] = str(folder)
    raw = more.get("episodes", ())
    heard = [episode.heard.tolist() for episode in raw] or [part.behaviours for part in parts]
    folder /= name
    about = {"author": arguments.author, "description": procedure, **more}
    try:
        to_minari(parts, name, allow_other_decisions=arguments.allow_other_decisions, **about)
        with replacing(folder / CARD) as path:
            text = _card(arguments, name, parts, procedure, heard, bool(raw), alone)
            path.write_text(text, encoding="utf-8", errors="replace")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)  # Minari leaves an incomplete dataset.
        raise
    print(f"{name}: {len(parts)} episodes, {sum(map(len, heard)):,} steps, in {arguments.out}")
    print(f"data card: {arguments.out / name / CARD}")
    print(f"to load it: {FOLDER_VARIABLE}={arguments.out} and minari.load_dataset({name!r})")


def _card(
    arguments: argparse.Namespace,
    name: str,
    parts: Sequence[Experience],
    procedure: str,
    heard: Sequence[Sequence[int]],
    has_wheels: bool,
    alone: bool,
) -> str:
    """The data card: what a dataset contains, how it was made, and under which licence, as Markdown.

    `heard` has the behaviour of each step of each episode.
    """
    steps, counts = list(map(len, heard)), Counter(behaviour for each in heard for behaviour in each)
    decisions = " and ".join(sorted({header_decisions_text(part.decisions) for part in parts}))
    seeds = ", ".join(str(part.seed) for part in parts)
    behaviours = "\n".join(
        f"| {behaviour:d} | {Behaviour(behaviour).name} | {count:,} | {100 * count / counts.total():.1f} |"
        for behaviour, count in sorted(counts.items())
    )
    loading = "episodes = from_minari(dataset)  # or dataset.iterate_episodes()"
    rewards = UNKNOWN_REWARDS if arguments.experience else REWARDS
    if has_wheels:
        loading = "episodes = dataset.iterate_episodes()  # observations, actions, rewards"
    else:
        rewards += "\nThe last observation of each episode is repeated."
    rewards += "\nThe last step of an episode terminates, or truncates where it was out of time."
    if not alone:
        rewards += f"\n{STEERS}"
        procedure += "\nEpisodes that were not completed are not in the data (thesis, 5.2)."
    return f"""# {name}

{ALONE if alone else TAUGHT} The task is that of Gatsoulis, *Learning Through Imitation for Mobile Robots*
(MSc thesis, University of Edinburgh, 2001), as `khepera_forage` {__version__} re-creates it.

## Contents

| | |
|---|---|
| episodes | {len(parts)} |
| steps | {sum(steps):,}; {min(steps)} to {max(steps)} an episode |
| arena | {", ".join(sorted({part.arena for part in parts}))} |
| author | {arguments.author} |
| licence | {arguments.licence} |

{RAW if has_wheels else VECTORS}

| number | behaviour | steps | % |
|---|---|---:|---:|
{behaviours}

{rewards}

## Procedure

{procedure}

- Decisions, that is, readings of what the thesis leaves open: `{decisions}`.
- Seed: {"that of each file" if arguments.experience else arguments.seed}. Seeds of the episodes: {seeds}.
- Command: `{arguments.command_line}`

## Use

```python
import minari

from khepera_forage.experience.minari import from_minari

dataset = minari.load_dataset("{name}")  # with MINARI_DATASETS_PATH set to the folder above
{loading}
env = dataset.recover_environment()  # where a learner can forage alone
```
"""


def _new_name(arguments: argparse.Namespace, arenas: Set[str]) -> str:
    """Minari's name of a dataset, which must be new; without `--name` it says the arena."""
    arena = re.sub(r"[^\w-]", "_", min(arenas)) if len(arenas) == 1 else "procedural"
    kind = "-alone" * arguments.alone + "-wheels" * arguments.wheels
    return _require_new(arguments, arguments.name or f"khepera_forage/{arena}{kind}-v1")


def _require_new(arguments: argparse.Namespace, name: str) -> str:
    if (arguments.out / name).exists():
        raise ValueError(f"--name is {name!r}; allowed: a name that is not in {arguments.out} yet")
    return name


def food_in_training(arguments: argparse.Namespace, arena: str | Arena) -> str:
    """The food in training and its types, for the data card."""
    odds = {} if arguments.food_type else settings_of(arena).get("food_types", {})
    shares = ", ".join(f"{100 * share:g} % {name}" for name, share in odds.items())
    return f"food ({shares})" if shares else f"{arguments.food_type or FoodType.PICKABLE.name} food"
