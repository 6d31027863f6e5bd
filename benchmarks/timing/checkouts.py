"""The package of a commit and of this checkout, side by side in a temporary folder."""

import shutil
import signal
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import NamedTuple

PACKAGE = "khepera_forage"
_SIGNALS = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Checkout(NamedTuple):
    """A version of the package.

    Attributes:
        name: In tables.
        version: Short id of its commit, with a note of uncommitted changes.
        root: Folder that contains the package.
        cache: Folder for the machine code of its kernels, outside `root`.
    """

    name: str
    version: str
    root: Path
    cache: Path


@contextmanager
def checkouts(commit: str, root: Path) -> Iterator[tuple[Checkout, Checkout]]:
    """The package of a commit, and a copy of the package in `root`.

    This checkout is copied, so that edits during the measurement have no effect. The temporary folder is removed at
    the end, also after an error, an interrupt or a signal that ends the process. Git's own state does not change.

    Args:
        commit: As git names it: an id, a branch, a tag, `HEAD~2`.
        root: Folder of this checkout.

    Raises:
        ValueError: `root` is not a git checkout, or the commit is unknown or does not contain the package.
    """
    version = commit_id(commit, root)
    with ExitStack() as stack:
        stack.enter_context(_exit_on_signals())
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="beside-"))).resolve()
        theirs = Checkout(version, version, folder / "commit", folder / "commit_kernels")
        ours = Checkout("this checkout", _working_version(root), folder / "this", folder / "this_kernels")
        _extract(version, root, theirs.root)
        shutil.copytree(root / PACKAGE, ours.root / PACKAGE, ignore=shutil.ignore_patterns("__pycache__"))
        yield theirs, ours


def commit_id(commit: str, root: Path) -> str:
    """The short id of a commit.

    Raises:
        ValueError: As for `checkouts`.
    """
    if _git(root, "rev-parse", "--git-dir") is None:
        raise ValueError(
            f"{root} is not a git checkout, or git is missing; --beside needs a clone of the repository"
        )
    full = _git(root, "rev-parse", "--verify", "--quiet", f"{commit}^{{commit}}")
    if full is None:
        raise ValueError(
            f"commit {commit!r} is unknown in {root}; allowed: an id, branch or tag that `git log` shows "
            "(a shallow clone lacks older ones: git fetch --unshallow)"
        )
    if not _git(root, "ls-tree", full, "--", PACKAGE):
        raise ValueError(f"commit {commit!r} of {root} has no folder {PACKAGE}; allowed: one that has it")
    return _git(root, "rev-parse", "--short", full) or full


def _working_version(root: Path) -> str:
    """The short id of the commit checked out, with a note if the package differs from it."""
    changed = _git(root, "status", "--porcelain", "--", PACKAGE)
    return f"{_git(root, 'rev-parse', '--short', 'HEAD')}{' with uncommitted changes' if changed else ''}"


def _extract(version: str, root: Path, folder: Path) -> None:
    """Write the package of a commit."""
    folder.mkdir()
    archive = folder.with_suffix(".zip")
    subprocess.run(
        ["git", "-C", root, "archive", "--format=zip", f"--output={archive}", version, "--", PACKAGE],
        check=True,
        capture_output=True,
    )
    with zipfile.ZipFile(archive) as files:
        files.extractall(folder)


def _git(root: Path, *arguments: str) -> str | None:
    """What git prints; None if it fails or is not installed."""
    try:
        done = subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True)
    except FileNotFoundError:
        return None
    return None if done.returncode else done.stdout.strip()


@contextmanager
def _exit_on_signals() -> Iterator[None]:
    """Let signals that end a process raise SystemExit, so that temporary folders are removed."""

    def leave(number: int, _: FrameType | None) -> None:
        sys.exit(128 + number)

    usual = {number: signal.signal(number, leave) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
