"""`khepera-forage teach`: scripts look at the pictures and press keys in pygame's queue; the rest is the program."""

import shlex
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pygame
import pytest

from khepera_forage.cli.main import main
from khepera_forage.envs.rendering import View
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.task.states import Behaviour
from tests.cli.teach.keyboard import (
    Script,
    is_over,
    is_separated,
    is_start,
    key_of,
    press,
    release,
    tap,
    teachers_behaviour,
)

FAST = ("--pace", "1000")


class HoldingScript:
    """Holds the key of the teacher's behaviour until the behaviour changes."""

    def __init__(self) -> None:
        self.held: int | None = None

    def __call__(self, env: TrainingEnv, view: View) -> None:
        if is_start(env) or is_over(env):
            press(pygame.K_RETURN)
        wanted = key_of(teachers_behaviour(env, view))
        if is_start(env) or (wanted != self.held and not is_separated(view)):
            if self.held is not None:
                release(self.held)
            press(wanted)
            self.held = wanted


class TappingScript:
    """Taps the key of the teacher's behaviour (its letter, its digit or the space bar), and six wrong keys.

    It restarts the first two attempts after eight rounds.
    """

    def __init__(self) -> None:
        self.chosen: list[Behaviour] = []
        self.wrong = 0
        self.restarts = 0

    def __call__(self, env: TrainingEnv, view: View) -> None:
        if is_start(env):
            tap(pygame.K_SPACE)
            tap(key_of(Behaviour.RELEASE_FOOD))  # Keys before Enter have no effect.
            tap(pygame.K_RETURN)
            tap(pygame.K_SPACE)  # There is no behaviour to repeat yet.
            self.chosen, self.wrong = [], 0
        if is_over(env):
            tap(pygame.K_RETURN)
        if is_over(env) or is_separated(view):
            return
        tap(pygame.K_F5)
        wanted, steps = teachers_behaviour(env, view), len(self.chosen)
        if steps == 8 and self.restarts < 2:
            self.restarts += 1
            tap(pygame.K_BACKSPACE)
            return
        if steps < 36 and steps % 6 == 5:
            wanted = Behaviour((wanted + 1 + steps % 9) % 10)
            self.wrong += 1
        if self.chosen and wanted == self.chosen[-1]:
            tap(pygame.K_SPACE)
        else:
            tap((key_of(wanted), pygame.K_0 + wanted, pygame.K_KP0)[steps % 2 if wanted else 2])
        self.chosen.append(wanted)


@pytest.mark.parametrize("decision", [[], ["--decision", "next_to_food=22"]])
def test_person_with_the_teachers_behaviours_records_the_same_file(
    decision: list[str], run_script: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    run_script(HoldingScript())
    assert main(["teach", "--seed", "1", *FAST, *decision]) == 0
    printed = capsys.readouterr().out
    assert main(["train", "--episodes", "1", "--seed", "1", "--out", "trained", *decision]) == 0
    assert Path("taught/g1.csv").read_bytes() == Path("trained/g1.csv").read_bytes()
    experience = Experience.load("taught/g1.csv")
    assert f"1 episode(s), {len(experience)} experience vectors, 100 %" in printed
    (next_command,) = [line for line in printed.splitlines() if line.startswith("next: ")]
    program, *command = shlex.split(next_command.removeprefix("next: "))
    assert program == "khepera-forage"
    assert main([*command, "--episodes", "1", "--out", "rows.csv"]) == 0
    (row,) = read_rows(Path("rows.csv"), RecallRow)
    assert row.experience_size == len(experience)


def test_wrong_behaviours_are_recorded_and_a_restart_discards_them(
    run_script: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    script = TappingScript()
    run_script(script)
    assert main(["teach", *FAST]) == 0
    assert script.restarts == 2
    experience = Experience.load("taught/g1.csv")
    assert list(experience.behaviours) == script.chosen
    share = 100 * (len(script.chosen) - script.wrong) / len(script.chosen)
    assert f"{share:.0f} % of the behaviours as the hand-coded teacher's" in capsys.readouterr().out
    assert script.wrong == 6
    imitator = NearestNeighbourImitator(diagonal=138).fit(*experience.arrays())
    rng = np.random.default_rng(0)
    assert {imitator.act(vector, rng) for vector in experience.vectors} <= set(script.chosen)
    assert main(["recall", "--experience", "taught/g1.csv", "--episodes", "1", "--out", "rows.csv"]) == 0
    assert [path.name for path in Path("taught").iterdir()] == ["g1.csv"]


def test_escape_keeps_only_complete_episodes(
    run_script: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    holding = HoldingScript()

    def script(env: TrainingEnv, view: View) -> None:
        if Path("taught/g2.csv").exists() and env.infos[TEACHER]["steps"] == 5:
            tap(pygame.K_ESCAPE)
        else:
            holding(env, view)

    run_script(script)
    assert main(["teach", "--episodes", "3", *FAST]) == 0
    assert [path.name for path in Path("taught").iterdir()] == ["g1.csv"]
    experience = Experience.load("taught/g1.csv")
    assert f"1 episode(s), {len(experience)} experience vectors" in capsys.readouterr().out
    assert not pygame.display.get_init()


def test_escape_at_the_start_leaves_no_file(
    run_script: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    run_script(lambda env, view: tap(pygame.K_ESCAPE))
    assert main(["teach"]) == 0
    assert capsys.readouterr().out.endswith("no episode is complete, so no file is kept\n")
    assert list(Path("taught").iterdir()) == []


def test_crash_leaves_a_file_that_can_be_recovered(run_script: Callable[[Script], None]) -> None:
    tapping = TappingScript()

    def script(env: TrainingEnv, view: View) -> None:
        if len(tapping.chosen) == 12:
            raise MemoryError
        tapping(env, view)

    run_script(script)
    with pytest.raises(MemoryError):
        main(["teach", *FAST])
    with pytest.warns(UserWarning, match="closing line"):
        experience = Experience.load("taught/g1.csv", recover=True)
    assert list(experience.behaviours) == tapping.chosen


def test_without_a_display_the_error_says_so_and_no_folder_is_made(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    assert main(["teach"]) == 2
    assert capsys.readouterr().err.startswith("khepera-forage teach: no display to open a window on")
    assert not Path("taught").exists()


def test_without_pygame_the_error_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    monkeypatch.delitem(sys.modules, "khepera_forage.cli.teach_window", raising=False)
    assert main(["teach"]) == 2
    assert "pip install 'khepera-forage[render]'" in capsys.readouterr().err
    assert not Path("taught").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--episodes", "0"], "--episodes: '0'; allowed: a whole number from 1 to"),
        (["--pace", "0"], "--pace: '0'; allowed: more than 0, at most 1000 rounds a second"),
        (["--pace", "nan"], "--pace: 'nan'; allowed: more than 0, at most"),
        (["--food-type", "CHEESE"], "'CHEESE' is unknown"),
        (["--out", "."], "g1.csv exists; choose another --out"),
    ],
)
def test_user_error_is_reported_in_one_line(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("g1.csv").touch()
    assert main(["teach", *arguments]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
