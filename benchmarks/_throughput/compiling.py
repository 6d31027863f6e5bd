"""How long a first call compiles, and how long a later process takes to find the kernels on disk. Needs numba."""

import os
import subprocess
import sys
from tempfile import TemporaryDirectory

from _throughput.lines import Measure, Values

SECTION = "Compiling"
NOTE = "Seconds from the import to the first step in a fresh process; then again in another."
FIRST = {
    "make_vec": Measure(SECTION, "make_vec, nothing on disk", "s", "4,096 worlds", 30.0),
    "make": Measure(SECTION, 'make with physics="batch", nothing on disk', "s", "one world", 30.0),
}
AGAIN = {
    "make_vec": Measure(SECTION, "make_vec, kernels on disk", "s"),
    "make": Measure(SECTION, 'make with physics="batch", kernels on disk', "s"),
}
_SCRIPT = """
from time import perf_counter
start = perf_counter()
import gymnasium as gym, khepera_forage
env = gym.{}
info = env.reset(seed=0)[1]
env.step(info["correct_behaviour"])
print(perf_counter() - start)
"""
_MADE = {
    "make_vec": 'make_vec("khepera_forage/Corridor-v0", num_envs=4096)',
    "make": 'make("khepera_forage/Corridor-v0", physics="batch")',
}


def job() -> Values:
    """Everything, once: a compilation takes long enough to be measured."""
    values: Values = {}
    with TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        for way in _MADE:
            for measures in (FIRST, AGAIN):
                command = [sys.executable, "-c", _SCRIPT.format(_MADE[way])]
                done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
                values[measures[way]] = float(done.stdout)
    return values
