"""The operator at the command line: the text of requests, and giving up."""

import io
import math

import pytest

from khepera_forage.lab.operator import OperatorGaveUp, OperatorRequest, RobotMark, ask_person
from khepera_forage.sim.arena import Point, Pose

MARK = RobotMark(0, "teacher", 1, Pose(90.4, 115.0, -math.pi / 2))


@pytest.mark.parametrize(
    ("request_", "lines"),
    [
        (
            OperatorRequest("start of an episode", (MARK,), (Point(370.0, 115.2),), ("robot Ann stands 40 mm off",)),
            [
                "start of an episode:",
                "  not yet right:",
                "    robot Ann stands 40 mm off",
                "  robot teacher (marker 1) at x 90 mm, y 115 mm, heading 270 degrees",
                "  food at x 370 mm, y 115 mm",
            ],
        ),
        (OperatorRequest("reconnect", (), None), ["reconnect:"]),
        (OperatorRequest("start", (), ()), ["start:", "  no food"]),
    ],
)
def test_request_shows_all_places_and_errors(
    request_: OperatorRequest, lines: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("\n"))
    ask_person(request_)
    shown = capsys.readouterr()
    assert shown.err.splitlines() == lines
    assert shown.out == "Press Enter when it is done, or q to give up: "


@pytest.mark.parametrize(("answer", "message"), [(" Q \n", "gave up"), ("", "no input")])
def test_operator_can_give_up(answer: str, message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(answer))
    with pytest.raises(OperatorGaveUp, match=message):
        ask_person(OperatorRequest("start", (), ()))
