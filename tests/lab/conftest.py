from collections.abc import Iterator

import numpy as np
import pytest

from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from tests.lab.laboratories import LAYOUT, quiet_laboratory


@pytest.fixture
def lab() -> Iterator[VirtualLaboratory]:
    """Two robots in their corridors, ready to advance."""
    with quiet_laboratory() as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        yield lab
