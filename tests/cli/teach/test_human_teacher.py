"""The human teacher: messages, keys and pictures in the window, round by round."""

from collections.abc import Callable, Iterator

import numpy as np
import pygame
import pytest

from khepera_forage.cli.teach import (
    SEPARATED_WARNING,
    Caption,
    HumanTeacher,
    QuitRequest,
    RestartRequest,
)
from khepera_forage.cli.teach_window import TeachingWindow
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.palette import TEACHER as TEACHER_COLOUR
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.rollouts import training
from khepera_forage.task.states import Behaviour
from tests.cli.teach.keyboard import Script, press, release, tap


class RecordingWindow(TeachingWindow):
    """The window, which also records its pictures and captions."""

    def __init__(self) -> None:
        super().__init__()
        self.captions: list[Caption] = []
        self.views: list[View] = []

    def show(self, view: View, caption: Caption) -> None:
        super().show(view, caption)
        self.captions.append(caption)
        self.views.append(view)


@pytest.fixture
def window() -> Iterator[RecordingWindow]:
    window = RecordingWindow()
    yield window
    window.close()


def human_teacher(env: TrainingEnv, window: RecordingWindow, hints: bool = False) -> HumanTeacher:
    env.reset(seed=1)
    return HumanTeacher(env, window, episodes=1, pace=1000, hints=hints)


def test_keys_have_no_effect_while_the_learner_is_separated(window: RecordingWindow) -> None:
    env = TrainingEnv()
    teacher = human_teacher(env, window)
    observation = env.observe(TEACHER)
    observation[6] = 1
    tap(pygame.K_RETURN)
    press(pygame.K_s)
    assert teacher.act(observation) == Behaviour.WAIT
    assert window.captions[-1].message == SEPARATED_WARNING
    assert window.captions[-1].warning
    assert teacher.choices == 0
    observation[6] = 0
    env.infos[TEACHER]["steps"] = 1
    assert teacher.act(observation) == Behaviour.SEARCH_FOR_FOOD, "the key is still held"
    assert not window.captions[-1].warning
    assert teacher.choices == teacher.agreed == 1


def test_caption_shows_the_held_and_the_last_behaviour(window: RecordingWindow) -> None:
    env = TrainingEnv()
    teacher = human_teacher(env, window)
    for post, key in ((tap, pygame.K_RETURN), (press, pygame.K_s), (press, pygame.K_o)):
        post(key)
    observation = env.observe(TEACHER)
    assert teacher.act(observation) == Behaviour.SEARCH_FOR_FOOD
    env.infos[TEACHER]["steps"] = 1
    assert teacher.act(observation) == Behaviour.ORIENT_WITH_FOOD
    assert (window.captions[-1].held, window.captions[-1].last) == (2, 0)
    release(pygame.K_o)
    assert teacher.act(observation) == Behaviour.SEARCH_FOR_FOOD, "that key is still held"
    release(pygame.K_s)
    tap(pygame.K_SPACE)
    assert teacher.act(observation) == Behaviour.SEARCH_FOR_FOOD
    assert [caption.held for caption in window.captions[-3:]] == [0, None, 0]
    tap(pygame.K_BACKSPACE)
    with pytest.raises(RestartRequest):
        teacher.act(observation)
    assert (window.captions[-1].held, window.captions[-1].last) == (None, 0)
    tap(pygame.K_ESCAPE)
    with pytest.raises(QuitRequest):
        teacher.act(observation)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    with pytest.raises(QuitRequest):
        teacher.act(observation)


@pytest.mark.parametrize("hints", [False, True])
def test_state_is_shown_only_with_hints(hints: bool, window: RecordingWindow) -> None:
    env = TrainingEnv()
    teacher = human_teacher(env, window, hints)
    tap(pygame.K_RETURN)
    tap(pygame.K_s)
    teacher.act(env.observe(TEACHER))
    assert all((robot.state is not None) is hints for robot in window.views[-1].robots)
    assert all(robot.vector is not None for robot in window.views[-1].robots)


def test_attempt_after_a_failure_begins_with_the_reason(
    window: RecordingWindow, run_script: Callable[[Script], None]
) -> None:
    env = TrainingEnv(max_cycles=3)
    teacher = human_teacher(env, window)

    def script(env: TrainingEnv, view: View) -> None:
        tap(pygame.K_RETURN)
        tap(pygame.K_v)

    run_script(script)
    with pytest.raises(training.IncompleteTrainingError):
        training.train(
            env, np.random.SeedSequence(0), callback=teacher.after_round, teacher=teacher, attempts=2
        )
    messages = [caption.message for caption in window.captions if "Enter" in caption.message]
    assert messages[0] == "Press Enter to begin."
    assert messages[-1] == "That attempt is discarded: 3 rounds were not enough. Press Enter to begin."


def test_window_fits_the_screen_and_shows_the_whole_picture(window: RecordingWindow) -> None:
    env = TrainingEnv()
    teacher = human_teacher(env, window)
    tap(pygame.K_RETURN)
    press(pygame.K_s)
    teacher.act(env.observe(TEACHER))
    screen, (desktop,) = pygame.display.get_surface(), pygame.display.get_desktop_sizes()
    assert screen is not None
    assert all(side < limit for side, limit in zip(screen.get_size(), desktop, strict=True))
    shown = np.frombuffer(pygame.image.tobytes(screen, "RGB"), np.uint8).reshape(*screen.get_size()[::-1], 3)
    height, width = shown.shape[:2]
    lower_left = shown[int(0.85 * height) :, : width // 5].astype(int)
    lit = (abs(lower_left - TEACHER_COLOUR) <= 3).all(axis=2)
    assert lit.mean() > 0.15, "the key of SEARCH is lit"
