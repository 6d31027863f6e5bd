"""Makes the rules of the task known to numba: compiled worlds execute the functions that Python calls."""

import khepera_forage.sim.compiled.rules  # noqa: F401 (registers those of the bodies)
from khepera_forage.compilation import register, rule
from khepera_forage.geometry import paths
from khepera_forage.robots import footprint, khepera
from khepera_forage.task import (
    arena_map,
    behaviours,
    episode,
    food_tracking,
    pairing,
    perception,
    placement,
    states,
    way_finding,
)

rule(khepera.applicable)
register(paths, footprint)
register(arena_map, behaviours, episode, food_tracking, pairing)
register(perception, placement, states, way_finding)
