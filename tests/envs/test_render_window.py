"""The render window, and rendering without display, pygame or Pillow, each in a new interpreter."""

import subprocess
import sys

import pytest

DRAW = """
import sys
from khepera_forage.envs.rendering import Screen, View, save_film
from tests.version_0_1 import CORRIDOR, RECTANGLE
def draw(screen, *view, **values):
    return screen.show(lambda: View(*view, **values))
"""


def in_python(code: str, **environment: str) -> str:
    """What code writes in a new interpreter, with warnings as errors and only the given environment variables."""
    command = [sys.executable, "-W", "error", "-c", DRAW + code]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    return f"{done.stdout}{done.stderr}" or f"status {done.returncode}"


@pytest.mark.parametrize("environment", [{}, {"SDL_VIDEODRIVER": "no such driver"}], ids=["unset", "invalid"])
def test_arrays_need_no_display(environment: dict[str, str]) -> None:
    code = """
assert draw(Screen("rgb_array", 0.1), (CORRIDOR,)).any()
import pygame
assert pygame.display.get_init() is False
"""
    assert in_python(code, **environment) == "status 0"


def test_window_opens_draws_and_closes() -> None:
    code = """
import pygame
screen = Screen("human", 0.001)
assert not pygame.display.get_init()
for _ in range(2):
    assert draw(screen, (CORRIDOR,), title="one") is None
    small = pygame.display.get_surface().get_size()
    assert draw(screen, (RECTANGLE,), title="two") is None
    assert pygame.display.get_surface().get_size() != small
    assert pygame.display.get_caption()[0] == "two"
    assert pygame.surfarray.array3d(pygame.display.get_surface()).std() > 5
    screen.close()
    screen.close()
    assert not pygame.display.get_init()
draw(screen, (CORRIDOR,))
pygame.event.post(pygame.event.Event(pygame.QUIT))
for _ in range(2):
    draw(screen, (CORRIDOR,))
    assert not pygame.display.get_init()
screen.close()
draw(screen, (CORRIDOR,))
assert pygame.display.get_init()
screen.close()
"""
    assert in_python(code, SDL_VIDEODRIVER="dummy") == "status 0"


def test_window_without_display_warns() -> None:
    said = in_python('draw(Screen("human", 0.001), (CORRIDOR,))')
    assert "no display to open a window on" in said
    assert "Nobody sees this window" in said


def test_missing_pygame_or_pillow_is_reported_with_what_to_install() -> None:
    code = """
sys.modules["pygame"] = sys.modules["PIL"] = None
import numpy as np
from gymnasium.error import DependencyNotInstalled
frame, screen = np.zeros((2, 2, 3), np.uint8), Screen("rgb_array", 0.1)
for missing in (lambda: draw(screen, (CORRIDOR,)), lambda: save_film([frame], "never.gif", 10.0)):
    try:
        missing()
    except DependencyNotInstalled as error:
        assert "pip install 'khepera-forage[render]'" in str(error), error
    else:
        raise AssertionError("no error")
"""
    assert in_python(code) == "status 0"
