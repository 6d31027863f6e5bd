"""What a step costs against the number of worlds and of food objects, as numbers and as a picture. Needs numba."""

from collections.abc import Sequence
from time import perf_counter
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np

import khepera_forage  # noqa: F401 (registers the environments)
from _throughput import batch
from _throughput.lines import Job, Line, Measure, Values
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.thesis.figures import GREY, OURS, THESIS, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SECTION = "Cost against the number of worlds and of food"
NOTE = (
    "A step of one world, the expert deciding, all cores. A block is 128 worlds and one core's: below, lanes are idle. "
    "Food lies in a hall of 2 x 2 m, which has room for 16 objects."
)
WORLDS = tuple(4**n for n in range(9))
FOODS = (1, 2, 4, 8, 12, 16)
VECTOR = {n: Measure(SECTION, f"make_vec, worlds: {n:,}", "ns a step", "Corridor-v0") for n in WORLDS}
KERNEL = {
    n: Measure(SECTION, f"kernel, worlds: {n:,}", "ns a step", "the same without the arrays") for n in WORLDS
}
OBJECTS = {
    k: Measure(SECTION, f"kernel, food objects: {k}", "ns a step", f"{batch.WORLDS:,} worlds") for k in FOODS
}
_HALL = Arena(
    "hall",
    (Point(0, 0), Point(2000, 0), Point(2000, 2000), Point(0, 2000)),
    Point(1000, 1000),
    100,
    Pose(300, 300, 0.0),
    (Point(500, 500),),
)
_LEAST = 5
"""Rounds of a measure; small batches take more, so that each is timed for as long."""


def job(steps: int, seed: int) -> Job:
    """All measures.

    Args:
        steps: Of worlds together, of each measure in a repeat.
        seed: Of all worlds.
    """
    from khepera_forage.envs.compiled import rows as at
    from khepera_forage.envs.compiled.batch import TaskBatch

    def stepping(env: Any, worlds: int) -> float:
        _, infos = env.reset(seed=seed)
        for _ in range(_LEAST):
            infos = env.step(infos["correct_behaviour"])[4]
        seconds = []
        for _ in range(max(_LEAST, min(steps // worlds, 2_000))):
            actions = infos["correct_behaviour"]
            start = perf_counter()
            infos = env.step(actions)[4]
            seconds.append(perf_counter() - start)
        return float(np.median(seconds)) / worlds * 1e9

    def kernel(batched: TaskBatch) -> float:
        worlds = batched.num_worlds
        batched.seed(seed, np.arange(worlds))
        batched.restart(np.arange(worlds))
        over = np.zeros(worlds, np.bool_)
        seconds = []
        for _ in range(_LEAST + max(_LEAST, min(steps // worlds, 2_000))):
            states = batched.task(at.STATE).copy()
            start = perf_counter()
            batched.step(states, over)
            seconds.append(perf_counter() - start)
            over = (batched.task(at.TERMINATED) != 0) | (batched.task(at.TRUNCATED) != 0)
        return float(np.median(seconds[_LEAST:])) / worlds * 1e9

    def repeat() -> Values:
        values = {}
        for worlds in WORLDS:
            values[VECTOR[worlds]] = stepping(
                gym.make_vec("khepera_forage/Corridor-v0", num_envs=worlds), worlds
            )
            values[KERNEL[worlds]] = kernel(TaskBatch(worlds))
        for foods in FOODS:
            values[OBJECTS[foods]] = kernel(TaskBatch(batch.WORLDS, _HALL, foods, 10_000))
        return values

    return repeat


def picture(lines: Sequence[Line]) -> "Figure":
    """Cost of a step against the number of worlds, and against that of food objects."""
    by_name = {line.name: line for line in lines}
    figure = new_figure(10.0, 4.2)
    left, right = figure.subplots(1, 2)
    _curve(left, by_name, VECTOR, "make_vec", OURS)
    _curve(left, by_name, KERNEL, "kernel", THESIS)
    single = by_name.get(batch.SINGLE.name)
    if single is not None:
        left.plot([1], [1e9 / single.median], "D", color=GREY, label='gym.make, physics="batch"')
    left.set_xscale("log", base=4)
    left.set_yscale("log")
    left.set_xticks(WORLDS, [f"{n:,}" for n in WORLDS], rotation=30, fontsize=8)
    left.set_xlabel("worlds")
    left.set_ylabel("ns a step of one world")
    left.legend(fontsize=8)
    _curve(right, by_name, OBJECTS, f"kernel, {batch.WORLDS:,} worlds", THESIS)
    least = by_name[OBJECTS[FOODS[0]].name].median
    right.plot(FOODS, [least * k for k in FOODS], "--", color=GREY, lw=1.0, label="proportional")
    right.set_xticks(FOODS)
    right.set_xlabel("food objects")
    right.set_ylim(0, 1.1 * max(by_name[OBJECTS[k].name].highest for k in FOODS))
    right.set_ylabel("ns a step of one world")
    right.legend(fontsize=8)
    return figure


def _curve(
    axes: "Axes", lines: dict[str, Line], measures: dict[int, Measure], label: str, colour: str
) -> None:
    """The medians of some measures, and how far their repeats lie apart."""
    kept = [(n, lines[measure.name]) for n, measure in measures.items()]
    counts = [n for n, _ in kept]
    axes.fill_between(
        counts, [line.lowest for _, line in kept], [line.highest for _, line in kept], color=colour, alpha=0.2
    )
    axes.plot(counts, [line.median for _, line in kept], "o-", color=colour, ms=4, label=label)
