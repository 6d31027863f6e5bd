"""The check by camera that robots and food are in their places."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from khepera_forage.lab.localisation import gripper_errors, placement_errors
from khepera_forage.lab.operator import RobotMark
from khepera_forage.lab.settings_file import Tolerance
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Senses
from khepera_forage.sim.arena import Point
from khepera_forage.sim.sensing import OverheadCamera
from khepera_forage.vision.scene import Scene, Truth
from tests.lab.laboratories import ARENAS, LAYOUT


def scene_of(markers: tuple[tuple[float, float, float, int], ...], foods: tuple[tuple[float, float], ...]) -> Scene:
    camera = OverheadCamera(lambda: Truth(markers, foods), Noise.none())
    camera.reset(np.random.default_rng(0))
    return camera.look()


MARKS = tuple(
    RobotMark(i, name, i + 1, arena.start) for i, (name, arena) in enumerate(zip(("Ann", "Bob"), ARENAS, strict=True))
)
ANN, BOB = (*ARENAS[0].start, 1), (*ARENAS[1].start, 2)
FOOD = tuple(tuple(food) for food in LAYOUT.foods)


@pytest.mark.parametrize(
    ("markers", "foods", "errors"),
    [
        (((100, 110, 0.1, 1), BOB), FOOD, []),
        (((110, 115, 0, 1), BOB), FOOD, ["robot Ann stands at (110, 115) mm, 20 mm off its mark"]),
        (((90, 115, -0.3, 1), BOB), FOOD, ["robot Ann is turned 17 degrees too far to the right"]),
        (
            ((90, 415, 0, 1), (90, 115, 0, 2)),
            FOOD,
            [
                "marker 2 is in the arena of robot Ann, whose marker is 1",
                "robot Ann: marker 1 is not seen in its arena",
                "marker 1 is in the arena of robot Bob, whose marker is 2",
                "robot Bob: marker 2 is not seen in its arena",
            ],
        ),
        ((ANN, (250, 115, 0, 1), BOB), FOOD, ["robot Ann: marker 1 is seen 2 times in its arena"]),
        ((ANN, BOB), (*FOOD, (1500, 1500)), []),
        (
            (ANN, BOB),
            (FOOD[0], (340, 415)),
            ["no food is seen at (370, 415) mm", "food at (340, 415) mm is misplaced, or must be removed"],
        ),
    ],
)  # fmt: skip
def test_placement_errors_describe_all_deviations(
    markers: tuple[tuple[float, float, float, int], ...], foods: tuple[tuple[float, float], ...], errors: list[str]
) -> None:
    assert list(placement_errors(scene_of(markers, foods), ARENAS, MARKS, LAYOUT.foods, Tolerance())) == errors


def test_food_under_a_marker_counts_as_placed() -> None:
    under = Point(ANN[0] + 40, ANN[1])
    assert placement_errors(scene_of((ANN, BOB), ()), ARENAS, MARKS, (under,), Tolerance()) == ()


def body(arm: int = 215, jaw: int = 200, has_gripper: bool = True) -> Any:
    """A robot at rest."""
    senses = Senses((0, 0, 0, 0, 0, 0, 0, 0), 0, 0, arm, jaw, 0)
    return SimpleNamespace(has_gripper=has_gripper, sense=lambda: senses)


def test_gripper_errors_name_lowered_or_closed_grippers() -> None:
    assert gripper_errors(MARKS, (body(), body(arm=222, jaw=192))) == ()
    assert gripper_errors(MARKS, (body(), body(arm=255))) == (
        "robot Bob: arm at 255 and jaw at 200 instead of 215 and 200",
    )
    assert len(gripper_errors(MARKS, (body(jaw=0), body(jaw=126)))) == 2
    assert gripper_errors(MARKS, (body(arm=255, has_gripper=False),) * 2) == ()
