"""Imitation: how much food a learner brings home alone, after one to ten training episodes beside a teacher.

    pip install 'khepera-forage[plots]'
    python examples/imitation.py --replications 10 --out results/imitation

The learner records its own state vector with every behaviour that it hears (section 4.5 of the thesis). Alone, it does
what it heard with the most similar vectors (4.6). All training takes place in the corridor; the rectangle is new to it.
Writes `recalls.csv`, one row for each recall, and `food.png`. Takes a minute of one core.

Food delivered (%), as measured by the command above, with 95 % intervals over replications:

    training episodes    corridor             rectangle
            1            42.0 [31.0, 57.0]    23.0 [11.5, 36.5]
            3            74.0 [57.0, 92.0]    46.5 [28.0, 65.5]
            5            65.0 [45.0, 85.0]    41.5 [22.5, 62.0]
           10            71.0 [55.0, 87.0]    52.5 [37.0, 68.5]
"""

from argparse import RawDescriptionHelpFormatter
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Estimate, bootstrap, ratio, sums_by_replication
from khepera_forage.option_values import OneLineParser, given_path, whole_number
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.rollouts.training import arrays, train

ARENAS = ("corridor", "rectangle")
AMOUNTS = (1, 3, 5, 10)
"""Training episodes, those of the thesis."""


def replicate(number: int, recalls: int, seed: np.random.SeedSequence) -> list[RecallRow]:
    """Ten training episodes, and recalls after each amount of them in both arenas."""
    *training_seeds, recall_seed = seed.spawn(max(AMOUNTS) + 1)
    paired = TrainingEnv()
    files = [train(paired, one)[0] for one in training_seeds]
    rows = []
    for arena in ARENAS:
        env = recall_env(arena)
        for amount in AMOUNTS:
            vectors, behaviours = arrays(files[:amount])
            imitator = NearestNeighbourImitator(env.diagonal).fit(vectors, behaviours)
            # The same places after each amount, so that only the experience differs.
            for i, one in enumerate(recall_seed.generate_state(recalls).tolist()):
                size = len(vectors)
                row = recall(env, imitator, one, replication=number, number=i, episodes=amount, experience_size=size)
                rows.append(row)
    return rows


def food_delivered(rows: list[RecallRow], arena: str, amount: int) -> Estimate:
    """Share of the food delivered, in percent, with its 95 % interval over replications."""
    chosen = [row for row in rows if (row.arena, row.episodes) == (arena, amount)]
    numbers = sorted({row.replication for row in chosen})
    sums = sums_by_replication(chosen, numbers, lambda row: 100 * row.delivered, lambda row: row.foods)
    return bootstrap(sums, ratio, np.random.default_rng(0))


def text_of(estimate: Estimate) -> str:
    """A share and its interval, if it has one."""
    value, low, high = estimate
    return f"{value:5.1f}" if np.isnan(low) else f"{value:5.1f} [{low:.1f}, {high:.1f}]"


def figure_of(rows: list[RecallRow]) -> Figure:
    """Food delivered against the number of training episodes, a line for each arena."""
    figure = Figure(figsize=(6, 3.8), layout="constrained")
    axes = figure.subplots()
    for arena, colour in zip(ARENAS, ("#0072B2", "#D55E00"), strict=True):
        found = np.array([food_delivered(rows, arena, amount) for amount in AMOUNTS])
        axes.plot(AMOUNTS, found[:, 0], "o-", color=colour, label=arena)
        axes.fill_between(AMOUNTS, found[:, 1], found[:, 2], color=colour, alpha=0.2, linewidth=0)
    axes.set(xlabel="training episodes, in the corridor", ylabel="food delivered alone (%)", ylim=(0, 102))
    axes.set_xticks(AMOUNTS)
    axes.legend(title="recall in the ... (band: 95 % interval)")
    return figure


def main(given: list[str] | None = None) -> list[RecallRow]:
    """Train and recall, write rows and figure, and print a line for each amount of training."""
    parser = OneLineParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--replications", type=whole_number(1), default=10, help="(10)")
    parser.add_argument("--recalls", type=whole_number(1), default=10, help="after each amount and arena (10)")
    parser.add_argument("--seed", type=whole_number(0), default=0, help="the same seed gives the same rows (0)")
    parser.add_argument("--out", type=given_path, default=Path("results/imitation"), help="(results/imitation)")
    arguments = parser.parse_args(given)
    seeds = np.random.SeedSequence(arguments.seed).spawn(arguments.replications)
    rows: list[RecallRow] = []
    for number, seed in enumerate(tqdm(seeds, unit="replication", disable=None)):
        rows += replicate(number, arguments.recalls, seed)
    arguments.out.mkdir(parents=True, exist_ok=True)
    write_rows(arguments.out / "recalls.csv", RecallRow, rows)
    figure_of(rows).savefig(arguments.out / "food.png", dpi=150)
    print("food delivered (%), with 95 % intervals over replications where there are five or more")
    for amount in AMOUNTS:
        cells = (f"{arena} {text_of(food_delivered(rows, arena, amount))}" for arena in ARENAS)
        print(f"{amount:2} training episodes: {', '.join(cells)}")
    return rows


if __name__ == "__main__":
    main()
