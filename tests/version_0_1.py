"""The decisions of version 0.1, for tests whose numbers are those of that version, whatever the defaults are."""

from typing import Any

from khepera_forage.envs.arguments import checked_arena, set_up_of, timing_of
from khepera_forage.task.decisions import Decisions, DecisionValues

V0_1 = Decisions.v0_1()
VALUES = V0_1.values()
SET_UP = set_up_of(V0_1)
TIMING = timing_of(V0_1)
CORRIDOR = checked_arena("corridor", V0_1)
RECTANGLE = checked_arena("rectangle", V0_1)


def changed_to(**changes: Any) -> DecisionValues:
    """Version 0.1 with some changes: what the others decide matters, too."""
    return Decisions.from_changes(changes, V0_1).values()
