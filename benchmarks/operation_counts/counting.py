"""Counts the operations of one world's step, in a process of its own that runs the kernels in plain Python.

Run as a module (see `count_apart`), it prints JSON: the steps, and the operations of each part of a round by kind.
"""

import functools
import json
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from khepera_forage import counter_rng
from khepera_forage.compilation import counter_rng as compiled_rng
from khepera_forage.compilation.addresses import call_at
from khepera_forage.envs.compiled import commands, perception, prepared_arenas, rules, worlds
from khepera_forage.envs.compiled.batch import as_records
from khepera_forage.geometry import angles
from khepera_forage.policies.nearest_neighbour.memories import NO_MEMORIES
from khepera_forage.rollouts.compiled import rollout_kernel
from khepera_forage.rollouts.compiled.policy_kernel import TEACHER
from khepera_forage.rollouts.compiled.records import decision_dtype, outcome_dtype
from khepera_forage.sim.compiled import broad_phase, camera, contact, drive, sensing, stepping, tracking
from khepera_forage.sim.compiled.bodies import Bodies
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from operation_counts.counters import ACCOUNT, CountingMath, CountingNumpy, Records

PARTS: dict[str, tuple[Callable[..., Any], ...]] = {
    "driving, and what is near": (
        *(drive.begin_round, drive.predict, drive.move_freely, sensing.end_round),
        *(broad_phase.find_near, broad_phase.find_wall_contacts, broad_phase.find_food_contacts),
    ),
    "infra-reds and their noise": (sensing.cast, sensing.measure),
    "raw data, state vector, state": (perception.perceive_block,),
    "food tracking": (perception.track_food,),
    "contact": (contact.move_in_contact,),
    "camera": (camera.expose,),
    "tracks": (tracking.track,),
    "behaviour to motors": (commands.drive_behaviours,),
}
"""The kernels of each part of a round."""


def _advance(address: int, bodies: Bodies, parameters: Parameters) -> None:
    """The function at the only address that kernels call."""
    stepping.advance_block(bodies, parameters)


STAND_INS: dict[Callable[..., Any], Callable[..., Any]] = {
    angles.bearing_of: rules.bearing_of,
    angles.turn_to: rules.turn_to,
    angles.length: rules.length,
    angles.sine: rules.sine,
    angles.arcsine: rules.arcsine,
    angles.cosine_sine: rules.cosine_and_sine,
    counter_rng.random_bits: compiled_rng.random_bits,
    counter_rng.unit: compiled_rng.unit,
    call_at: _advance,
}
"""Functions that have a compiled version of their own, or only that."""


def in_part(part: str, kernel: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel whose operations count for a part."""

    @functools.wraps(kernel)
    def run(*arguments: Any) -> Any:
        before, ACCOUNT.part = ACCOUNT.part, part
        result = kernel(*arguments)
        ACCOUNT.part = before
        return result

    return run


def replace_functions() -> None:
    """Let the kernels, as plain Python, work on numbers that count.

    Kernels refer to one another, `math` and `numpy` by names in their modules. In every module of the package, these
    names get substitutes; compiled functions are replaced by the Python functions that they were made from.
    """
    substitutes: dict[int, Any] = {id(math): CountingMath(), id(np): CountingNumpy()}
    substitutes |= {id(function): substitute for function, substitute in STAND_INS.items()}
    substitutes |= {
        id(kernel): in_part(part, kernel) for part, kernels in PARTS.items() for kernel in kernels
    }
    for name, module in list(sys.modules.items()):
        if name.startswith("khepera_forage."):
            for known, value in list(vars(module).items()):
                python = getattr(value, "py_func", value)
                substitute = substitutes.get(id(value), python)
                if substitute is not value:
                    setattr(module, known, substitute)


class Counts(NamedTuple):
    """Numbers of operations by part of a round and kind, in some steps."""

    steps: int
    by_part: dict[tuple[str, str], int]


def count_apart(episodes: int, seed: int) -> Counts:
    """Count episodes of the teacher in the corridor in a process of their own.

    Args:
        episodes: How many.
        seed: Of their worlds.
    """
    finished = subprocess.run(
        [sys.executable, "-m", __name__, str(episodes), str(seed)],
        cwd=Path(__file__).parents[1],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    steps, counts = json.loads(finished.stdout)
    return Counts(steps, {(part, kind): number for part, kind, number in counts})


def count(episodes: int, seed: int) -> Counts:
    """Count episodes in this process, whose kernels are of no other use afterwards."""
    prepared = prepared_arenas.recall_arenas("corridor", 1, 500, None, None, DEFAULT_DECISIONS)
    bodies, task = prepared.parameters, prepared.task
    keys = counter_rng.keys_of(np.arange(seed, seed + episodes, dtype=np.uint64))
    policies, taken = np.full(episodes, TEACHER), np.zeros(1, np.int64)
    plan = rollout_kernel.Plan(keys, policies, (), taken, *map(_shared, as_records(None, None, 1)))
    recalls = np.zeros(episodes, outcome_dtype)
    collected, free = np.zeros((episodes, 1), np.bool_), np.ones(1, np.bool_)
    outcomes = rollout_kernel.Outcomes(_shared(recalls), _shared(np.zeros((episodes, 1, 2))), collected, free)
    empty = worlds.empty_worlds(1, 1, 0, lanes=1)
    replace_functions()
    block = worlds.worlds_of(empty, 0, 0)
    counting = worlds.Worlds(Bodies(*map(Records, block.bodies)), *map(Records, block[1:]))
    decisions = Records(np.zeros(1, decision_dtype))
    with np.errstate(over="ignore"):  # random bits overflow on purpose
        rollout_kernel._run(
            counting,
            type(bodies)(*map(_shared, bodies)),
            type(task)(*map(_shared, task)),
            NO_MEMORIES,
            plan,
            decisions,
            outcomes,
            advance=0,
        )
    return Counts(int(recalls["steps"].sum()), dict(ACCOUNT.counts))


def _shared(value: Any) -> Any:
    """Records that all worlds share; a number stays a number."""
    return Records(value, counts=False) if isinstance(value, np.ndarray) else value


if __name__ == "__main__":
    steps, by_part = count(int(sys.argv[1]), int(sys.argv[2]))
    print(json.dumps([steps, [[*where, number] for where, number in by_part.items()]]))
