"""A memory that grows vector by vector: one memory, in lists."""

from bisect import bisect_left
from collections.abc import Sequence

from khepera_forage.policies.nearest_neighbour.memories import FlatMemories, ListMemory, plane_key


def empty_memory() -> ListMemory:
    """A memory without vectors."""
    return FlatMemories(
        planes=[0, 0], keys=[], columns=[0], home=[], vectors=[0], food=[], label=[], times=[]
    )


def insert(memory: ListMemory, row: Sequence[int], label: int, times: int) -> None:
    """Add a state vector, heard `times` times, to a memory."""
    presence, home, food_type, arm, food = row
    key = plane_key(presence, food_type, arm)
    plane = bisect_left(memory.keys, key)
    if plane == len(memory.keys) or memory.keys[plane] != key:
        memory.keys.insert(plane, key)
        memory.columns.insert(plane, memory.columns[plane])
        memory.planes[1] += 1
    first, last = memory.columns[plane], memory.columns[plane + 1]
    column = bisect_left(memory.home, home, first, last)
    if column == last or memory.home[column] != home:
        memory.home.insert(column, home)
        memory.vectors.insert(column, memory.vectors[column])
        _shift(memory.columns, plane + 1)
    first, last = memory.vectors[column], memory.vectors[column + 1]
    vector = bisect_left(memory.food, food, first, last)
    while vector < last and memory.food[vector] == food:
        if memory.label[vector] == label:
            memory.times[vector] += times
            return
        vector += 1
    memory.food.insert(vector, food)
    memory.label.insert(vector, label)
    memory.times.insert(vector, times)
    _shift(memory.vectors, column + 1)


def _shift(starts: list[int], first: int) -> None:
    """Add 1 to each start from `first` on."""
    starts[first:] = [start + 1 for start in starts[first:]]
