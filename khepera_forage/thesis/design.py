"""The thesis's experiments as data: training files, recalls and arenas of each (5.4.1.1, 5.4.2.1)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.noise import SOURCES, Noise
from khepera_forage.sim.arenas.thesis import CORRIDOR, RECTANGLE
from khepera_forage.task.decisions import Decisions
from khepera_forage.vision.scene import MM_PER_PIXEL

FILES = 10
"""Complete training episodes, one experience file each (5.3)."""


def training_distance(decisions: Decisions) -> float:
    """Pixels between food and home in training, which is always in the corridor (figure 5.1)."""
    corridor = checked_arena(CORRIDOR, decisions)
    return math.dist(corridor.foods[0], corridor.home) / MM_PER_PIXEL


class Subset(NamedTuple):
    """Training files, 1..10, whose experience a learner uses together."""

    files: tuple[int, ...]

    @property
    def name(self) -> str:
        """As in the tables of appendix A: `g` and the numbers."""
        return "g" + "".join(str(file) for file in self.files)


@dataclass(frozen=True, slots=True)
class Cell:
    """One table of appendix A: an arena and an amount of training.

    Attributes:
        episodes: Training episodes of each learner.
        subsets: The training files of each learner.
        recalls: Recall episodes of each learner.
    """

    arena: str
    episodes: int
    subsets: tuple[Subset, ...]
    recalls: int
    foods: int
    limit: int

    @property
    def size(self) -> int:
        """Recall episodes in one experiment."""
        return len(self.subsets) * self.recalls

    @property
    def available(self) -> int:
        """Food objects in one experiment."""
        return self.size * self.foods


FOODS = {CORRIDOR: 1, RECTANGLE: 2}
"""Food objects in each arena (5.4.1.1, 5.4.2.1)."""
LIMITS = {CORRIDOR: 500, RECTANGLE: 700}
"""Most steps of a recall in each arena (5.4.1.1, 5.4.2.1)."""


def _cell(arena: str, recalls: int, *files: tuple[int, ...]) -> Cell:
    return Cell(arena, len(files[0]), tuple(map(Subset, files)), recalls, FOODS[arena], LIMITS[arena])


_ALL = tuple(range(1, FILES + 1))

THESIS = (
    _cell(CORRIDOR, 4, (1,), (3,), (6,), (7,), (8,)),
    _cell(CORRIDOR, 4, (1, 2, 3), (1, 3, 5), (1, 3, 4), (1, 5, 8), (3, 6, 9)),
    _cell(CORRIDOR, 4, _ALL[:5], _ALL[5:], (1, 3, 5, 7, 9), (2, 4, 6, 8, 10), (3, 4, 6, 8, 10)),
    _cell(CORRIDOR, 10, _ALL),
    _cell(RECTANGLE, 4, (1,), (7,), (8,)),
    _cell(RECTANGLE, 4, _ALL[:5], _ALL[5:], (2, 4, 6, 8, 10)),
    _cell(RECTANGLE, 12, _ALL),
)
"""Tables A.1 to A.7, in order. A replication is all of them, ten new training files included."""


def files_needed(cells: Sequence[Cell]) -> int:
    """Training files that the learners of some cells use; all ten without any cell."""
    return max((file for cell in cells for subset in cell.subsets for file in subset.files), default=FILES)


LABORATORY = "laboratory"
"""Name of the noise condition of the thesis: all sources of noise together."""
NO_LOSSES = "no losses"
"""Name of the laboratory's noise with a tracker that never loses a region (5.3.1)."""
NO_NOISE = "none"
"""Name of the condition without noise."""
LABORATORY_NOISE = Noise.laboratory()
"""The noise of the condition `LABORATORY`, unless another is given."""


def noise_conditions(laboratory: Noise = LABORATORY_NOISE) -> dict[str, Noise]:
    """Noise by name: none, each source of the laboratory's alone, all of them, and all without tracking losses.

    Cables only multiply the rate of tracking losses, so they are combined with that source. The names and their order
    do not depend on the laboratory.
    """
    conditions = {NO_NOISE: Noise.none()}
    for source in SOURCES:
        name, parts = f"only {source}", [source]
        if source == "cables":
            name, parts = "only tracking losses, with cables", ["tracking losses", source]
        conditions[name] = Noise.only(*parts, laboratory=laboratory)

    conditions[NO_LOSSES] = replace(laboratory, loss_rate_one_hole=0.0, loss_rate_two_holes=0.0, loss_rate_food=0.0)
    conditions[LABORATORY] = laboratory
    return conditions
