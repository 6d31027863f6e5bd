"""Builds the wheel as it is published."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PIP = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")

IMPORTS = """
import importlib, pkgutil, khepera_forage
for found in pkgutil.walk_packages(khepera_forage.__path__, "khepera_forage.", onerror=lambda name: None):
    try:
        importlib.import_module(found.name)
    except ImportError as error:
        print(found.name, "|", error)
print(khepera_forage.__file__)
"""
"""Imports every module; prints those that cannot be imported, with the error, and where the package is."""


def built_wheel(folder: Path) -> Path:
    """The wheel, built in a folder."""
    sources = folder / "sources"  # a build leaves files beside them
    shutil.copytree(ROOT / "khepera_forage", sources / "khepera_forage")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, sources)
    build = ["wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(sources)]
    subprocess.run([*PIP, *build], check=True, capture_output=True)
    (built,) = folder.glob("*.whl")
    return built
