"""Speed of compiled worlds beside Kheperax 0.2.0, in one session.

    pip install -e '.[fast,plots]' kheperax==0.2.0 jax    # 1.2 GB
    python benchmarks/kheperax.py --help

Kheperax steps robots of a Khepera's size with random commands among four obstacles, with noise and without; our lines
are the whole task: the teacher forages in compiled worlds. Kheperax is given its best: its own `KheperaxTask.step`,
vectorised over worlds that share one maze, looped inside JAX, compiled, and with one JAX device for each core. Fast
math makes it a quarter faster and changes no reading by more than 0.001 mm. Needs an otherwise idle machine.
"""

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from khepera_forage.estimates import UNKNOWN, Value, extremes, pick, table_of
from khepera_forage.figures import OURS, SMALL, THESIS, grid, new_figure
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse

WORLDS, QUICK_WORLDS = (64, 256, 1024, 4096, 16384), (64, 256)
"""Numbers of worlds that are stepped together."""
SETTINGS = {
    "Kheperax, with its noise": "noise",
    "Kheperax, no noise": "none",
    "Kheperax by default: its standard maze, three lasers, no noise": "default",
}
TASKS: dict[str, dict[str, Any]] = {
    "run_teacher, corridor, one food object": {"arena": "corridor", "foods": 1, "limit": 500},
    "run_teacher, rectangle, four food objects": {"arena": "rectangle", "foods": 4, "limit": 700},
}
NOISY, *_ = NAMES = (*SETTINGS, *TASKS)
CORES = os.cpu_count() or 1
WIDTH, HEIGHT, RADIUS, REACH, HALF = 650.0, 600.0, 27.5, 87.5, 17.5
"""mm: the thesis's rectangle, a Khepera, how far its sensors see, and half the side of an obstacle."""
OBSTACLES = ((200.0, 200.0), (450.0, 200.0), (200.0, 400.0), (450.0, 400.0))
DIRECTIONS = np.radians((90, 45, 10, -10, -45, -90, 180, 180))
TRAVEL, WHEEL_NOISE, SENSOR_NOISE = 16.0, 0.4, 1.2
"""mm: a wheel at full speed in a step, and standard deviations like those of the laboratory."""
COMMANDS, HELD = 8, 8
"""Random commands of an episode, and the steps that each is held."""


@dataclass(frozen=True, slots=True)
class Timed:
    """One line with one number of worlds in one repeat: steps of all robots, and their seconds."""

    line: str
    worlds: int
    repeat: int
    steps: int
    seconds: float


def timed(number: int, worlds: tuple[int, ...], at_least: float, seed: int) -> list[Timed]:
    """Time every line for `at_least` seconds; the first repeat, -1, compiles and leaves no rows.

    One line comes right after the other, so that a slow machine slows both sides of a ratio.
    """
    rows = []
    for count in worlds:
        for line in NAMES:
            episodes = kheperax(SETTINGS[line], count) if line in SETTINGS else foraging(line, count, seed)
            steps, seconds = 0, 0.0
            while seconds < at_least:
                began = perf_counter()
                steps += episodes()
                seconds += perf_counter() - began
            rows.append(Timed(line, count, number, steps, seconds))
    return rows if number >= 0 else []


def foraging(line: str, worlds: int, seed: int) -> Callable[[], int]:
    """Runs our episodes: several for each world, so that all threads end at about the same time."""
    return lambda: int(run_teacher(episodes=4 * worlds, seed=seed, **TASKS[line]).steps.sum())


