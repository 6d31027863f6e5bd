"""How a person is asked on the command line, and what the camera's survey tells of the answer."""

import io
import math

import numpy as np
import pytest

from khepera_forage.lab.operator import OperatorGaveUp, Prompt, Request, RobotMark, lines_of
from khepera_forage.lab.settings import Tolerance
from khepera_forage.lab.survey import closed_grippers, survey
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Senses
from khepera_forage.sim.arena import CORRIDOR, Point, Pose, copies
from khepera_forage.vision.scene import Scene
from khepera_forage.vision.simulated_camera import OverheadCamera, Truth

ARENAS = copies(CORRIDOR, 2)
FOODS = tuple(food for arena in ARENAS for food in arena.foods)


def test_the_prompt_shows_where_everything_should_stand() -> None:
    out = io.StringIO()
    asked: list[str] = []

    def ask(text: str) -> str:
        asked.append(text)
        return ""

    mark = RobotMark(0, "teacher", 1, Pose(90.4, 115.0, -math.pi / 2))
    Prompt(ask, out)(Request("start of an episode", (mark,), (Point(370.0, 115.2),)))
    assert out.getvalue().splitlines() == [
        "start of an episode:",
        "  robot teacher (1 hole) at x 90 mm, y 115 mm, heading 270 degrees",
        "  food at x 370 mm, y 115 mm",
    ]
    assert len(asked) == 1
    assert "q to give up" in asked[0]


def test_the_prompt_tells_what_is_wrong() -> None:
    lines = lines_of(Request("pause and resume", (), None, ("robot learner_0 stands 40 mm off",)))
    assert lines[1:] == ["  not yet right:", "    robot learner_0 stands 40 mm off"]
    assert "  no food" in lines_of(Request("start", (), ()))


def test_a_person_may_give_up() -> None:
    for ask in (lambda _: " Q ", _nobody):
        with pytest.raises(OperatorGaveUp, match=r"gave up|nobody"):
            Prompt(ask, io.StringIO())(Request("start", (), ()))


def _nobody(_: str) -> str:
    raise EOFError


def scene_of(
    markers: tuple[tuple[float, float, float, int], ...], foods: tuple[tuple[float, float], ...]
) -> Scene:
    camera = OverheadCamera(lambda: Truth(markers, foods), Noise.none())
    camera.reset(np.random.default_rng(0))
    return camera.look()


MARKS = tuple(
    RobotMark(i, name, i + 1, arena.start)
    for i, (name, arena) in enumerate(zip(("Ann", "Bob"), ARENAS, strict=True))
)
ANN, BOB = (*ARENAS[0].start, 1), (*ARENAS[1].start, 2)
FOOD = tuple(tuple(food) for food in FOODS)


@pytest.mark.parametrize(
    ("markers", "foods", "told"),
    [
        ((ANN, BOB), FOOD, []),
        (((100, 110, 0.1, 1), BOB), FOOD, []),
        (((110, 115, 0, 1), BOB), FOOD, ["robot Ann stands at (110, 115) mm, 20 mm off its mark"]),
        (((90, 115, 0.3, 1), BOB), FOOD, ["robot Ann is turned 17 degrees too far to the left"]),
        (((90, 115, -0.3, 1), BOB), FOOD, ["robot Ann is turned 17 degrees too far to the right"]),
        (((90, 115, math.pi, 1), BOB), FOOD, ["robot Ann is turned 180 degrees too far to the right"]),
        ((ANN,), FOOD, ["robot Bob: no marker with 2 holes is seen in its arena"]),
        (
            ((90, 415, 0, 1), (90, 115, 0, 2)),
            FOOD,
            [
                "a marker with 2 holes is in the arena of robot Ann, whose own has 1",
                "robot Ann: no marker with 1 hole is seen in its arena",
                "a marker with 1 hole is in the arena of robot Bob, whose own has 2",
                "robot Bob: no marker with 2 holes is seen in its arena",
            ],
        ),
        ((ANN, (250, 115, 0, 1), BOB), FOOD, ["robot Ann: 2 markers with 1 hole are seen in its arena"]),
        ((ANN, BOB), FOOD[:1], ["no food is seen at (370, 415) mm"]),
        ((ANN, BOB), (*FOOD, (300, 60)), ["food at (300, 60) mm belongs elsewhere, or away"]),
        ((ANN, BOB), (*FOOD, (1500, 1500)), []),
        (
            (ANN, BOB),
            (FOOD[0], (340, 415)),
            ["no food is seen at (370, 415) mm", "food at (340, 415) mm belongs elsewhere, or away"],
        ),
    ],
)  # fmt: skip
def test_the_survey_tells_what_is_off(
    markers: tuple[tuple[float, float, float, int], ...],
    foods: tuple[tuple[float, float], ...],
    told: list[str],
) -> None:
    assert list(survey(scene_of(markers, foods), ARENAS, MARKS, FOODS, Tolerance())) == told


def test_food_that_a_marker_covers_is_taken_to_be_there() -> None:
    under = Point(ANN[0] + 40, ANN[1])
    assert survey(scene_of((ANN, BOB), ()), ARENAS, MARKS, (under,), Tolerance()) == ()


def test_grippers_that_are_not_up_and_open() -> None:
    still = Senses((0, 0, 0, 0, 0, 0, 0, 0), 0, 0, 215, 200, 0)
    assert closed_grippers(MARKS, (still, still._replace(arm=222, jaw=192))) == ()
    assert closed_grippers(MARKS, (still, still._replace(arm=255))) == (
        "robot Bob: arm at 255 and jaw at 200 instead of 215 and 200",
    )
    assert len(closed_grippers(MARKS, (still._replace(jaw=0), still._replace(jaw=126)))) == 2
