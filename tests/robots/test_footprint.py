"""Where body and gripper stand free of walls, and how wide the gripper opens."""

import math

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import affinity

from khepera_forage.geometry.plane import walls_of
from khepera_forage.robots.footprint import GRIPPER_HALF_WIDTH, body_is_free, gripper_is_free
from khepera_forage.robots.khepera import FINGER_TIP, JAW_CLOSED, JAW_ON_FOOD, JAW_OPEN, JAW_ROOT, RADIUS, half_gap
from tests.geometry.shapes import PROPERTY, Enclosure, Place, enclosures, places

ROOM = walls_of((((0.0, 0.0), (1000.0, 0.0), (1000.0, 1000.0), (0.0, 1000.0)),))
HEADINGS = st.floats(-math.pi, math.pi)


@pytest.mark.parametrize("margin", [0.0, 5.0])
def test_body_just_fits_at_its_radius_from_a_wall(margin: float) -> None:
    assert body_is_free(RADIUS + margin, 500.0, margin, ROOM)
    assert not body_is_free(RADIUS + margin - 0.01, 500.0, margin, ROOM)


@pytest.mark.parametrize("margin", [0.0, 5.0])
@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -math.pi / 2])
@pytest.mark.parametrize("side", [0.0, math.pi / 2, -math.pi / 2])
def test_gripper_just_fits_with_its_tips_before_or_its_sides_beside_a_wall(
    side: float, heading: float, margin: float
) -> None:
    # The gripper counts as wider by the margin, and keeps the margin on top.
    reach = GRIPPER_HALF_WIDTH + 2.0 * margin if side else FINGER_TIP + margin
    for further, free in ((-0.01, True), (0.01, False)):
        way = 500.0 - reach + further
        x, y = 500.0 + way * math.cos(heading + side), 500.0 + way * math.sin(heading + side)
        assert gripper_is_free(x, y, heading, margin, ROOM) is free


def test_jaw_on_food_leaves_a_gap_as_wide_as_food() -> None:
    assert [half_gap(jaw) for jaw in (JAW_CLOSED, JAW_ON_FOOD, JAW_OPEN)] == pytest.approx([0.5, 17.5, 27.5])


@given(enclosures, places, HEADINGS)
@PROPERTY
def test_free_gripper_touches_no_wall(enclosure: Enclosure, place: Place, heading: float) -> None:
    if gripper_is_free(*place, heading, 0.0, walls_of(enclosure.polygons)):
        shrunken = shapely.box(JAW_ROOT, -GRIPPER_HALF_WIDTH, FINGER_TIP, GRIPPER_HALF_WIDTH).buffer(-1e-6)
        turned = affinity.rotate(shrunken, heading, origin=(0, 0), use_radians=True)
        gripper = affinity.translate(turned, *place)
        assert not any(gripper.intersects(shapely.LinearRing(polygon)) for polygon in enclosure.polygons)
