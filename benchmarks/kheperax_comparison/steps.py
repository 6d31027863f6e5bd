"""Kheperax stepped by JAX. Run by the Python of Kheperax's own environment: nothing of this package is imported.

    python steps.py work.npz

Reads requests from standard input and answers on standard output, one JSON object a line; the first answer, to no
request, says what is installed. `theirs.py` is the other end, `work.py` makes the file.

Kheperax is given its best: its own `KheperaxTask.step`, vectorised over worlds that share one maze, looped inside
JAX, compiled, and with one JAX device for each core (one device alone keeps to one core). JAX's other random number
generators were slower, and a maze for each world was no faster.
"""

import json
import os
import sys
import time
from importlib.metadata import version
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from kheperax.envs.kheperax_state import KheperaxState
from kheperax.simu.geoms import Pos, Segment
from kheperax.simu.maze import Maze
from kheperax.simu.posture import Posture
from kheperax.simu.robot import Robot
from kheperax.tasks.config import KheperaxConfig
from kheperax.tasks.main import KheperaxTask

if not hasattr(jax, "tree_leaves"):  # Kheperax 0.2.0 calls it by the name that JAX has since removed
    jax.tree_leaves = jax.tree_util.tree_leaves

Arrays = dict[str, Any]


def config_for(setting: str, work: Arrays) -> Any:
    """Kheperax's configuration: `default` is its own, the others are ours without and with noise."""
    config = KheperaxConfig.get_default()
    if setting == "default":
        return config
    noisy = {"none": 0.0, "noise": 1.0}[setting]
    half = float(work["half_side"])
    squares = [side for x, y in work["obstacles"] for side in _square(float(x), float(y), half)]
    x1, y1, x2, y2 = map(float, work["bounds"])
    config.maze = Maze.create(segments_list=squares, limits=((x1, y1), (x2, y2)))
    config.robot = Robot(
        posture=Posture(0.0, 0.0, 0.0),
        radius=float(work["radius"]),
        laser_ranges=float(work["reach"]),
        laser_angles=jnp.asarray(work["directions"], jnp.float32),
        std_noise_sensor_measures=noisy * float(work["sensor_noise"]),
    )
    config.action_scale = float(work["travel"])
    config.std_noise_wheel_velocities = noisy * float(work["wheel_noise"])
    return config