@cache
def kheperax(setting: str, worlds: int) -> Callable[[], int]:
    """Runs episodes of Kheperax in many worlds, shared among the devices; compiles once."""
    import jax
    import jax.numpy as jnp
    from kheperax.envs.kheperax_state import KheperaxState
    from kheperax.simu.posture import Posture
    from kheperax.tasks.main import KheperaxTask

    if not hasattr(jax, "tree_leaves"):  # Kheperax 0.2.0 calls it by the name that JAX has since removed
        jax.tree_leaves = jax.tree_util.tree_leaves
    config, rng, each = _config(setting), np.random.default_rng(0), -(-worlds // CORES)
    env, readings = KheperaxTask(config), len(config.robot.laser_angles) + 2  # and two bumpers
    if setting == "default":
        own = config.robot.posture
        starts = np.tile((float(own.x), float(own.y), float(own.angle)), (each * CORES, 1))
    else:
        low, high = (2 * RADIUS, 2 * RADIUS, -np.pi), (WIDTH - 2 * RADIUS, HEIGHT - 2 * RADIUS, np.pi)
        starts = rng.uniform(low, high, (each * CORES, 3))
    shares = starts.astype(np.float32).reshape(CORES, each, 3)
    wheels = rng.uniform(-1, 1, (CORES, COMMANDS, each, 2)).astype(np.float32)
    keys = jax.random.split(jax.random.PRNGKey(0), each * CORES).reshape(CORES, each, -1)
    spread = jax.pmap(lambda array: array)
    begin = Posture(*(spread(shares[:, :, i]) for i in range(3))), spread(keys), spread(wheels)

    def step(posture: Any, key: Any, action: Any) -> Any:
        robot = config.robot.replace(posture=posture)
        state = KheperaxState(robot=robot, maze=config.maze, obs=None, reward=0.0, done=False, random_key=key)
        after = env.step(state, action)
        return after.robot.posture, after.random_key, after.obs

    def episode(posture: Any, keys: Any, wheels: Any) -> Any:
        def a_round(number: Any, carried: Any) -> Any:
            posture, keys, seen = carried
            posture, keys, obs = jax.vmap(step)(posture, keys, wheels[number // HELD])
            return posture, keys, seen + obs  # summed, so that no reading can be left out as unused

        nothing = jnp.zeros((keys.shape[0], readings), jnp.float32)
        return jax.lax.fori_loop(0, COMMANDS * HELD, a_round, (posture, keys, nothing))

    compiled = jax.pmap(episode)

    def run() -> int:
        jax.block_until_ready(compiled(*begin))
        return COMMANDS * HELD * each * CORES

    return run


def _config(setting: str) -> Any:
    """Kheperax's configuration: `default` is its own, the others are the rectangle without and with noise."""
    from kheperax.simu.geoms import Pos, Segment
    from kheperax.simu.maze import Maze
    from kheperax.simu.posture import Posture
    from kheperax.simu.robot import Robot
    from kheperax.tasks.config import KheperaxConfig

    config, noisy = KheperaxConfig.get_default(), float(setting == "noise")
    if setting == "default":
        return config
    sides = []
    for x, y in OBSTACLES:
        corners = [(x + a * HALF, y + b * HALF) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        sides += [Segment(Pos(*a), Pos(*b)) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    config.maze = Maze.create(segments_list=sides, limits=((0.0, 0.0), (WIDTH, HEIGHT)))
    config.robot = Robot(
        posture=Posture(0.0, 0.0, 0.0),
        radius=RADIUS,
        laser_ranges=REACH,
        laser_angles=DIRECTIONS.astype(np.float32),
        std_noise_sensor_measures=noisy * SENSOR_NOISE,
    )
    config.action_scale, config.std_noise_wheel_velocities = TRAVEL, noisy * WHEEL_NOISE
    return config


def page(rows: Sequence[Timed]) -> Page:
    """Robot-steps a second by line and number of worlds, and how many times as fast ours are."""
    worlds = sorted({row.worlds for row in rows})
    speeds = {
        (name, count): [row.steps / row.seconds / 1e6 for row in pick(rows, line=name, worlds=count)]
        for name in NAMES
        for count in worlds
    }
    lines: list[dict[str, Value]] = []
    for (name, count), own in speeds.items():
        ratios = [speed / other for speed, other in zip(own, speeds[NOISY, count], strict=True)]
        times = UNKNOWN if name in SETTINGS else extremes(ratios)
        lines.append({"line": name, "worlds": count, "million robot-steps/s": extremes(own), "times Kheperax": times})
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    for number, name in enumerate(NAMES):
        rates = np.array([extremes(speeds[name, count]) for count in worlds]).T
        colour, style = THESIS if name in SETTINGS else OURS, ("-", "--", ":")[number % len(SETTINGS)]
        bars = np.abs(rates[1:] - rates[0])
        axes.errorbar(worlds, rates[0], bars, label=name, color=colour, ls=style, capsize=3)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log", base=2)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xticks(worlds, [f"{count:,}" for count in worlds])
    axes.set_xlabel("worlds together; bars: lowest and highest repeat")
    axes.set_ylabel("million robot-steps a second")
    axes.legend(fontsize=SMALL, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    grid(axes, "both")
    note = (
        "Median [lowest, highest] of the repeats. The ratio to Kheperax with its noise is taken in each repeat. "
        "Compilation does not count. Processor only."
    )
    table = table_of("robot_steps", "Robot-steps a second", note, lines, {"million robot-steps/s": 2})
    return Page("Comparison with Kheperax", [Picture("kheperax", "robot-steps a second", figure), table])


def main() -> int:
    """Run the benchmark."""
    given = parse("kheperax", __doc__, Count("repeats", 7, 2, "repeats, of which the median counts"), jobs=None)
    sys.path[:] = [folder for folder in sys.path if Path(folder) != Path(__file__).parent]  # this file has its name
    os.environ["JAX_PLATFORMS"] = "cpu"
    os.environ["XLA_FLAGS"] = f"--xla_force_host_platform_device_count={CORES} --xla_cpu_enable_fast_math=true"
    worlds, at_least = (QUICK_WORLDS, 0.05) if given.quick else (WORLDS, 0.25)
    units = [Job(str(k), timed, (k, worlds, at_least, given.seed)) for k in range(-1, given.repeats)]
    try:
        rows = collect(given, units, {Timed: "rows"}).of(Timed)
    except ImportError as error:
        given.refuse(f"{error}; pip install kheperax==0.2.0 jax")
    return finish(given, page(rows))


if __name__ == "__main__":
    sys.exit(main())
