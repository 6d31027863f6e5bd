"""The cache key of an entrance: a checksum of the sources of all its functions."""

import re
import zlib
from importlib.util import find_spec
from pathlib import Path

_PACKAGE = __name__.partition(".")[0]
_IMPORT = re.compile(rf"^from ({_PACKAGE}[\w.]*) import (\([^)]*\)|[^\n(]+)$", re.MULTILINE)


def cache_key(module: str) -> int:
    """Checksum of a module and of all modules of this package that it imports, directly or indirectly.

    Args:
        module: Full name of a module of this package.
    """
    total = 0
    for path in sorted(sources_of(module)):
        total = zlib.crc32(path.read_bytes(), total)
    return total


def sources_of(module: str) -> set[Path]:
    """The source files that `cache_key` reads."""
    paths: set[Path] = set()
    names, seen = [module], set()
    while names:
        name = names.pop()
        if name in seen:
            continue
        seen.add(name)
        spec = find_spec(name)
        if spec is None or spec.origin is None:
            continue
        path = Path(spec.origin)
        paths.add(path)
        for package, imported in _IMPORT.findall(path.read_text(encoding="utf-8")):
            names.append(package)
            for item in re.sub(r"#.*", "", imported).strip("()").split(","):
                part = item.strip().partition(" ")[0]
                if part and _is_module(f"{package}.{part}"):
                    names.append(f"{package}.{part}")
    return paths


def _is_module(name: str) -> bool:
    package, _, part = name.rpartition(".")
    spec = find_spec(package)
    locations = spec.submodule_search_locations if spec is not None else None
    return any(
        (Path(place) / f"{part}.py").exists() or (Path(place) / part).is_dir() for place in locations or ()
    )
