"""Kheperax' side: a process with its own Python environment that steps it on request."""

import json
import subprocess
import tempfile
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self, TypeVar, get_type_hints

import numpy as np

from kheperax_comparison.environment import KHEPERAX, NoKheperax, last, variables
from kheperax_comparison.work import Work

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

_STEPS = Path(__file__).with_name("steps.py")
_AnswerT = TypeVar("_AnswerT", bound="DataclassInstance")


@dataclass(frozen=True, slots=True)
class About:
    """Versions, and the observed behaviour of Kheperax before anything is timed.

    Attributes:
        kheperax: Version.
        jax: Version.
        python: Version.
        devices: That JAX shares the worlds among.
        numbers: Type of a robot's coordinates.
        segments: Line segments of the maze.
        readings: Numbers that a robot senses.
        travel: mm that a robot moves in a step at full speed.
        into_wall: mm by which a robot driven against a wall overlaps it in the end.
        backed_off: mm by which ten steps backwards move it away from there.
    """

    kheperax: str
    jax: str
    python: str
    devices: int
    numbers: str
    segments: int
    readings: int
    travel: float
    into_wall: float
    backed_off: float


@dataclass(frozen=True, slots=True)
class Timed:
    """Robot-steps and their time.

    Attributes:
        worlds: How many were stepped together.
        steps: Of all robots.
        seconds: Of these steps.
        first_call: Seconds of the first call with these worlds, which compiles.
    """

    worlds: int
    steps: int
    seconds: float
    first_call: float


def answer_of(line: str, kind: type[_AnswerT]) -> _AnswerT:
    """An answer of `steps.py`, read strictly.

    Raises:
        NoKheperax: Not one JSON object with exactly the fields of `kind` and values of their types.
    """
    types = get_type_hints(kind)
    names = [field.name for field in fields(kind)]
    try:
        values = json.loads(line)
    except json.JSONDecodeError as error:
        raise NoKheperax(f"steps.py answered {line!r}; allowed: a JSON object ({error})") from error
    if not isinstance(values, dict) or sorted(values) != sorted(names):
        raise NoKheperax(f"steps.py answered {line!r}; allowed: an object with {', '.join(names)}")
    for name, value in values.items():
        if type(value) is not types[name]:
            raise NoKheperax(f"steps.py answered {name} {value!r}; allowed: {types[name].__name__}")
    return kind(**values)


class Kheperax:
    """Kheperax in its own process; close it afterwards.

    Args:
        python: Of the environment that has it.
        work: For at least as many worlds as are needed.
        devices: Cores to use.

    Attributes:
        about: Versions and behaviour.

    Raises:
        NoKheperax: It does not start, or is of another version.
    """

    def __init__(self, python: Path, work: Work, devices: int) -> None:
        self._python = python
        self._folder = tempfile.TemporaryDirectory()
        path = Path(self._folder.name)
        np.savez(path / "work.npz", **work.for_kheperax(devices))
        self._errors = path / "errors"
        try:
            with self._errors.open("wb") as errors:
                # -I keeps this package and everything in PYTHONPATH out of its environment.
                self._process = subprocess.Popen(
                    [str(python), "-I", str(_STEPS), str(path / "work.npz")],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=errors,
                    text=True,
                    env=variables(devices),
                )
        except OSError as error:
            self._folder.cleanup()
            raise NoKheperax(f"{python} does not run: {error}") from error
        try:
            self.about = self._answer(About)
            if self.about.kheperax != KHEPERAX:
                raise NoKheperax(f"{python} has kheperax {self.about.kheperax!r}; allowed: {KHEPERAX!r}")
        except BaseException:
            self.close()
            raise

    def timed(self, setting: str, worlds: int, at_least: float, calls: bool) -> Timed:
        """Whole episodes until `at_least` seconds have passed.

        Args:
            setting: `none` or `noise`, or `default` for Kheperax as it comes.
            worlds: How many together; rounded up to a multiple of the devices.
            at_least: Seconds.
            calls: One call a step, the readings handed to Python, instead of all steps inside JAX.

        Raises:
            NoKheperax: It failed.
        """
        assert self._process.stdin is not None
        request = {"setting": setting, "worlds": worlds, "at_least": at_least, "calls": calls}
        with suppress(
            BrokenPipeError
        ):  # without the process there is no answer, which is an error with its last output
            print(json.dumps(request), file=self._process.stdin, flush=True)
        return self._answer(Timed)

    def close(self) -> None:
        """End the process; a second call does nothing."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.communicate()
        self._folder.cleanup()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _answer(self, kind: type[_AnswerT]) -> _AnswerT:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            words = last(self._errors.read_text(encoding="utf-8", errors="replace"))
            raise NoKheperax(
                f"{self._python} ended with status {self._process.wait()}; its last output:\n{words}\n"
                "If the environment is incomplete, delete it; the next run makes a new one."
            )
        return answer_of(line, kind)
