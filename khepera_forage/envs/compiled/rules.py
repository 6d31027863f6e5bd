"""Makes the rules of the task known to numba: compiled worlds execute the functions that Python calls."""

import inspect

from khepera_forage.compilation import rule
from khepera_forage.geometry import angles, paths, walls
from khepera_forage.robots import footprint, khepera
from khepera_forage.sim.compiled import random  # noqa: F401 (registers the random numbers)
from khepera_forage.task import (
    arena_map,
    behaviours,
    episode,
    food_links,
    food_tracking,
    identification,
    nearest_food,
    pairing,
    past_poison,
    perception,
    placement,
    states,
    steering,
    way_finding,
)

RULE_MODULES = (
    *(angles, paths, walls, footprint),
    *(arena_map, behaviours, episode, food_links, food_tracking, identification, nearest_food, pairing),
    *(past_poison, perception, placement, states, steering, way_finding),
)
"""Modules whose functions compiled worlds may call."""

rule(khepera.applicable)
for _module in RULE_MODULES:
    for _function in vars(_module).values():
        if inspect.isfunction(_function) and _function.__module__ == _module.__name__:
            rule(_function)
