"""`khepera-forage teach`: scripts look at the picture and put keys into pygame's queue; all else is the real thing."""

import shlex
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pygame
import pytest

from khepera_forage.cli.main import main
from khepera_forage.cli.teaching.keys import LETTERS, BegunAgain, Ended
from khepera_forage.cli.teaching.person import APART, Person
from khepera_forage.cli.teaching.window import TeachingWindow
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.caption import Caption
from khepera_forage.envs.rendering.palette import TEACHER as TEACHERS_COLOUR
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.rollouts import training
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.task.states import Behaviour, behaviour_for, classify

Script = Callable[[TrainingEnv, View], None]
FAST = ("--pace", "1000")


def press(key: int) -> None:
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))


def release(key: int) -> None:
    pygame.event.post(pygame.event.Event(pygame.KEYUP, key=key))


def tap(key: int) -> None:
    press(key)
    release(key)


def letter(behaviour: Behaviour) -> int:
    return ord(LETTERS[behaviour])


def right(env: TrainingEnv, view: View) -> Behaviour:
    """What the teacher would do, read off the picture."""
    vector = view.robots[0].vector
    assert vector is not None
    return behaviour_for(classify(vector, env.home_radius))


def begins(env: TrainingEnv) -> bool:
    return bool(env.infos[TEACHER]["steps"] == 0)


def over(env: TrainingEnv) -> bool:
    return env.terminations[TEACHER]


def apart(view: View) -> bool:
    return view.robots[1].separated


