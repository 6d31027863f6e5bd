import math
from collections.abc import Iterator

import numpy as np
import pytest

from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.serial import serial_robot
from khepera_forage.robots.toio import driver
from tests.lab.laboratories import LAYOUT, quiet_laboratory


@pytest.fixture(autouse=True)
def fast_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine can make a line look slow; commands would then be confirmed after the round that they are for.

    Or it can make a cube look silent.
    """
    monkeypatch.setattr(serial_robot, "FAST", math.inf)
    monkeypatch.setattr(driver, "_MAX_SILENCE", 5.0)


@pytest.fixture
def lab() -> Iterator[VirtualLaboratory]:
    """Two robots in their corridors, ready to advance."""
    with quiet_laboratory() as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        yield lab
