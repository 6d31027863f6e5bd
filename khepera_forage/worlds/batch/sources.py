"""A number that changes with the source of whatever is compiled."""

import zlib
from pathlib import Path

_PACKAGE = Path(__file__).parents[2]
_COMPILED = (
    "foraging/*.py",
    "worlds/batch/*.py",
    "envs/batch/*.py",
    "robots/khepera.py",
    "robots/proximity.py",
    "vision/scene.py",
    "vision/shapes.py",
    "vision/retracking.py",
    "worlds/pymunk_khepera.py",
    "worlds/wall_watch.py",
    "envs/placement.py",
    "envs/register.py",
    "policies/ballot.py",
    "policies/votes.py",
)


def _sum() -> int:
    total = 0
    for pattern in _COMPILED:
        for path in sorted(_PACKAGE.glob(pattern)):
            total = zlib.crc32(path.read_bytes(), total)
    return total


SOURCES = _sum()
