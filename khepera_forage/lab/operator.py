"""The operator: a person, or what stands for one, who puts robots and food where they should stand."""

import math
import sys
from collections.abc import Callable
from typing import NamedTuple, Protocol, TextIO

from khepera_forage.sim.arena import Point, Pose


class RobotMark(NamedTuple):
    """Where a robot should stand.

    Attributes:
        number: Of the robot in its world.
        name: Of the robot, as the lab file has it.
        holes: Of the marker on its back.
        pose: In mm and radians of the world's frame.
    """

    number: int
    name: str
    holes: int
    pose: Pose


class Request(NamedTuple):
    """What the operator is asked to do.

    Attributes:
        reason: Why, in a few words.
        robots: Where robots should stand; those that are not named stay where they are.
        foods: Where all food should lie; None leaves it as it is.
        wrong: What the camera found wrong after the last asking; empty the first time.
    """

    reason: str
    robots: tuple[RobotMark, ...]
    foods: tuple[Point, ...] | None
    wrong: tuple[str, ...] = ()


class OperatorGaveUp(ConnectionAbortedError):  # noqa: N818 (what happened, in the words of whoever catches it)
    """The operator would rather not go on."""


class Operator(Protocol):
    """Whoever is asked."""

    def __call__(self, request: Request, /) -> None:
        """Return once it is done as well as possible; the laboratory then checks it by camera.

        Raises:
            OperatorGaveUp: It will not be done.
        """
        ...


class Prompt:
    """Asks a person on the command line.

    Args:
        ask: Shows a text and returns the answer; raises `EOFError` when there is nobody to answer.
        out: Where the request is written.
    """

    def __init__(self, ask: Callable[[str], str] = input, out: TextIO | None = None) -> None:
        self._ask = ask
        self._out = out

    def __call__(self, request: Request) -> None:
        """Show where everything should stand, and wait for Enter.

        Raises:
            OperatorGaveUp: The answer is `q`, or there is nobody to answer.
        """
        print("\n".join(lines_of(request)), file=self._out or sys.stderr)
        try:
            answer = self._ask("Press Enter when it is done, or q to give up: ")
        except EOFError:
            raise OperatorGaveUp("nobody answers on the command line") from None
        if answer.strip().lower() in ("q", "quit"):
            raise OperatorGaveUp("the operator gave up")


def holes(count: int) -> str:
    """A number of holes in words."""
    return "1 hole" if count == 1 else f"{count} holes"


def lines_of(request: Request) -> list[str]:
    """A request in words, a line each, in mm and degrees."""
    lines = [f"{request.reason}:"]
    if request.wrong:
        lines += ["  not yet right:", *(f"    {fault}" for fault in request.wrong)]
    for mark in request.robots:
        degrees = round(math.degrees(mark.pose.heading)) % 360
        lines.append(
            f"  robot {mark.name} ({holes(mark.holes)}) at x {mark.pose.x:.0f} mm, y {mark.pose.y:.0f} mm, "
            f"heading {degrees} degrees"
        )
    if request.foods is not None:
        lines += [f"  food at x {food.x:.0f} mm, y {food.y:.0f} mm" for food in request.foods]
        if not request.foods:
            lines.append("  no food")
    return lines
