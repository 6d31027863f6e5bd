"""The operator at the command line: the text of requests, and giving up."""

import io
import math

import pytest

from khepera_forage.lab.operator import (
    CommandLineOperator,
    OperatorGaveUp,
    OperatorRequest,
    RobotMark,
    describe,
)
from khepera_forage.sim.arena import Point, Pose


def test_request_shows_all_places() -> None:
    out = io.StringIO()
    prompts: list[str] = []

    def ask(text: str) -> str:
        prompts.append(text)
        return ""

    mark = RobotMark(0, "teacher", 1, Pose(90.4, 115.0, -math.pi / 2))
    CommandLineOperator(ask, out)(OperatorRequest("start of an episode", (mark,), (Point(370.0, 115.2),)))
    assert out.getvalue().splitlines() == [
        "start of an episode:",
        "  robot teacher (1 hole) at x 90 mm, y 115 mm, heading 270 degrees",
        "  food at x 370 mm, y 115 mm",
    ]
    assert len(prompts) == 1
    assert "q to give up" in prompts[0]


def test_repeated_request_lists_the_errors() -> None:
    lines = describe(OperatorRequest("pause and resume", (), None, ("robot learner_0 stands 40 mm off",)))
    assert lines[1:] == ["  not yet right:", "    robot learner_0 stands 40 mm off"]
    assert "  no food" in describe(OperatorRequest("start", (), ()))


def test_operator_can_give_up() -> None:
    for ask in (lambda _: " Q ", _no_input):
        with pytest.raises(OperatorGaveUp, match=r"gave up|no input"):
            CommandLineOperator(ask, io.StringIO())(OperatorRequest("start", (), ()))


def _no_input(_: str) -> str:
    raise EOFError
