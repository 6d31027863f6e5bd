"""Recalls of the teacher, of random behaviours and of nearest-neighbour imitators, decided within compiled worlds."""

from collections.abc import Mapping, Sequence

import numpy as np

from arena_generalisation.recall_arenas import RecallArena
from arena_generalisation.rows import IMITATOR, RANDOM, TEACHER, UNTRAINED, ArenaRecalls
from arena_generalisation.trainings import Training
from khepera_forage.policies.nearest_neighbour.memories import memories_of
from khepera_forage.task.decisions import Decisions


def recall_memories(
    arena: RecallArena,
    trained: Mapping[str, Training],
    seeds: Sequence[int],
    foods: int,
    replication: int,
    decisions: Decisions,
    bounds: bool,
) -> list[ArenaRecalls]:
    """Recalls of imitators with several trainings, and of the bounds.

    Args:
        arena: Where.
        trained: Experience by the name of the training.
        seeds: Of the recalls of each.
        foods: Food objects in the recalls of these seeds that are not poisonous.
        replication: For the rows.
        decisions: Of the recalls.
        bounds: Whether the teacher and random behaviours forage, too.
    """
    from khepera_forage.rollouts.compiled import recalls

    policies = [(IMITATOR, name, number) for number, name in enumerate(trained)]
    if bounds:
        policies += [(TEACHER, UNTRAINED, recalls.TEACHER), (RANDOM, UNTRAINED, recalls.UNIFORM)]
    done = recalls.run_recalls(
        arena.arena,
        memories_of([(own.vectors, own.behaviours) for own in trained.values()]),
        np.repeat([number for *_, number in policies], len(seeds)),
        np.tile(np.array(seeds, np.int64), len(policies)),
        decisions=decisions,
        **arena.arguments,
    )
    rows = []
    for place, (learner, training, _) in enumerate(policies):
        own = slice(place * len(seeds), (place + 1) * len(seeds))
        rows.append(
            ArenaRecalls(
                learner=learner,
                training=training,
                distances=decisions.distances,
                replication=replication,
                group=arena.group,
                arena=arena.name,
                vectors=len(trained[training].vectors) if training in trained else 0,
                recalls=len(seeds),
                foods=foods,
                delivered=int(done.delivered[own].sum()),
                poison_home=int(done.poison_home[own].sum()),
                score=float(done.score[own].mean()),
                steps=int(done.steps[own].sum()),
            )
        )
    return rows
