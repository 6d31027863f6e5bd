"""Fixtures of the tests of `khepera-forage teach`."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pygame
import pytest

from khepera_forage.envs.rendering import View
from khepera_forage.envs.training import TrainingEnv
from tests.cli.teach.keyboard import Script


@pytest.fixture(autouse=True)
def invisible_window(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Use an invisible window; close it after 300 s, and fail, if a test waits for keys that never come."""
    pygame.display.quit()
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.chdir(tmp_path)
    stuck = threading.Event()

    def end() -> None:
        stuck.set()
        pygame.event.post(pygame.event.Event(pygame.QUIT))

    timer = threading.Timer(300, end)
    timer.daemon = True
    timer.start()
    yield
    timer.cancel()
    assert not stuck.is_set(), "the program waited for keys that never came"
    pygame.display.quit()


@pytest.fixture
def run_script(monkeypatch: pytest.MonkeyPatch) -> Callable[[Script], None]:
    """A function that installs a script, which is called with every new picture."""
    view = TrainingEnv.view

    def install(script: Script) -> None:
        def view_and_run(env: TrainingEnv) -> View:
            shown = view(env)
            script(env, shown)
            return shown

        monkeypatch.setattr(TrainingEnv, "view", view_and_run)

    return install
