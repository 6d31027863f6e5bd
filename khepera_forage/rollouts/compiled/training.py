"""Compiled paired corridors: the training phase of the thesis (4.5, 5.2, 5.3) for thousands of learners at once.

A pair is a teacher's world and a learner's, the copy of the arena at its offset under the same camera, with its own
walls, home and marker. Marker and food of one are never hidden by, or under the cable of, the robot of the other: the
gap between the arenas is wider than a marker reaches, and the cables hang from its middle. So the two share nothing
but what the learner hears, where the teacher is, and the types of corresponding food.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from khepera_forage.compilation.threads import share_out, threads_for
from khepera_forage.counter_rng import keys_of, random_bits
from khepera_forage.envs.arguments import (
    FoodOdds,
    checked_arena,
    checked_decisions,
    food_odds,
    timing_of,
    whole_number,
)
from khepera_forage.envs.compiled.batch import as_records
from khepera_forage.envs.compiled.parameters import task_parameters
from khepera_forage.envs.compiled.worlds import empty_worlds
from khepera_forage.envs.layouts import arenas_with_marks, no_room_on_marks
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.rollouts.compiled.records import VECTOR_COLUMNS, attempt_dtype, pair_dtype
from khepera_forage.rollouts.compiled.training_kernel import Records, train_all
from khepera_forage.rollouts.compiled.training_results import Trained, trained
from khepera_forage.rollouts.compiled.training_rounds import Side, Terms
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arena import MOST_FOODS, Arena, copies
from khepera_forage.sim.compiled.parameters import parameters_of
from khepera_forage.sim.compiled.records import LANES
from khepera_forage.sim.compiled.stepping import advance_address
from khepera_forage.sim.layout_checks import cable_anchor, check_layout, check_seen
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions

_ROOM = 1 << 28
"""Bytes of records that are kept open at a time, at most."""


def train_learners(
    n: int,
    arena: Arena | str = "corridor",
    seed: int = 0,
    *,
    noise: Noise | str | None = None,
    food_types: FoodOdds = None,
    max_cycles: int = 600,
    patience: int | None = None,
    episodes: int = 1,
    attempts: int | None = None,
    options: Mapping[str, Any] | None = None,
    decisions: Decisions | None = None,
) -> Trained:
    """Train learners side by side, each in paired arenas of its own with a teacher of its own.

    Each episode is demonstrated "as if it was the first time" until it is complete (5.2): robots and food on their
    marks as well as an operator can put them there, the teacher shouting and waiting, the learner recording its own
    state vector with each behaviour it hears, executing it, and following. What incomplete attempts recorded is
    forgotten. One learner hears one teacher; for several learners of the same teacher take `paired_corridors_v1`.

    Args:
        n: How many learners.
        arena: As for the environments; its copy must fit beside it under the camera.
        seed: Episode k of learner i of a seed is the same whatever else is asked for.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type; corresponding food is of one type.
        max_cycles: Rounds after which an attempt is out of time.
        patience: Rounds of separation after which one is given up.
        episodes: Complete training episodes of each learner.
        attempts: Incomplete ones of an episode after which it is hopeless.
        options: `start` (x mm, y mm, heading degrees) and `foods`, one (x mm, y mm) an object: other marks than those
            of figure 5.1, in the teacher's arena.
        decisions: Ours by default.

    Raises:
        ValueError: An argument out of range, or marks with no room.
        IncompleteTrainingError: No attempt at a training episode was complete.
    """
    n, episodes = whole_number("n", n, 1), whole_number("episodes", episodes, 1)
    decisions = checked_decisions(decisions)
    noise = checked_noise(noise)
    terms = Terms(
        whole_number("max_cycles", max_cycles, 1),
        decisions.patience if patience is None else whole_number("patience", patience, 1),
        decisions.most_attempts if attempts is None else whole_number("attempts", attempts, 1),
        float(noise.placement_error),
        float(np.radians(noise.placement_heading_error)),
    )
    arenas = arenas_with_marks(copies(checked_arena(arena, decisions), 2), options or {})
    _check(arenas)
    odds = food_odds(food_types)
    learner_keys = keys_of(np.uint64(whole_number("seed", seed, 0)) + np.arange(n, dtype=np.uint64))
    keys = random_bits(learner_keys[:, None], np.arange(1, episodes + 1, dtype=np.uint64)).ravel()
    room = terms.limit * VECTOR_COLUMNS * 2 + terms.attempts * attempt_dtype.itemsize
    at_once = min(keys.size, max(LANES, _ROOM // room))
    records = Records(
        np.empty((at_once, terms.limit, VECTOR_COLUMNS), np.int16),
        np.empty((at_once, terms.attempts), attempt_dtype),
        np.empty(at_once, np.int64),
        np.ones(at_once, np.bool_),
    )
    vectors, lines, tried = [], [], []
    for first in range(0, keys.size, at_once):
        some = keys[first : first + at_once]
        threads, taken = threads_for(-(-some.size // LANES)), np.zeros(1, np.int64)
        sides = [_side(arenas, k, threads, noise, odds, terms, decisions) for k in (0, 1)]
        pairs = np.zeros((threads, LANES), pair_dtype)
        common = (*sides, pairs, terms, some, taken, records)
        share_out(train_all, threads, *common, advance_address(LANES, train_all, 0, *common, 0))
        if not records.free[: some.size].all():
            raise no_room_on_marks(arenas[0], noise)
        made = records.tried[: some.size].copy()
        done = records.attempts[: some.size][np.arange(terms.attempts) < made[:, None]]
        last = done[np.cumsum(made) - 1]
        if not last["complete"].all():
            raise IncompleteTrainingError(
                f"none of {terms.attempts} attempts at a training episode was complete"
            )
        kept = np.arange(terms.limit) < last["vectors"][:, None]
        vectors.append(records.vectors[: some.size][kept])
        lines.append(done)
        tried.append(made)
    return trained(
        np.concatenate(vectors),
        np.concatenate(lines),
        np.concatenate(tried),
        n,
        terms.limit,
        arenas[0].name,
        seed,
        decisions,
    )


def _check(arenas: Any) -> None:
    """Complain about arenas that are out of sight, or marks that nothing can stand on."""
    foods = len(arenas[0].foods)
    if foods > MOST_FOODS:
        raise ValueError(
            f"{arenas[0].name}: {foods} food objects; allowed: 1 to {MOST_FOODS} in compiled worlds"
        )
    check_seen(arenas)
    layout = Layout(tuple(a.start for a in arenas), tuple(food for a in arenas for food in a.foods))
    check_layout(arenas, layout)


def _side(
    arenas: Sequence[Arena],
    number: int,
    blocks: int,
    noise: Noise,
    odds: tuple[float, ...],
    terms: Terms,
    decisions: Decisions,
) -> Side:
    """One side of the pairs: one camera over both arenas, the teacher with the marker of one hole."""
    arena, foods = arenas[number], len(arenas[0].foods)
    parameters = parameters_of(
        arena, foods, noise, holes=number + 1, timing=timing_of(decisions), anchor=cable_anchor(arenas)
    )
    task = task_parameters(arena, terms.limit, odds, decisions)
    return Side(
        empty_worlds(blocks, foods, len(task.waypoints)),
        parameters,
        task,
        *as_records(arena.start, arena.foods, foods),
    )
