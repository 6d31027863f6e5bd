"""`khepera-forage teach`: scripts look at the pictures and press keys in pygame's queue; the rest is the program."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pygame
import pytest

from khepera_forage.cli.teach import BEHAVIOUR_OF, LETTERS, SEPARATED_WARNING, Caption, HumanTeacher
from khepera_forage.cli.teach_window import COLUMNS, TeachingWindow, with_caption
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.palette import TEACHER as TEACHER_COLOUR
from khepera_forage.envs.rendering.picture import Painter, to_array
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.rollouts import training
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.task.states import Behaviour, behaviour_for, classify
from tests.cli.running import Run

Script = Callable[[TrainingEnv, View], object]
"""Looks at a new picture and presses keys."""
TEACH = "teach --pace 1000"


@pytest.fixture(autouse=True)
def invisible_window(empty_folder_without_display: None, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Use an invisible window, and close it after 300 s if a test waits for keys that never come."""
    pygame.display.quit()
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    timer = threading.Timer(300, pygame.event.post, [pygame.event.Event(pygame.QUIT)])
    timer.daemon = True
    timer.start()
    yield
    timer.cancel()
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


def holding_script() -> Script:
    """Holds the key of the teacher's behaviour until the behaviour changes."""
    held: list[int] = []

    def script(env: TrainingEnv, view: View) -> None:
        if is_start(env) or env.terminations[TEACHER]:
            press(pygame.K_RETURN)
        wanted = key_of(teachers_behaviour(env, view))
        if is_start(env) or (wanted not in held and not view.robots[1].separated):
            if held:
                release(held.pop())
            press(wanted)
            held.append(wanted)

    return script


class TappingScript:
    """Taps the key of the teacher's behaviour (its letter, its digit or the space bar), and six wrong keys.

    It restarts the first two attempts after eight rounds, and leaves the second episode after one.
    """

    def __init__(self) -> None:
        self.chosen: list[Behaviour] = []
        self.wrong = 0
        self.restarts = 0

    def __call__(self, env: TrainingEnv, view: View) -> None:
        if Path("taught/g2.csv").exists():
            for key in (pygame.K_RETURN, pygame.K_s) if is_start(env) else (pygame.K_ESCAPE,):
                tap(key)
            return
        if is_start(env):
            tap(pygame.K_SPACE)
            tap(key_of(Behaviour.RELEASE_FOOD))  # Keys before Enter have no effect.
            tap(pygame.K_RETURN)
            tap(pygame.K_SPACE)  # There is no behaviour to repeat yet.
            self.chosen, self.wrong = [], 0
        if env.terminations[TEACHER]:
            tap(pygame.K_RETURN)
        if env.terminations[TEACHER] or view.robots[1].separated:
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


def test_person_with_the_teachers_behaviours_records_the_same_file(
    run_script: Callable[[Script], None], run: Run
) -> None:
    chosen = "--decision next_to_food=22 --food-type PUSHABLE"
    run_script(holding_script())
    printed = run(f"{TEACH} --seed 2 {chosen}")
    run(f"train --episodes 1 --seed 2 --out trained {chosen}")
    assert Path("taught/g1.csv").read_bytes() == Path("trained/g1.csv").read_bytes()
    experience = Experience.load("taught/g1.csv")
    assert f"1 episode(s), {len(experience)} experience vectors, 100 %" in printed
    (next_command,) = [line for line in printed.splitlines() if line.startswith("next: ")]
    assert next_command.endswith(chosen)
    run(f"{next_command.removeprefix('next: khepera-forage ')} --episodes 1 --out rows.csv")
    (row,) = read_rows(Path("rows.csv"), RecallRow)
    assert row.experience_size == len(experience)


def test_wrong_behaviours_are_recorded_and_a_restart_or_escape_discards_them(
    run_script: Callable[[Script], None], run: Run
) -> None:
    script = TappingScript()
    run_script(script)
    printed = run(f"{TEACH} --episodes 3")
    assert not pygame.display.get_init()
    assert script.restarts == 2
    experience = Experience.load("taught/g1.csv")
    assert list(experience.behaviours) == script.chosen
    share = 100 * (len(script.chosen) - script.wrong) / len(script.chosen)
    assert f"1 episode(s), {len(experience)} experience vectors" in printed
    assert f"{share:.0f} % of the behaviours as the hand-coded teacher's" in printed
    assert script.wrong == 6
    assert [path.name for path in Path("taught").iterdir()] == ["g1.csv"]


def test_window_that_is_closed_at_the_start_leaves_no_file(run_script: Callable[[Script], None], run: Run) -> None:
    run_script(lambda env, view: pygame.event.post(pygame.event.Event(pygame.QUIT)))
    assert run("teach").endswith("no episode is complete, so no file is kept\n")
    assert list(Path("taught").iterdir()) == []


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
    teacher, observation = human_teacher(env, window), env.observe(TEACHER)
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
    assert all(robot.state is None and robot.vector is not None for robot in window.views[-1].robots)


def test_last_of_two_held_keys_counts_and_is_marked(window: RecordingWindow) -> None:
    env = TrainingEnv()
    teacher, observation = human_teacher(env, window, hints=True), env.observe(TEACHER)
    tap(pygame.K_RETURN)
    press(pygame.K_s)
    press(pygame.K_o)
    assert teacher.act(observation) == Behaviour.SEARCH_FOR_FOOD
    env.infos[TEACHER]["steps"] = 1
    assert teacher.act(observation) == Behaviour.ORIENT_WITH_FOOD
    assert (window.captions[-1].held, window.captions[-1].last) == (2, 0)
    release(pygame.K_o)
    assert teacher.act(observation) == Behaviour.SEARCH_FOR_FOOD, "that key is still held"
    assert (window.captions[-1].held, window.captions[-1].last) == (0, 2)
    assert all(robot.state is not None for robot in window.views[-1].robots)


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
        training.train(env, np.random.SeedSequence(0), callback=teacher.after_round, teacher=teacher, attempts=2)
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


def test_every_behaviour_has_a_letter_and_a_number_and_its_key_is_marked() -> None:
    assert list(LETTERS) == list(Behaviour)[:10]
    assert len(set(LETTERS.values())) == 10
    view, painter = View(TrainingEnv().arenas), Painter()
    above = to_array(painter.paint(view))
    before = to_array(with_caption(painter.paint(view), Caption()))
    np.testing.assert_array_equal(before[: len(above)], above)
    for behaviour, letter in LETTERS.items():
        assert letter.upper() in behaviour.name
        assert BEHAVIOUR_OF[letter] == BEHAVIOUR_OF[str(int(behaviour))] == behaviour
        row, column = divmod(int(behaviour), COLUMNS)
        for marked in (Caption(held=behaviour), Caption(last=behaviour)):
            after = to_array(with_caption(painter.paint(view), marked))
            rows, columns = np.nonzero((before != after).any(axis=2))
            middle = (columns.min() + columns.max()) / 2 / before.shape[1]
            assert abs(middle - (column + 0.5) / COLUMNS) < 0.03
            assert 36 + 38 * row <= rows.min() - len(above) <= rows.max() - len(above) < 36 + 38 * (row + 1)
    for changed in (Caption("Wait."), Caption(warning=True), Caption("word " * 60)):
        after = to_array(with_caption(painter.paint(view), changed))
        rows = np.nonzero((before != after).any(axis=2))[0]
        assert len(above) <= rows.min() <= rows.max() < len(above) + 36
