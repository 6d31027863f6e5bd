"""The records of several arenas, joined for kernels."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.sim.compiled import records as bodies
from khepera_forage.sim.compiled.parameters import Parameters


class JoinedArenas:
    """The records of several arenas, one after the other in one array of each kind."""

    def __init__(self) -> None:
        self._first: tuple[Parameters, TaskParameters]
        self._arrays: dict[str, _Growing] = {}

    def __len__(self) -> int:
        return self._length("arenas")

    def add(self, parameters: Parameters, task: TaskParameters) -> None:
        """Append an arena.

        Args:
            parameters: Of the bodies, for this arena alone.
            task: Of the task, likewise.
        """
        if not self._arrays:
            self._first = parameters, task
        record, own = task.arena.copy(), np.zeros(1, bodies.arena_dtype)
        for name, array in (("wall", task.map_walls), ("corner", task.corners), ("waypoint", task.waypoints)):
            record[f"{name}s"] = len(array)
        for name, joined in (
            ("first_wall", "walls"),
            ("first_corner", "corners"),
            ("first_waypoint", "waypoints"),
            ("first_length", "way_lengths"),
        ):
            record[name] = self._length(joined)
        for name in ("first_wall", "walls", "first_corner", "corners"):
            own[name] = record[name]
        for name in ("anchor_x", "anchor_y"):
            own[name] = parameters.constants[name]
        for name, rows in (
            *(("arenas", own), ("walls", parameters.walls), ("corners", parameters.corners)),
            *(("arena", record), ("map_walls", task.map_walls), ("floor_walls", task.floor_walls)),
            *(("way_corners", task.corners), ("waypoints", task.waypoints)),
            ("way_lengths", task.way_lengths),
            *(("start_lengths", task.start_lengths), ("home_lengths", task.home_lengths)),
        ):
            self._arrays.setdefault(name, _Growing(rows.dtype)).append(rows)

    def __getitem__(self, index: int) -> tuple[Parameters, TaskParameters]:
        """The records of one arena, as they were added."""
        arrays = {name: growing.array for name, growing in self._arrays.items()}
        arena, own = arrays["arena"][index : index + 1].copy(), arrays["arenas"][index]
        walls, corners, waypoints = (
            slice(arena[f"first_{name}"][0], arena[f"first_{name}"][0] + arena[f"{name}s"][0])
            for name in ("wall", "corner", "waypoint")
        )
        first = arena["first_length"][0]
        parameters, task = self._first
        constants = parameters.constants.copy()
        for name in ("anchor_x", "anchor_y"):
            constants[name] = own[name]
        return (
            parameters._replace(
                walls=arrays["walls"][walls], corners=arrays["corners"][corners], constants=constants
            ),
            task._replace(
                arena=arena,
                **{name: arrays[name][walls] for name in ("map_walls", "floor_walls")},
                corners=arrays["way_corners"][corners],
                **{name: arrays[name][waypoints] for name in ("waypoints", "start_lengths", "home_lengths")},
                way_lengths=arrays["way_lengths"][first : first + arena["waypoints"][0] ** 2],
            ),
        )

    def joined(self) -> tuple[Parameters, TaskParameters]:
        """The records of all arenas."""
        arrays = {name: growing.array for name, growing in self._arrays.items()}
        parameters, task = self._first
        return (
            parameters._replace(walls=arrays["walls"], corners=arrays["corners"], arenas=arrays["arenas"]),
            task._replace(
                corners=arrays["way_corners"],
                **{
                    name: arrays[name]
                    for name in (
                        *("arena", "map_walls", "floor_walls"),
                        *("waypoints", "way_lengths", "start_lengths", "home_lengths"),
                    )
                },
            ),
        )

    def _length(self, name: str) -> int:
        return len(self._arrays[name].array) if name in self._arrays else 0


class _Growing:
    """An array that grows at its end; its memory doubles when it is full."""

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self._memory, self._count = np.zeros(64, dtype), 0

    @property
    def array(self) -> NDArray[Any]:
        return self._memory[: self._count]

    def append(self, rows: NDArray[Any]) -> None:
        end = self._count + len(rows)
        if end > len(self._memory):
            memory = np.zeros(2 * end, self._memory.dtype)
            memory[: self._count] = self.array
            self._memory = memory
        self._memory[self._count : end] = rows
        self._count = end
