"""Kheperax stepped by JAX, for `kheperax.py`. Run by the Python of Kheperax's environment, which lacks this package.

Reads requests from standard input and answers on standard output, one JSON object a line. Kheperax is given its best:
its own `KheperaxTask.step`, vectorised over worlds that share one maze, looped inside JAX, compiled, and with one JAX
device for each core. Fast math makes it a quarter faster and changes no reading by more than 0.001 mm.
"""

import json
import os
import sys
import time
from typing import Any

CORES = int(sys.argv[1]) if __name__ == "__main__" else 1
os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["XLA_FLAGS"] = f"--xla_force_host_platform_device_count={CORES} --xla_cpu_enable_fast_math=true"

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from kheperax.envs.kheperax_state import KheperaxState  # noqa: E402
from kheperax.simu.geoms import Pos, Segment  # noqa: E402
from kheperax.simu.maze import Maze  # noqa: E402
from kheperax.simu.posture import Posture  # noqa: E402
from kheperax.simu.robot import Robot  # noqa: E402
from kheperax.tasks.config import KheperaxConfig  # noqa: E402
from kheperax.tasks.main import KheperaxTask  # noqa: E402

if not hasattr(jax, "tree_leaves"):  # Kheperax 0.2.0 calls it by the name that JAX has since removed
    jax.tree_leaves = jax.tree_util.tree_leaves

WIDTH, HEIGHT, RADIUS, REACH, HALF = 650.0, 600.0, 27.5, 87.5, 17.5
"""mm: the thesis's rectangle, a Khepera, how far its sensors see, and half the side of an obstacle."""
OBSTACLES = ((200.0, 200.0), (450.0, 200.0), (200.0, 400.0), (450.0, 400.0))
DIRECTIONS = np.radians((90, 45, 10, -10, -45, -90, 180, 180))
TRAVEL, WHEEL_NOISE, SENSOR_NOISE = 16.0, 0.4, 1.2
"""mm: a wheel at full speed in a step, and standard deviations like those of the laboratory."""
COMMANDS, HELD = 8, 8
"""Random commands of an episode, and the steps that each is held."""


def config_of(setting: str) -> Any:
    """Kheperax's configuration: `default` is its own, the others are the rectangle without and with noise."""
    config = KheperaxConfig.get_default()
    if setting == "default":
        return config
    noisy = float(setting == "noise")
    sides = []
    for x, y in OBSTACLES:
        corners = [(x + a * HALF, y + b * HALF) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        sides += [Segment(Pos(*a), Pos(*b)) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    config.maze = Maze.create(segments_list=sides, limits=((0.0, 0.0), (WIDTH, HEIGHT)))
    config.robot = Robot(
        posture=Posture(0.0, 0.0, 0.0),
        radius=RADIUS,
        laser_ranges=REACH,
        laser_angles=jnp.asarray(DIRECTIONS, jnp.float32),
        std_noise_sensor_measures=noisy * SENSOR_NOISE,
    )
    config.action_scale, config.std_noise_wheel_velocities = TRAVEL, noisy * WHEEL_NOISE
    return config


class Worlds:
    """Many worlds of one configuration, shared among the devices, ready to be stepped."""

    def __init__(self, setting: str, worlds: int) -> None:
        each = -(-worlds // CORES)
        self.count = each * CORES
        rng, config = np.random.default_rng(0), config_of(setting)
        own = config.robot.posture
        low, high = (2 * RADIUS, 2 * RADIUS, -np.pi), (WIDTH - 2 * RADIUS, HEIGHT - 2 * RADIUS, np.pi)
        starts = np.tile((float(own.x), float(own.y), float(own.angle)), (self.count, 1))
        if setting != "default":
            starts = rng.uniform(low, high, (self.count, 3))
        wheels = rng.uniform(-1, 1, (CORES, COMMANDS, each, 2)).astype(np.float32)
        shares = starts.astype(np.float32).reshape(CORES, each, 3)
        spread = jax.pmap(lambda array: array)
        keys = jax.random.split(jax.random.PRNGKey(0), self.count).reshape(CORES, each, -1)
        self._start = Posture(*(spread(shares[:, :, i]) for i in range(3))), spread(keys), spread(wheels)
        self._steps = jax.pmap(_steps_of(config), in_axes=(0, 0, 0, None))
        began = time.perf_counter()
        jax.block_until_ready(self._steps(*self._start, 1))
        self.first_call = time.perf_counter() - began

    def timed(self, at_least: float) -> dict[str, Any]:
        """Robot-steps and their seconds: whole episodes, until `at_least` seconds have passed."""
        taken, episodes = 0.0, 0
        while taken < at_least:
            began = time.perf_counter()
            jax.block_until_ready(self._steps(*self._start, COMMANDS * HELD))
            taken += time.perf_counter() - began
            episodes += 1
        steps = episodes * COMMANDS * HELD * self.count
        return {"steps": steps, "seconds": taken, "first_call": self.first_call}


def _steps_of(config: Any) -> Any:
    env, readings = KheperaxTask(config), len(config.robot.laser_angles) + 2  # and two bumpers

    def step(posture: Any, key: Any, action: Any) -> Any:
        robot = config.robot.replace(posture=posture)
        state = KheperaxState(robot=robot, maze=config.maze, obs=None, reward=0.0, done=False, random_key=key)
        after = env.step(state, action)
        return after.robot.posture, after.random_key, after.obs

    def steps(posture: Any, keys: Any, wheels: Any, rounds: Any) -> Any:
        def a_round(number: Any, carried: Any) -> Any:
            posture, keys, seen = carried
            posture, keys, obs = jax.vmap(step)(posture, keys, wheels[number // HELD])
            return posture, keys, seen + obs  # summed, so that no reading can be left out as unused

        nothing = jnp.zeros((keys.shape[0], readings), jnp.float32)
        return jax.lax.fori_loop(0, rounds, a_round, (posture, keys, nothing))

    return steps


def main() -> None:
    """Answer requests until there are no more."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # output of libraries must not get between the answers
    ready: dict[tuple[str, int], Worlds] = {}
    for line in sys.stdin:
        asked = json.loads(line)
        key = asked["setting"], asked["worlds"]
        if key not in ready:
            ready[key] = Worlds(*key)
        print(json.dumps(ready[key].timed(asked["at_least"])), file=answers, flush=True)


if __name__ == "__main__":
    main()
