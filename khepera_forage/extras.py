"""Optional dependencies: which extra installs what, and one error that names all that is missing."""

from importlib.util import find_spec

from gymnasium.error import DependencyNotInstalled

EXTRAS = {
    "render": ("pygame", "PIL"),
    "plots": ("matplotlib",),
    "robots": ("serial",),
    "toio": ("toio",),
    "camera": ("cv2",),
    "fast": ("numba",),
    "baselines": ("stable_baselines3",),
    "minari": ("minari", "h5py", "PIL"),
}
"""The modules of each extra of `pyproject.toml`."""


class MissingExtraError(DependencyNotInstalled, ImportError):
    """An optional dependency is not installed."""


def require(what: str, *extras: str, otherwise: str = "") -> None:
    """Check that extras are installed, before anything is done that needs them.

    Args:
        what: What needs them, for the message.
        *extras: Names in `EXTRAS`.
        otherwise: What else can be done, for the end of the message.

    Raises:
        MissingExtraError: Modules are missing; the message has one command that installs everything.
    """
    modules = [module for extra in extras for module in EXTRAS[extra] if find_spec(module) is None]
    if modules:
        needed = ",".join(extra for extra in extras if set(EXTRAS[extra]) & set(modules))
        raise MissingExtraError(f"{what} needs {', '.join(modules)}: pip install 'khepera-forage[{needed}]'{otherwise}")
