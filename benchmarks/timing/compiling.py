"""The time of a first call that compiles, and of a later process that finds the kernels on disk. Needs numba."""

import os
import subprocess
import sys
from tempfile import TemporaryDirectory

from timing.measures import Measure, Values

SECTION = "Compiling"
NOTE = "Seconds from the import to the end of the first call in a fresh process; then again in another."
_STEP = "; env.step(env.reset(seed=0)[1]['correct_behaviour'])"
CALLS = {
    "make_vec, a step of 4,096 worlds": "import gymnasium as gym, khepera_forage; "
    "env = gym.make_vec('khepera_forage/Corridor-v1', num_envs=4096)" + _STEP,
    'make with backend="compiled", a step': "import gymnasium as gym, khepera_forage; "
    "env = gym.make('khepera_forage/Corridor-v1', backend='compiled')" + _STEP,
    "run_teacher, 128 recalls": "from khepera_forage.rollouts.compiled.recalls import run_teacher; "
    "run_teacher('corridor', 128)",
    "train_learners, 128 learners": "from khepera_forage.rollouts.compiled.training import train_learners; "
    "train_learners(128)",
}
FIRST = {call: Measure(SECTION, f"{call}, nothing on disk", "s", "", 45.0) for call in CALLS}
AGAIN = {call: Measure(SECTION, f"{call}, kernels on disk", "s") for call in CALLS}
_SCRIPT = "from time import perf_counter; start = perf_counter(); {}; print(perf_counter() - start)"


def job() -> Values:
    """All calls once: a compilation takes long enough to be measured."""
    values: Values = {}
    for call, code in CALLS.items():
        with TemporaryDirectory() as folder:
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
            for measures in (FIRST, AGAIN):
                command = [sys.executable, "-c", _SCRIPT.format(code)]
                done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
                values[measures[call]] = float(done.stdout)
    return values