@pytest.fixture(autouse=True)
def screen(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """A window that nobody sees; a test that waits for keys which never come is ended, and fails."""
    pygame.display.quit()
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.chdir(tmp_path)
    stuck = threading.Event()

    def end() -> None:
        stuck.set()
        pygame.event.post(pygame.event.Event(pygame.QUIT))

    rescue = threading.Timer(300, end)
    rescue.daemon = True
    rescue.start()
    yield
    rescue.cancel()
    assert not stuck.is_set(), "it waited for keys that never came"
    pygame.display.quit()


@pytest.fixture
def sees(monkeypatch: pytest.MonkeyPatch) -> Callable[[Script], None]:
    """Let a script look at every new picture, and press what it likes."""
    view = TrainingEnv.view

    def looks(script: Script) -> None:
        def looked_at(env: TrainingEnv) -> View:
            shown = view(env)
            script(env, shown)
            return shown

        monkeypatch.setattr(TrainingEnv, "view", looked_at)

    return looks


class Holding:
    """Holds the key of the right behaviour down until another one is right."""

    def __init__(self) -> None:
        self.held: int | None = None

    def __call__(self, env: TrainingEnv, view: View) -> None:
        if begins(env) or over(env):
            press(pygame.K_RETURN)
        wanted = letter(right(env, view))
        if begins(env) or (wanted != self.held and not apart(view)):
            if self.held is not None:
                release(self.held)
            press(wanted)
            self.held = wanted


class Tapping:
    """Taps the right key, at first every sixth time a wrong one: its letter, its number, or the space bar."""

    def __init__(self) -> None:
        self.shouted: list[Behaviour] = []
        self.wrong = 0
        self.restarts = 0

    def __call__(self, env: TrainingEnv, view: View) -> None:
        if begins(env):
            tap(pygame.K_SPACE)
            tap(letter(Behaviour.RELEASE_FOOD))  # before Enter nothing counts
            tap(pygame.K_RETURN)
            tap(pygame.K_SPACE)  # there is nothing to repeat yet
            self.shouted, self.wrong = [], 0
        if over(env):
            tap(pygame.K_RETURN)
        if over(env) or apart(view):
            return
        tap(pygame.K_F5)
        wanted, steps = right(env, view), len(self.shouted)
        if steps == 8 and self.restarts < 2:
            self.restarts += 1
            tap(pygame.K_BACKSPACE)
            return
        if steps < 36 and steps % 6 == 5:
            wanted = Behaviour((wanted + 1 + steps % 9) % 10)
            self.wrong += 1
        if self.shouted and wanted == self.shouted[-1]:
            tap(pygame.K_SPACE)
        else:
            tap((letter(wanted), pygame.K_0 + wanted, pygame.K_KP0)[steps % 2 if wanted else 2])
        self.shouted.append(wanted)


def test_whoever_holds_the_right_keys_teaches_as_the_teacher(
    sees: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    sees(Holding())
    assert main(["teach", "--seed", "1", *FAST]) == 0
    told = capsys.readouterr().out
    assert main(["train", "--episodes", "1", "--seed", "1", "--out", "trained"]) == 0
    assert Path("taught/g1.csv").read_bytes() == Path("trained/g1.csv").read_bytes()
    experience = Experience.load("taught/g1.csv")
    assert f"1 episode(s), {len(experience)} experience vectors, 100 %" in told
    (following,) = [line for line in told.splitlines() if line.startswith("next: ")]
    program, *command = shlex.split(following.removeprefix("next: "))
    assert program == "khepera-forage"
    assert main([*command, "--episodes", "1", "--out", "rows.csv"]) == 0
    (row,) = read_rows(Path("rows.csv"), RecallRow)
    assert row.experience_size == len(experience)


def test_mistakes_are_recorded_as_they_are_made_and_a_new_beginning_forgets_them(
    sees: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    person = Tapping()
    sees(person)
    assert main(["teach", *FAST]) == 0
    assert person.restarts == 2
    experience = Experience.load("taught/g1.csv")
    assert list(experience.behaviours) == person.shouted
    share = 100 * (len(person.shouted) - person.wrong) / len(person.shouted)
    assert f"{share:.0f} % of the decisions as the hand-coded teacher's" in capsys.readouterr().out
    assert person.wrong == 6
    imitator = NearestNeighbourImitator(diagonal=138).fit(*experience.arrays())
    draws = np.random.default_rng(0)
    assert {imitator.act(vector, draws) for vector in experience.vectors} <= set(person.shouted)
    assert main(["recall", "--experience", "taught/g1.csv", "--episodes", "1", "--out", "rows.csv"]) == 0
    assert [path.name for path in Path("taught").iterdir()] == ["g1.csv"]


def test_who_ends_keeps_the_complete_episodes_and_nothing_else(
    sees: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    person = Holding()

    def script(env: TrainingEnv, view: View) -> None:
        if Path("taught/g2.csv").exists() and env.infos[TEACHER]["steps"] == 5:
            tap(pygame.K_ESCAPE)
        else:
            person(env, view)

    sees(script)
    assert main(["teach", "--episodes", "3", *FAST]) == 0
    assert [path.name for path in Path("taught").iterdir()] == ["g1.csv"]
    experience = Experience.load("taught/g1.csv")
    assert f"1 episode(s), {len(experience)} experience vectors" in capsys.readouterr().out
    assert not pygame.display.get_init()


def test_who_ends_at_once_has_taught_nothing(
    sees: Callable[[Script], None], capsys: pytest.CaptureFixture[str]
) -> None:
    sees(lambda env, view: tap(pygame.K_ESCAPE))
    assert main(["teach"]) == 0
    assert capsys.readouterr().out.endswith("nothing is complete, so nothing is kept\n")
    assert list(Path("taught").iterdir()) == []


def test_a_killed_program_leaves_what_was_recorded(sees: Callable[[Script], None]) -> None:
    """As a crash does: the rounds so far can be recovered."""
    person = Tapping()

    def script(env: TrainingEnv, view: View) -> None:
        if len(person.shouted) == 12:
            raise MemoryError
        person(env, view)

    sees(script)
    with pytest.raises(MemoryError):
        main(["teach", *FAST])
    with pytest.warns(UserWarning, match="closing line"):
        experience = Experience.load("taught/g1.csv", recover=True)
    assert list(experience.behaviours) == person.shouted


def test_without_a_display_it_says_so_and_makes_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    assert main(["teach"]) == 2
    assert capsys.readouterr().err.startswith("khepera-forage teach: no display to open a window on")
    assert not Path("taught").exists()


def test_without_pygame_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    monkeypatch.delitem(sys.modules, "khepera_forage.cli.teaching.window")
    assert main(["teach"]) == 2
    assert "pip install khepera-forage[render]" in capsys.readouterr().err
    assert not Path("taught").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--episodes", "0"], "--episodes is 0; allowed: at least 1"),
        (["--pace", "0"], "--pace is 0.0; allowed: a positive number"),
        (["--pace", "nan"], "--pace is nan; allowed: a positive number"),
        (["--food-type", "CHEESE"], "'CHEESE' is unknown"),
        (["--out", "."], "g1.csv exists; choose another --out"),
    ],
)
def test_mistakes_are_told_in_one_line(
    arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("g1.csv").touch()
    assert main(["teach", *arguments]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1


class Watched(TeachingWindow):
    """The window, and what stood under its pictures."""

    def __init__(self) -> None:
        super().__init__()
        self.captions: list[Caption] = []
        self.views: list[View] = []

    def show(self, view: View, caption: Caption) -> None:
        super().show(view, caption)
        self.captions.append(caption)
        self.views.append(view)


@pytest.fixture
def window() -> Iterator[Watched]:
    window = Watched()
    yield window
    window.close()


def person_in(env: TrainingEnv, window: Watched, hints: bool = False) -> Person:
    env.reset(seed=1)
    return Person(env, window, episodes=1, pace=1000, hints=hints)


def test_a_person_cannot_shout_at_a_separated_learner(window: Watched) -> None:
    env = TrainingEnv()
    person = person_in(env, window)
    observation = env.observe(TEACHER)
    observation[6] = 1
    tap(pygame.K_RETURN)
    press(pygame.K_s)
    assert person.act(observation) == Behaviour.WAIT
    assert window.captions[-1].message == APART
    assert window.captions[-1].warning
    assert person.decisions == 0
    observation[6] = 0
    env.infos[TEACHER]["steps"] = 1
    assert person.act(observation) == Behaviour.SEARCH_FOR_FOOD, "the key is held still"
    assert not window.captions[-1].warning
    assert person.decisions == person.agreed == 1


def test_the_held_key_is_lit_and_the_last_one_remembered(window: Watched) -> None:
    env = TrainingEnv()
    person = person_in(env, window)
    for post, key in ((tap, pygame.K_RETURN), (press, pygame.K_s), (press, pygame.K_o)):
        post(key)
    observation = env.observe(TEACHER)
    assert person.act(observation) == Behaviour.SEARCH_FOR_FOOD
    env.infos[TEACHER]["steps"] = 1
    assert person.act(observation) == Behaviour.ORIENT_WITH_FOOD
    assert (window.captions[-1].lit, window.captions[-1].last) == (2, 0)
    release(pygame.K_o)
    assert person.act(observation) == Behaviour.SEARCH_FOR_FOOD, "that key is down still"
    release(pygame.K_s)
    tap(pygame.K_SPACE)
    assert person.act(observation) == Behaviour.SEARCH_FOR_FOOD
    assert [caption.lit for caption in window.captions[-3:]] == [0, None, 0]
    tap(pygame.K_BACKSPACE)
    with pytest.raises(BegunAgain):
        person.act(observation)
    assert (window.captions[-1].lit, window.captions[-1].last) == (None, 0)
    tap(pygame.K_ESCAPE)
    with pytest.raises(Ended):
        person.act(observation)
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    with pytest.raises(Ended):
        person.act(observation)


def test_the_teachers_answer_is_shown_to_who_asks_for_hints_only(window: Watched) -> None:
    for hints in (False, True):
        env = TrainingEnv()
        person = person_in(env, window, hints)
        tap(pygame.K_RETURN)
        tap(pygame.K_s)
        person.act(env.observe(TEACHER))
        assert all((robot.state is not None) is hints for robot in window.views[-1].robots)
        assert all(robot.vector is not None for robot in window.views[-1].robots)


def test_what_went_wrong_is_told_before_the_next_attempt(
    window: Watched, sees: Callable[[Script], None]
) -> None:
    env = TrainingEnv(max_cycles=3)
    person = person_in(env, window)

    def script(env: TrainingEnv, view: View) -> None:
        tap(pygame.K_RETURN)
        tap(pygame.K_v)

    sees(script)
    with pytest.raises(training.HopelessTraining):
        training.train(env, np.random.SeedSequence(0), watch=person.watch, teacher=person, attempts=2)
    told = [caption.message for caption in window.captions if "Enter" in caption.message]
    assert told[0] == "Press Enter to begin."
    assert told[-1] == "That attempt is forgotten: 3 rounds were not enough. Press Enter to begin."


def test_the_window_fits_the_screen_and_its_picture_is_all_there(window: Watched) -> None:
    env = TrainingEnv()
    person = person_in(env, window)
    tap(pygame.K_RETURN)
    press(pygame.K_s)
    person.act(env.observe(TEACHER))
    screen, (desktop,) = pygame.display.get_surface(), pygame.display.get_desktop_sizes()
    assert screen is not None
    assert all(side < limit for side, limit in zip(screen.get_size(), desktop, strict=True))
    shown = np.frombuffer(pygame.image.tobytes(screen, "RGB"), np.uint8).reshape(*screen.get_size()[::-1], 3)
    height, width = shown.shape[:2]
    lower_left = shown[int(0.85 * height) :, : width // 5].astype(int)
    lit = (abs(lower_left - TEACHERS_COLOUR) <= 3).all(axis=2)
    assert lit.mean() > 0.15, "the lit key of SEARCH"
