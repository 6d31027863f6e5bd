"""Starts scripts of `benchmarks/` with --help, each as if nothing of this repository had been imported before.

    python -W error -m tests.benchmarks.start_alone FOLDER SCRIPT ...

Each script has a process of its own, a copy of one that has imported only other packages: to import those takes ten
times as long as the script's own modules. FOLDER gets what each script prints, and its errors.
"""

import os
import runpy
import sys
import warnings
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIBRARIES = (
    "numpy",
    "scipy.stats",
    "sklearn.ensemble",
    "gymnasium",
    "pymunk",
    "joblib",
    "tqdm",
    "numba",
    "cv2",
)
"""What takes long."""


def start(script: str, folder: Path) -> int:
    """Start a script with --help; returns the status of its process."""
    with warnings.catch_warnings():
        # Python 3.12 and later: the libraries have threads, which a copy of the process has not.
        warnings.simplefilter("ignore", DeprecationWarning)
        process = os.fork()
    if process:
        return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    status: object = 1
    try:
        with (
            (folder / f"{script}.txt").open("w") as output,
            (folder / f"{script}.errors").open("w") as errors,
        ):
            os.dup2(output.fileno(), 1)
            os.dup2(errors.fileno(), 2)
        path = ROOT / "benchmarks" / f"{script}.py"
        sys.argv, sys.path[0] = [str(path), "--help"], str(path.parent)
        runpy.run_path(str(path), run_name="__main__")
    except SystemExit as end:
        status = end.code
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status if isinstance(status, int) else 1)


def main(folder: Path, scripts: list[str]) -> int:
    """Start all; returns 1 if one of them failed."""
    for library in LIBRARIES:
        if find_spec(library.partition(".")[0]) is not None:
            import_module(library)
    return max(start(script, folder) for script in scripts)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
