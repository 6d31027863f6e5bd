"""The parameters of a compiled world in each arena that it has been in."""

from typing import Any

from khepera_forage.envs.compiled.parameters import TaskParameters, recall_parameters
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.parameters import Parameters

_MOST = 1_000
"""Arenas whose parameters are kept, each of some 20 kB."""


class KeptParameters:
    """Parameters, made when a world first enters an arena and kept for its next episodes there.

    Args:
        *options: Further arguments of `recall_parameters`, the same in all arenas.
    """

    def __init__(self, *options: Any) -> None:
        self._options = options
        self._kept: dict[Arena, tuple[Parameters, TaskParameters]] = {}

    def __getitem__(self, arena: Arena) -> tuple[Parameters, TaskParameters]:
        """Of the bodies and of the task.

        Raises:
            ValueError: An option out of range.
        """
        if arena not in self._kept:
            if len(self._kept) == _MOST:
                self._kept.clear()
            self._kept[arena] = recall_parameters(arena, *self._options)
        return self._kept[arena]
