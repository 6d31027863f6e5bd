"""Real robots: a learner is trained beside a teacher, then forages alone. Without robots, in the virtual laboratory.

    pip install 'khepera-forage[robots,camera]'
    python examples/virtual_laboratory.py                  # virtual robots behind the real driver and tracker
    python examples/virtual_laboratory.py --lab lab.toml   # your robots; docs/laboratory.md explains the file

The same functions serve both: a `Laboratory` is a world, which the environments take instead of a simulated one. Robots
are stopped on every exit path: `with` stops them at the end and after an exception, and the driver stops them on Ctrl-C
and other signals. Writes `g1.csv`, `g2.csv`, ..., the experience, and `recalls.csv`.

Takes 40 s in the virtual laboratory. With seed 0, the learner delivers the food in 2 of 10 recalls after five training
episodes. Other seeds differ much: in 64 recalls of 16 learners it is 53 % (docs/virtual_lab.md).
"""

import sys
from argparse import RawDescriptionHelpFormatter
from pathlib import Path

import gymnasium as gym
import numpy as np

from khepera_forage import Decisions
from khepera_forage.envs.laboratories import load_settings, virtual_laboratory
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.lab.laboratory import Laboratory
from khepera_forage.noise import Noise
from khepera_forage.option_values import OneLineParser, given_path, whole_number
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.rollouts.recall import RecallInterruptedError, recall
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.rollouts.training import train

SLOW_ARMS = Decisions(lowering_speed=0)
"""For real arms, which take longer than a round (docs/laboratory.md); virtual ones are as the default decisions say."""


def open_laboratory(lab: Path | None, robots: int) -> Laboratory:
    """The laboratory of a file, or a virtual one; for a recall, which needs one robot, the last one of the file."""
    if lab is None:
        # Virtual robots share this computer: they may reply later than real ones.
        return virtual_laboratory("corridor", robots, timeout=2.0)
    settings = load_settings(lab)
    return Laboratory(settings if robots > 1 else settings.for_recall())


def train_beside_the_teacher(
    laboratory: Laboratory, decisions: Decisions, episodes: int, seed: int, folder: Path
) -> Experience:
    """Complete training episodes; each experience vector is on disk as soon as it is recorded."""
    # The operator is asked for the marks themselves: no placement errors are simulated.
    learners = len(laboratory.robots) - 1
    env = TrainingEnv(num_learners=learners, world=laboratory, noise=Noise.none(), decisions=decisions)
    paths = [folder / f"g{number}.csv" for number in range(1, episodes + 1)]
    for path, one in zip(paths, np.random.SeedSequence(seed).spawn(episodes), strict=True):
        experience, attempts = train(env, one, path=path)
        print(f"{path}: {len(experience)} experience vectors, attempt {len(attempts)}")
    return Experience.load(*paths)


def forage_alone(
    laboratory: Laboratory, decisions: Decisions, experience: Experience, recalls: int, seed: int, path: Path
) -> None:
    """Recalls, with a line for each; one in which a robot or the camera was lost has no result."""
    env = gym.make("khepera_forage/Corridor-v1", world=laboratory, decisions=decisions)
    imitator = NearestNeighbourImitator().fit(*experience.arrays())
    with RowWriter(path, RecallRow) as rows:
        for number, one in enumerate(np.random.SeedSequence(seed).generate_state(recalls).tolist()):
            try:
                row = recall(env, imitator, one, number=number, experience_size=len(experience))
            except RecallInterruptedError as error:
                print(f"recall {number + 1}: interrupted {error}")
                continue
            rows.write(row)
            print(f"recall {number + 1}: score {row.score:.1f} %, food {row.delivered}, {row.steps} steps")


def main(given: list[str] | None = None) -> None:
    """Train, then recall."""
    parser = OneLineParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--lab", type=given_path, help="lab.toml of real robots (the virtual laboratory)")
    parser.add_argument("--episodes", type=whole_number(1), default=5, help="of training (5)")
    parser.add_argument("--recalls", type=whole_number(1), default=10, help="(10)")
    parser.add_argument("--seed", type=whole_number(0), default=0, help="of the places and of the learner (0)")
    parser.add_argument("--out", type=given_path, default=Path("results/laboratory"), help="(results/laboratory)")
    arguments = parser.parse_args(given)
    if list(arguments.out.glob("g*.csv")):
        parser.error(f"{arguments.out} has experience files; allowed: another --out")
    arguments.out.mkdir(parents=True, exist_ok=True)
    decisions, seed, out = SLOW_ARMS if arguments.lab else Decisions(), arguments.seed, arguments.out
    with open_laboratory(arguments.lab, robots=2) as laboratory:
        experience = train_beside_the_teacher(laboratory, decisions, arguments.episodes, seed, out)
    with open_laboratory(arguments.lab, robots=1) as laboratory:
        forage_alone(laboratory, decisions, experience, arguments.recalls, seed, out / "recalls.csv")


if __name__ == "__main__":
    try:
        main()
    except (OSError, ValueError) as error:  # a mistake in the file, a closed port, a robot that is lost
        sys.exit(f"virtual_laboratory.py: {error}")
