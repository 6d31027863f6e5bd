"""The operator: the person, or the program, that places robots and food."""

import math
import sys
from collections.abc import Callable
from typing import NamedTuple

from khepera_forage.sim.arena import Point, Pose


class RobotMark(NamedTuple):
    """The place where a robot should stand: number in its world, name in the lab file, number of its marker, pose."""

    number: int
    name: str
    holes: int
    pose: Pose


class OperatorRequest(NamedTuple):
    """A task for the operator.

    Attributes:
        reason: The occasion, in a few words.
        robots: Robots to place; all others stay where they are.
        foods: Positions of all food; None leaves the food where it is.
        errors: Errors that the camera found after the last request.
    """

    reason: str
    robots: tuple[RobotMark, ...]
    foods: tuple[Point, ...] | None
    errors: tuple[str, ...] = ()


class OperatorGaveUp(ConnectionAbortedError):  # noqa: N818 (an event, not a mistake)
    """The operator declines to continue."""


Operator = Callable[[OperatorRequest], None]
"""Places robots and food, then returns, or raises `OperatorGaveUp`; the laboratory checks the result by camera."""


def ask_person(request: OperatorRequest) -> None:
    """The operator at the command line: show a request on standard error, in mm and degrees, and wait for Enter."""
    lines = [f"{request.reason}:"]
    if request.errors:
        lines += ["  not yet right:", *(f"    {error}" for error in request.errors)]
    for mark in request.robots:
        degrees = round(math.degrees(mark.pose.heading)) % 360
        lines.append(
            f"  robot {mark.name} (marker {mark.holes}) at x {mark.pose.x:.0f} mm, y {mark.pose.y:.0f} mm, "
            f"heading {degrees} degrees"
        )
    if request.foods is not None:
        lines += [f"  food at x {food.x:.0f} mm, y {food.y:.0f} mm" for food in request.foods] or ["  no food"]
    print("\n".join(lines), file=sys.stderr)
    try:
        answer = input("Press Enter when it is done, or q to give up: ")
    except (EOFError, RuntimeError):  # no input, or none any more
        raise OperatorGaveUp("the command line has no input") from None
    if answer.strip().lower() in ("q", "quit"):
        raise OperatorGaveUp("the operator gave up")
