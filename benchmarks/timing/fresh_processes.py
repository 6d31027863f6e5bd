"""Fresh processes: how long an import takes, and how much memory the main job needs."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from timing.measures import Job, Measure, Values

SECTION = "Processes"
NOTE = "Fresh processes."
IMPORT = Measure(
    SECTION,
    "import khepera_forage",
    "s",
    "timed inside the process, without the start of the interpreter",
    0.5,
)
MEMORY = Measure(
    SECTION,
    "peak memory of khepera-forage reproduce --quick",
    "MB",
    "resident memory of all its processes together, sampled 20 times a second; shared pages count for each process",
    1_000,
)
_TIMED = "import time; start = time.perf_counter(); import khepera_forage; print(time.perf_counter() - start)"


def import_job() -> Values:
    """Measure one import."""
    finished = subprocess.run([sys.executable, "-c", _TIMED], check=True, capture_output=True, text=True)
    return {IMPORT: float(finished.stdout)}


def memory_job(seed: int) -> Job:
    """Measure the main job in small.

    Raises:
        OSError: There is no `/proc` to look at processes.
    """

    def run() -> Values:
        with tempfile.TemporaryDirectory() as out:
            command = [
                sys.executable,
                "-m",
                "khepera_forage.cli.main",
                "reproduce",
                "--quick",
                "--seed",
                str(seed),
                "--out",
                out,
            ]
            # A session of its own identifies its processes and their children.
            running = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL)
            peak = 0
            while running.poll() is None:
                peak = max(peak, _resident(running.pid))
                time.sleep(0.05)
        if running.returncode:
            raise subprocess.CalledProcessError(running.returncode, command)
        return {MEMORY: peak / 1e6}

    return run


def _resident(session: int) -> int:
    """Bytes of resident memory of all processes of a session."""
    total = 0
    for process in Path("/proc").iterdir():
        if process.name.isdigit():
            try:
                status = (process / "stat").read_text().rpartition(")")[2].split()
            except OSError:  # the process has ended
                continue
            if int(status[3]) == session:
                total += int(status[21]) * os.sysconf("SC_PAGE_SIZE")
    return total
