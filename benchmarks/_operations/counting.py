"""Counts the operations of one world's step, in a process of its own that has numba's compiler switched off.

Run as a module (`counted_apart`) it prints JSON: the steps, and how often each part of a round did what.
"""

import functools
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from _operations.counters import ACCOUNT, CountingMath, CountingNumpy, Rows
from khepera_forage.envs.compiled import compiled_rules as compiled_task
from khepera_forage.envs.compiled import food_tracking as register
from khepera_forage.envs.compiled import task
from khepera_forage.envs.compiled.parameters import rules_of
from khepera_forage.envs.compiled.worlds import Worlds, empty_worlds
from khepera_forage.geometry import angles
from khepera_forage.policies.nearest_neighbour.memories import NO_MEMORIES
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.compiled import rollout_kernel as playing
from khepera_forage.rollouts.compiled.policy_kernel import TEACHER, empty_decisions
from khepera_forage.sim.compiled import broad_phase as watching
from khepera_forage.sim.compiled import camera, contact, drive, numbers, sensing, tracks

PARTS: dict[str, tuple[Callable[..., Any], ...]] = {
    "driving, and what is near": (
        *(drive.begin_round, drive.aim, drive.glide, sensing.end_round),
        *(watching.look_around, watching.watch_walls, watching.watch_food),
    ),
    "infra-reds and their noise": (sensing.cast, sensing.measure),
    "raw data, state vector, state": (task.perceive,),
    "register": (register.update,),
    "contact": (contact.touch,),
    "camera": (camera.expose,),
    "tracks": (tracks.track,),
    "behaviour to motors": (task.drive,),
}
"""Which kernels are which part of a round."""


def in_part(part: str, kernel: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel that notes what it does under a part."""

    @functools.wraps(kernel)
    def run(*arguments: Any) -> Any:
        before, ACCOUNT.part = ACCOUNT.part, part
        result = kernel(*arguments)
        ACCOUNT.part = before
        return result

    return run


def let_everything_count() -> None:
    """Make the kernels, as plain Python, work on one world whose numbers count.

    This is all the patching there is. Kernels name one another, `LANES`, `math` and `numpy` in their modules; in every
    module of the package these names get what counts in their place. Functions that have a compiled version (see
    `compiled_task`) get that one.
    """
    substitutes: dict[int, Any] = {id(math): CountingMath()}
    substitutes |= {
        id(kernel): in_part(part, kernel) for part, kernels in PARTS.items() for kernel in kernels
    }
    substitutes |= {
        id(applicable): compiled_task.whole,
        id(angles.bearing_of): compiled_task.bearing_of,
        id(angles.turn_to): compiled_task.turn_to,
        id(angles.length): compiled_task.length,
        id(angles.sine): compiled_task.sine,
        id(angles.arcsine): compiled_task.arcsine,
    }
    for name, module in list(sys.modules.items()):
        if name.startswith("khepera_forage."):
            for known, value in list(vars(module).items()):
                if id(value) in substitutes:
                    setattr(module, known, substitutes[id(value)])
            if hasattr(module, "LANES"):
                setattr(module, "LANES", 1)  # noqa: B010 (a checker would have it that a module is no place for it)
    for module in (numbers, camera, playing):
        setattr(module, "np", CountingNumpy())  # noqa: B010


class Counts(NamedTuple):
    """How often each part of a round did each kind of operation, and in how many steps."""

    steps: int
    by_part: dict[tuple[str, str], int]


def counted_apart(episodes: int, seed: int) -> Counts:
    """Episodes of the teacher in the corridor, counted in a process of their own.

    Args:
        episodes: How many.
        seed: Of their worlds.
    """
    finished = subprocess.run(
        [sys.executable, "-m", __name__, str(episodes), str(seed)],
        cwd=Path(__file__).parents[1],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    steps, counts = json.loads(finished.stdout)
    return Counts(steps, {(part, kind): number for part, kind, number in counts})


def count(episodes: int, seed: int) -> Counts:
    """Play episodes in this process, which can compile nothing and is good for nothing else afterwards."""
    keys = numbers.keys_of(seed, np.arange(episodes))
    setting, rules = rules_of("corridor", 1, 500, None, None)
    outcomes = playing.empty_outcomes(episodes, 1)
    let_everything_count()
    bodies, tasks, registers = empty_worlds(1, 1)
    counted = type(bodies)(*(Rows(array) for array in bodies))  # type: ignore[arg-type]
    worlds = Worlds(counted, Rows(tasks), Rows(registers))  # type: ignore[arg-type]
    # What all worlds have in common stays in registers through a loop over worlds: its loads do not count.
    plan = playing.Plan(keys, np.full(episodes, TEACHER), np.zeros(1, np.int64))
    with np.errstate(over="ignore"):  # random bits are meant to run over
        playing.play_out(0, worlds, setting, rules, NO_MEMORIES, plan, empty_decisions(1), outcomes)
    return Counts(int(outcomes.sums[:, playing.STEPS].sum()), dict(ACCOUNT.counts))


if __name__ == "__main__":
    steps, by_part = count(int(sys.argv[1]), int(sys.argv[2]))
    print(json.dumps([steps, [[*where, number] for where, number in by_part.items()]]))
