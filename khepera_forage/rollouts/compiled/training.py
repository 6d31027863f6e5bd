"""The paired corridors in batch: the training phase of the thesis (4.5, 5.2, 5.3) for thousands of learners at once.

A pair is a teacher's world and a learner's, the copy of the arena at its offset under the same camera, with its own
walls, home and marker. Marker and food of one are never hidden by, or under the cable of, the robot of the other: the
gap between the arenas is wider than a marker reaches, and the cables hang from its middle. So the two share nothing
but what the learner hears, where the teacher is, and the types of corresponding food.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.threads import share_out, threads_for
from khepera_forage.envs.arguments import FoodOdds, food_odds, the_arena, whole_number
from khepera_forage.envs.compiled.parameters import Rules, arena_array, site_array, site_walls
from khepera_forage.envs.compiled.worlds import Worlds, empty_worlds
from khepera_forage.envs.training import PATIENCE
from khepera_forage.envs.training_episode import MAX_ATTEMPTS
from khepera_forage.noise import Noise
from khepera_forage.rollouts.compiled import pair_rows as pair
from khepera_forage.rollouts.compiled.training_kernel import Records, Terms, train_all
from khepera_forage.rollouts.compiled.training_placement import Marks
from khepera_forage.rollouts.compiled.training_results import Trained, put_together
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.bodies import Bodies
from khepera_forage.sim.compiled.numbers import keys_of, word
from khepera_forage.sim.compiled.parameters import Setting, edges_of, noise_of, walls_of
from khepera_forage.sim.compiled.rows import LANES, MOST_FOODS
from khepera_forage.sim.layout_checks import cable_anchor, check_layout, check_seen
from khepera_forage.sim.world import Layout
from khepera_forage.task.placement import marked

_ROOM = 1 << 28
"""Bytes of records that are kept open at a time, at most."""


def train_learners(
    n: int,
    arena: Arena | str = "corridor",
    seed: int = 0,
    *,
    noise: Noise | None = None,
    food_types: FoodOdds = None,
    max_cycles: int = 600,
    patience: int = PATIENCE,
    episodes: int = 1,
    attempts: int = MAX_ATTEMPTS,
    options: Mapping[str, Any] | None = None,
) -> Trained:
    """Train learners side by side, each in paired arenas of its own with a teacher of its own.

    Each episode is demonstrated "as if it was the first time" until it is complete (5.2): robots and food on their
    marks as well as an operator can put them there, the teacher shouting and waiting, the learner recording its own
    state vector with each behaviour it hears, executing it, and following. What incomplete attempts recorded is
    forgotten. One learner hears one teacher; for several learners of the same teacher take `paired_corridors_v0`.

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

    Raises:
        ValueError: An argument out of range, or marks with no room.
        RuntimeError: No attempt at a training episode was complete.
    """
    n, episodes = whole_number("n", n, 1), whole_number("episodes", episodes, 1)
    terms = Terms(whole_number("patience", patience, 1), whole_number("attempts", attempts, 1))
    limit = whole_number("max_cycles", max_cycles, 1)
    noise = Noise.laboratory() if noise is None else noise
    arenas = marked(copies(the_arena(arena), pair.SIDES), options or {})
    _check(arenas)
    setting, rules = _setting_of(arenas, noise), _rules_of(arenas, food_types, limit)
    marks = _marks_of(arenas, noise)
    with np.errstate(over="ignore"):
        learners = keys_of(whole_number("seed", seed, 0), np.arange(n))
        keys = word(learners[:, None], np.arange(1, episodes + 1, dtype=np.uint64)).ravel()  # type: ignore[arg-type]
    room = limit * pair.VECTOR_COLUMNS * 2 + terms.attempts * pair.ACCOUNT_COLUMNS * 4
    at_once = min(keys.size, max(LANES, _ROOM // room))
    records = Records(
        np.empty((at_once, limit, pair.VECTOR_COLUMNS), np.int16),
        np.empty((at_once, terms.attempts, pair.ACCOUNT_COLUMNS), np.int32),
        np.empty(at_once, np.int64),
        np.ones(at_once, np.bool_),
    )
    vectors, accounts, tried = [], [], []
    for first in range(0, keys.size, at_once):
        some = keys[first : first + at_once]
        threads, begun = threads_for(-(-some.size // LANES)), np.zeros(1, np.int64)
        worlds, company = _empty_pairs(threads, setting.foods)
        share_out(train_all, threads, worlds, company, setting, rules, marks, terms, some, begun, records)
        if not records.free[: some.size].all():
            raise ValueError(
                f"{arenas[0].name}: start or food too near a wall for a placement error of "
                f"{noise.placement_error:g} mm"
            )
        made = records.tried[: some.size].copy()
        lines = records.accounts[: some.size][np.arange(terms.attempts) < made[:, None]]
        last = lines[np.cumsum(made) - 1]
        if not last[:, pair.ACCOUNT_COMPLETE].all():
            raise RuntimeError(f"none of {terms.attempts} attempts at a training episode was complete")
        kept = np.arange(limit) < last[:, pair.ACCOUNT_VECTORS, None]
        vectors.append(records.vectors[: some.size][kept])
        accounts.append(lines)
        tried.append(made)
    return put_together(
        np.concatenate(vectors),
        np.concatenate(accounts),
        np.concatenate(tried),
        n,
        limit,
        arenas[0].name,
        seed,
    )


def _check(arenas: Any) -> None:
    """Complain about arenas that are out of sight, or marks that nothing can stand on."""
    foods = len(arenas[0].foods)
    if foods > MOST_FOODS:
        raise ValueError(f"{arenas[0].name}: {foods} food objects; allowed: 1 to {MOST_FOODS} in a batch")
    check_seen(arenas)
    layout = Layout(tuple(a.start for a in arenas), tuple(food for a in arenas for food in a.foods))
    check_layout(arenas, layout)


def _setting_of(arenas: Any, noise: Noise) -> Setting:
    """Those of both sides, stacked: one camera over both, the teacher with the marker of one hole."""
    anchor = cable_anchor(arenas)
    return Setting(
        len(arenas[0].foods),
        np.stack([walls_of(a) for a in arenas]),
        np.stack([edges_of(a) for a in arenas]),
        np.stack([noise_of(noise, anchor, holes) for holes in (1, 2)]),
    )


def _rules_of(arenas: Any, food_types: FoodOdds, limit: int) -> Rules:
    """Those of both sides, stacked."""
    return Rules(
        np.stack([site_array(a) for a in arenas]),
        np.stack([site_walls(a) for a in arenas]),
        np.stack([arena_array(a) for a in arenas]),
        np.array(food_odds(food_types)),
        limit,
    )


def _marks_of(arenas: Any, noise: Noise) -> Marks:
    return Marks(
        np.array([a.start for a in arenas]),
        np.array([a.foods for a in arenas]),
        float(noise.placement_error),
        float(np.radians(noise.placement_heading_error)),
    )


def _empty_pairs(blocks: int, foods: int) -> tuple[Worlds, NDArray[np.float64]]:
    """Room for some blocks of pairs, both sides of one beside each other, and for their company."""
    worlds = empty_worlds(pair.SIDES * blocks, foods)

    def paired(rows: NDArray[Any]) -> NDArray[Any]:
        return rows.reshape(blocks, pair.SIDES, -1)

    robots, food, keys = map(paired, worlds.bodies[:3])
    bodies = Bodies(robots, food, keys, np.zeros((blocks, 1, body.WORK_ROWS * LANES)))
    return Worlds(bodies, paired(worlds.tasks), paired(worlds.registers)), np.zeros(
        (blocks, pair.COMPANY_ROWS * LANES)
    )
