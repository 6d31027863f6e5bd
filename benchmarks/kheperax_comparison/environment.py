"""Kheperax' own virtual environment, made once and used again."""

import os
import shutil
import subprocess
import venv
from pathlib import Path

KHEPERAX = "0.2.0"
WANTED = (f"kheperax=={KHEPERAX}", "jax")
_SHOWN = 12
"""Last lines of a program's output that an error quotes."""


class NoKheperax(RuntimeError):  # noqa: N818 (the name says what is wrong)
    """Kheperax cannot be installed or run; the message says why."""


def python_of(folder: Path) -> Path:
    """The Python of a virtual environment, which need not exist yet."""
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def environment(folder: Path) -> Path:
    """The Python of an environment with Kheperax; the environment is made if nothing is there.

    Reports its progress on standard output. An incomplete environment is removed.

    Raises:
        NoKheperax: The folder is something else, or installing failed.
    """
    python = python_of(folder)
    if python.exists():
        print(f"Kheperax: using the virtual environment {folder}", flush=True)
        return python
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise NoKheperax(
            f"--venv is {str(folder)!r}, which is no virtual environment ({python} is missing); "
            "allowed: one, or a folder that does not exist yet"
        )
    print(
        f"Kheperax: making the virtual environment {folder} and installing {' and '.join(WANTED)} into it. "
        "What they need comes to some 1.2 GB on disk and takes some minutes, once.",
        flush=True,
    )
    try:
        _make(folder)
        _install(python)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    print(f"Kheperax: installed, {megabytes(folder):,.0f} MB", flush=True)
    return python


def _make(folder: Path) -> None:
    try:
        venv.create(folder, with_pip=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise NoKheperax(f"{folder} cannot be made (on Debian: apt install python3-venv): {error}") from error


def _install(python: Path) -> None:
    command = [
        str(python),
        "-m",
        "pip",
        "install",
        "--disable-pip-version-check",
        "--progress-bar",
        "off",
        *WANTED,
    ]
    finished = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if finished.returncode:
        raise NoKheperax(
            f"{' '.join(command)}\nfailed with status {finished.returncode}; its last output:\n{last(finished.stdout)}"
        )


def megabytes(folder: Path) -> float:
    """What a folder takes on disk, links not followed."""
    files = (path for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    return sum(path.stat().st_size for path in files) / 1e6


def last(text: str) -> str:
    """The last lines of a text."""
    return "\n".join(text.rstrip().splitlines()[-_SHOWN:])


def variables(devices: int) -> dict[str, str]:
    """Environment variables under which JAX uses the processor only, as so many devices, and is fastest.

    Fast math makes Kheperax a quarter faster and changes no reading by more than 0.001 mm.
    """
    flags = f"--xla_force_host_platform_device_count={devices} --xla_cpu_enable_fast_math=true"
    return {**os.environ, "JAX_PLATFORMS": "cpu", "XLA_FLAGS": flags}
