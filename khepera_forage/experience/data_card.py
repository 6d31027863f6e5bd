"""The data card of a Minari dataset: what it contains, how it was made, and under which licence, as Markdown."""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from khepera_forage import __version__
from khepera_forage.experience.experience import Experience
from khepera_forage.experience.text_format import header_decisions_text
from khepera_forage.task.states import Behaviour, StateVector

CARD = "README.md"
"""Name of the card's file in the folder of the dataset."""
MEANINGS = {
    "object_presence": "1 if an object is in the gripper's light barrier, else 0",
    "robot_home_distance": "distance from home, in pixels of 5 mm",
    "food_type": "0 unknown, 1 pickable, 2 pushable, 3 poisonous",
    "arms_height": "position of the arm: 255 is down, 215 is raised",
    "robot_food_distance": "distance from the nearest food, in pixels of 5 mm",
}
"""Of the attributes of `StateVector`."""


TAUGHT = """Experience of a learner robot that was taught to forage by imitation: at every step what it perceived, and
what it heard of the teacher, or did."""
ALONE = "Episodes of the teacher, which forages alone."
RAW = """An observation is the raw data (thesis, 4.2.2), and an action the motors as applied: left wheel, right wheel,
arm and jaw, each -1..1, both as in `CorridorWheels-v1`. Every round is in the data. `infos["heard"]` is the behaviour
heard, or executed, in it (thesis, table 4.1; 10 is silence). Those that occur:"""
REWARDS = """Rewards are those of the environment: -1/limit a round, +1 for food that the robot delivers, -1 for poison
that it brings home. With state vectors, rounds in which nothing was heard count for the step before."""
STEERS = (
    "The learner steers to stay beside the teacher: the data are not those of a robot that forages alone."
)
UNKNOWN_REWARDS = "Rewards are 0, because experience files contain none."


class Origin(NamedTuple):
    """Where experience comes from.

    Attributes:
        command: That made the dataset.
        procedure: How the experience was recorded, in one sentence.
        licence: Of the data, such as an SPDX identifier.
        author: Of the dataset.
        seed: Of the training; None if the experience was read from files.
        wheels: Whether the dataset has raw data and motors.
        steps: Of each episode; by default as many as experience vectors.
        alone: Whether the teacher foraged alone.
    """

    command: str
    procedure: str
    licence: str
    author: str
    seed: int | None
    wheels: bool = False
    steps: Sequence[int] = ()
    alone: bool = False


def data_card(dataset: str, parts: Sequence[Experience], origin: Origin) -> str:
    """The card.

    Args:
        dataset: Minari's name of it.
        parts: Its episodes.
        origin: Where they come from.
    """
    lengths = list(origin.steps) or [len(part) for part in parts]
    vectors = sum(len(part) for part in parts)
    heard = Counter(behaviour for part in parts for behaviour in part.behaviours)
    total = sum(lengths)
    decisions = " and ".join(sorted({header_decisions_text(part.decisions) for part in parts}))
    seeds = ", ".join(str(part.seed) for part in parts)
    behaviours = "\n".join(
        f"| {int(behaviour)} | {behaviour.name} | {heard[behaviour]:,} | {100 * heard[behaviour] / vectors:.1f} |"
        for behaviour in Behaviour
        if behaviour in heard
    )
    attributes = "\n".join(f"| `{name}` | {MEANINGS[name]} |" for name in StateVector._fields)
    vectors_text = f"""An observation is the state vector (thesis, 4.3):

| attribute | meaning |
|---|---|
{attributes}

An action is a behaviour (thesis, table 4.1). Those that occur:"""
    observed = RAW if origin.wheels else vectors_text
    rewards = UNKNOWN_REWARDS if origin.seed is None else REWARDS
    loading = (
        f'episodes = minari.load_dataset("{dataset}").iterate_episodes()  # observations, actions, rewards'
        if origin.wheels
        else "episodes = from_minari(dataset)  # or dataset.iterate_episodes()"
    )
    if not origin.wheels:
        rewards += "\nThe last observation of each episode is repeated."
    rewards += "\nThe last step of an episode terminates, or truncates where it was out of time."
    if not origin.alone:
        rewards += f"\n{STEERS}"
    return f"""# {dataset}

{ALONE if origin.alone else TAUGHT} The task is that of Gatsoulis, *Learning Through Imitation for Mobile Robots*
(MSc thesis, University of Edinburgh, 2001), as `khepera_forage` {__version__} re-creates it.

## Contents

| | |
|---|---|
| episodes | {len(parts)} |
| steps | {total:,}; {min(lengths)} to {max(lengths)} an episode |
| arena | {", ".join(sorted({part.arena for part in parts}))} |
| author | {origin.author} |
| licence | {origin.licence} |

{observed}

| action | behaviour | steps | % |
|---|---|---:|---:|
{behaviours}

{rewards}

## Procedure

{origin.procedure}
Episodes that were not completed are not in the data (thesis, 5.2).

- Decisions, that is, readings of what the thesis leaves open: `{decisions}`.
- Seed: {"that of each file" if origin.seed is None else origin.seed}. Seeds of the episodes: {seeds}.
- Command: `{origin.command}`

## Use

```python
import minari

from khepera_forage.experience.minari import from_minari

dataset = minari.load_dataset("{dataset}")  # with MINARI_DATASETS_PATH set to the folder above
{loading}
env = dataset.recover_environment()  # where a learner can forage alone
```
"""