def _square(x: float, y: float, half: float) -> list[Any]:
    corners = [(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)]
    return [Segment(Pos(*a), Pos(*b)) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


class Worlds:
    """Many worlds of one configuration, ready to be stepped.

    Attributes:
        count: How many: those asked for, rounded up to a multiple of the devices.
        first_call: Seconds of the first call, which traces and compiles.
    """

    def __init__(self, setting: str, worlds: int, work: Arrays) -> None:
        devices = int(work["devices"])
        each = -(-worlds // devices)
        self.count = each * devices
        chosen = np.arange(self.count) % len(work["starts"])
        config = config_for(setting, work)
        starts = np.asarray(work["starts"], np.float32)[chosen]
        if setting == "default":
            own = config.robot.posture
            starts = np.tile(np.array((own.x, own.y, own.angle), np.float32), (self.count, 1))
        wheels = np.asarray(work["wheels"], np.float32)[:, chosen]
        self._rounds = len(wheels) * int(work["held"])
        spread = jax.pmap(lambda array: array)
        shares = starts.reshape(devices, each, 3)
        self._start = (
            Posture(*(spread(shares[:, :, i]) for i in range(3))),
            spread(jax.random.split(jax.random.PRNGKey(0), self.count).reshape(devices, each, -1)),
        )
        self._wheels = spread(np.moveaxis(wheels.reshape(len(wheels), devices, each, 2), 1, 0))
        self._steps = jax.pmap(_steps_of(config, int(work["held"])), in_axes=(0, 0, 0, None, None))
        begun = time.perf_counter()
        jax.block_until_ready(self._steps(*self._start, self._wheels, 0, 1))
        self.first_call = time.perf_counter() - begun

    def episode(self, calls: bool) -> float:
        """Seconds of an episode from the start.

        Args:
            calls: Come back to Python after every step with the readings as an array, instead of only at the end.
        """
        begun = time.perf_counter()
        if not calls:
            jax.block_until_ready(self._steps(*self._start, self._wheels, 0, self._rounds))
            return time.perf_counter() - begun
        posture, keys = self._start
        for number in range(self._rounds):
            posture, keys, seen = self._steps(posture, keys, self._wheels, number, 1)
            np.asarray(seen)
        return time.perf_counter() - begun

    def timed(self, seconds: float, calls: bool) -> dict[str, Any]:
        """Robot-steps and the seconds they took: whole episodes, until `seconds` have passed."""
        taken, episodes = 0.0, 0
        while taken < seconds:
            taken += self.episode(calls)
            episodes += 1
        return {
            "worlds": self.count,
            "steps": episodes * self._rounds * self.count,
            "seconds": taken,
            "first_call": self.first_call,
        }


def _steps_of(config: Any, held: int) -> Any:
    """The function that steps one device's worlds: postures, keys and summed readings after some rounds."""
    env = KheperaxTask(config)
    readings = len(config.robot.laser_angles) + 2  # and two bumpers

    def step(posture: Any, key: Any, action: Any) -> Any:
        state = KheperaxState(
            robot=config.robot.replace(posture=posture),
            maze=config.maze,
            obs=None,
            reward=0.0,
            done=False,
            random_key=key,
        )
        after = env.step(state, action)
        return after.robot.posture, after.random_key, after.obs

    def steps(posture: Any, keys: Any, wheels: Any, first: Any, rounds: Any) -> Any:
        def a_round(number: Any, carried: Any) -> Any:
            posture, keys, seen = carried
            posture, keys, obs = jax.vmap(step)(posture, keys, wheels[number // held])
            return posture, keys, seen + obs  # summed, so that no reading can be left out as unused

        nothing = jnp.zeros((keys.shape[0], readings), jnp.float32)
        return jax.lax.fori_loop(first, first + rounds, a_round, (posture, keys, nothing))

    return steps


def about(work: Arrays) -> dict[str, Any]:
    """Versions, and the observed behaviour of Kheperax."""
    config = config_for("none", work)
    env = KheperaxTask(config)
    step = jax.jit(env.step)
    x1, y1, _, y2 = map(float, work["bounds"])
    radius = float(work["radius"])
    state = env.reset(jax.random.PRNGKey(0))
    # Into the left wall, at right angles, and as far back.
    posture = Posture(*map(jnp.float32, (x1 + 2 * radius, (y1 + y2) / 2, np.pi)))
    state = state.replace(robot=config.robot.replace(posture=posture))
    begun = float(posture.x)
    state = step(state, jnp.ones(2))
    travel = begun - float(state.robot.posture.x)
    for _ in range(9):
        state = step(state, jnp.ones(2))
    touched = float(state.robot.posture.x)
    for _ in range(10):
        state = step(state, -jnp.ones(2))
    return {
        "kheperax": version("kheperax"),
        "jax": version("jax"),
        "python": sys.version.split()[0],
        "devices": len(jax.devices()),
        "numbers": str(state.robot.posture.x.dtype),
        "segments": int(config.maze.walls.p1.x.shape[0]),
        "readings": int(state.obs.shape[0]),
        "travel": travel,
        "into_wall": radius - (touched - x1),
        "backed_off": float(state.robot.posture.x) - touched,
    }


def main(path: str) -> None:
    """Answer requests until there are no more."""
    # Output of libraries must not get between the answers.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    with np.load(path) as file:
        work = dict(file)
    _say(answers, about(work))
    ready: dict[tuple[str, int], Worlds] = {}
    for line in sys.stdin:
        asked = json.loads(line)
        key = asked["setting"], asked["worlds"]
        if key not in ready:
            ready[key] = Worlds(*key, work)
        _say(answers, ready[key].timed(asked["at_least"], asked["calls"]))


def _say(answers: Any, answer: dict[str, Any]) -> None:
    print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
