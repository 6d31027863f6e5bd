"""Simulated key presses, and what a person reads off the picture before pressing."""

from collections.abc import Callable

import pygame

from khepera_forage.cli.teach import LETTERS
from khepera_forage.envs.rendering import View
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.task.states import Behaviour, behaviour_for, classify

Script = Callable[[TrainingEnv, View], None]
"""Looks at a new picture and presses keys."""


def press(key: int) -> None:
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))


def release(key: int) -> None:
    pygame.event.post(pygame.event.Event(pygame.KEYUP, key=key))


def tap(key: int) -> None:
    press(key)
    release(key)


def key_of(behaviour: Behaviour) -> int:
    return ord(LETTERS[behaviour])


def teachers_behaviour(env: TrainingEnv, view: View) -> Behaviour:
    """The behaviour of the hand-coded teacher for the state vector in the picture."""
    vector = view.robots[0].vector
    assert vector is not None
    return behaviour_for(classify(vector, env.home_radius, env.decisions.values()))


def is_start(env: TrainingEnv) -> bool:
    return bool(env.infos[TEACHER]["steps"] == 0)


def is_over(env: TrainingEnv) -> bool:
    return env.terminations[TEACHER]


def is_separated(view: View) -> bool:
    return view.robots[1].separated
