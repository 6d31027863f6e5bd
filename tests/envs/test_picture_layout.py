"""Layout of the pictures: arenas and panels fit into the picture without overlap."""

import pytest

from khepera_forage.envs.rendering.picture import MAX_HEIGHT, MAX_WIDTH, arrange
from khepera_forage.sim.arena import Arena, copies
from tests.version_0_1 import CORRIDOR, RECTANGLE


@pytest.mark.parametrize("robots", [1, 2, 3, 4, 5, 8])
@pytest.mark.parametrize("arena", [CORRIDOR, RECTANGLE], ids=lambda arena: arena.name)
def test_arena_and_panels_do_not_overlap(arena: Arena, robots: int) -> None:
    layout = arrange(copies(arena, robots), robots)
    assert layout.size[0] % 2 == layout.size[1] % 2 == 0
    if robots <= 5:
        assert layout.size[0] <= MAX_WIDTH + 2
        assert layout.size[1] <= MAX_HEIGHT + 210  # five rectangles are in two rows
    boxes = [layout.arena, *layout.panels]
    assert len(boxes) == robots + 1
    for i, a in enumerate(boxes):
        assert a.left >= 0
        assert a.top >= 0
        assert a.left + a.width <= layout.size[0]
        assert a.top + a.height <= layout.size[1]
        for b in boxes[:i]:
            beside = a.left >= b.left + b.width or b.left >= a.left + a.width
            assert beside or a.top >= b.top + b.height or b.top >= a.top + a.height
    for shown in copies(arena, robots):
        for x, y in shown.walls:
            column, row = layout.pixel(x, y)
            assert 0 <= column - layout.arena.left < layout.arena.width
            assert 0 <= row - layout.arena.top < layout.arena.height
