"""Records over lanes begin at cache lines, in every block."""

from typing import Any

import numpy as np
import pytest

from khepera_forage.compilation.aligned import aligned_zeros
from khepera_forage.envs.compiled.worlds import empty_worlds
from khepera_forage.sim.compiled.near_walls import empty_lists
from khepera_forage.sim.compiled.records import LANES

_LINE = 64


@pytest.mark.parametrize("shape", [0, 5, (3, 2), (4, 0)])
@pytest.mark.parametrize("dtype", ["f8", "?", [("x", "f4"), ("y", "i2")]])
def test_aligned_zeros_are_zeros_at_a_cache_line(shape: Any, dtype: Any) -> None:
    for _ in range(20):
        array = aligned_zeros(shape, dtype)
        assert array.size == 0 or array.ctypes.data % _LINE == 0
        assert array.flags.c_contiguous
        assert array.flags.writeable
        expected = np.zeros(shape, dtype)
        assert (array.shape, array.dtype) == (expected.shape, expected.dtype)
        assert np.array_equal(array, expected)


def test_every_field_over_lanes_begins_at_a_cache_line_in_every_block() -> None:
    near = empty_lists(3, LANES, walls=5, corners=2)
    worlds = empty_worlds(3, foods=2, waypoints=4, near=near)
    fields = 0
    for array in (worlds.bodies.robots, worlds.bodies.foods, worlds.bodies.scratch, worlds.tasks, *near):
        assert array.ctypes.data % _LINE == 0
        assert all(stride % _LINE == 0 for stride in array.strides)
        for name in array.dtype.names:
            _, offset = array.dtype.fields[name][:2]
            assert offset % _LINE == 0, name
            fields += 1
    assert fields > 100
