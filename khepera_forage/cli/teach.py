"""`khepera-forage teach`: a person chooses the teacher's behaviours with keys in a window, round by round."""

import argparse
import shlex
import time
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from khepera_forage.cli import options
from khepera_forage.cli.options import command, flag, option
from khepera_forage.cli.train import PlannedFile, planned_files, require_new
from khepera_forage.envs.paired_arenas_v1 import raw_env
from khepera_forage.envs.rendering import View
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.extras import require
from khepera_forage.option_values import real_number
from khepera_forage.policies import Teacher
from khepera_forage.policies.policy import SEPARATED
from khepera_forage.rollouts import training
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.states import Behaviour

if TYPE_CHECKING:
    from khepera_forage.cli.teach_window import TeachingWindow

LETTERS = {
    Behaviour.SEARCH_FOR_FOOD: "s",
    Behaviour.MOVE_SLOWLY: "m",
    Behaviour.ORIENT_WITH_FOOD: "o",
    Behaviour.EXPLORE_FOOD: "e",
    Behaviour.PICK_UP_FOOD: "p",
    Behaviour.PUSH_FOOD: "u",
    Behaviour.AVOID_FOOD: "a",
    Behaviour.GO_HOME: "g",
    Behaviour.AVOID_HOME: "v",
    Behaviour.RELEASE_FOOD: "r",
}
"""The key of each behaviour: a letter of its name. The digit of its number in table 4.1 works too."""
BEHAVIOUR_OF = {key: behaviour for behaviour, letter in LETTERS.items() for key in (letter, str(int(behaviour)))}
REPEAT, RESTART, QUIT, CONFIRM = "space", ("backspace", True), ("escape", True), (("return", True), ("enter", True))
"""A key, and events of `Window.wait`."""
_KEYS = ", ".join(f"{letter} or {int(b)} {b.name.replace('_', ' ').lower()}" for b, letter in LETTERS.items())
_PACE = "rounds a second while a key is held (5: half the speed of real robots)"
CHOOSE = "Press the key of a behaviour: a tap is one round, a held key repeats it."
SEPARATED_WARNING = "The learner is separated: wait until it is back; keys have no effect."


class Caption(NamedTuple):
    """What is written under the picture: a message, and the behaviours whose key is held, and was chosen last."""

    message: str = CHOOSE
    warning: bool = False
    held: Behaviour | None = None
    last: Behaviour | None = None


class RestartRequest(Exception):  # noqa: N818 (a wish of the person, not an error)
    """The person discards this attempt and begins again."""


class QuitRequest(Exception):  # noqa: N818 (a wish of the person, not an error)
    """The person ends the teaching."""


class HumanTeacher:
    """A teacher policy whose behaviours a person chooses: a tap is one round, a held key repeats.

    Every attempt begins with Enter, so that a key held since the previous attempt chooses nothing.

    Attributes:
        episode: Number of the current episode, from 1.
        choices: Behaviours chosen in this attempt, without WAIT.
        agreed: Choices that agree with the hand-coded teacher on the same state vector.
        news: Message shown at the beginning of the next attempt.
    """

    def __init__(self, env: TrainingEnv, window: "TeachingWindow", episodes: int, pace: float, hints: bool) -> None:
        self.episode = 1
        self.choices = self.agreed = 0
        self.news = ""
        self._env, self._window, self._episodes, self._hints = env, window, episodes, hints
        self._period = 1.0 / pace
        self._teacher = Teacher.of(env)
        self._view = View(env.arenas)
        self._caption = Caption()
        self._pressed: dict[str, Behaviour] = {}  # in the order in which the keys were pressed
        self._due = 0.0

    def act(self, observation: Any, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour that the person chooses for this round; WAIT while the learner is separated."""
        self._update_view()
        if self._env.infos[TEACHER]["steps"] == 0:
            self.choices = self.agreed = 0
            self._show(f"{self.news} Press Enter to begin.".lstrip())
            self.news = ""
            self._confirm()
        if observation[SEPARATED]:
            self._show(SEPARATED_WARNING, warning=True)
            self._due = time.monotonic() + self._period
            while self._next_key(waits=False):
                pass
            return Behaviour.WAIT
        self._show(CHOOSE)
        chosen = self._choose()
        self.choices += 1
        self.agreed += chosen == self._teacher.act(observation)
        return chosen

    def after_round(self) -> None:
        """Remember why an attempt failed; the next attempt begins with that message."""
        if self._env.truncations[TEACHER]:
            reason = f"the learner was separated for {self._env.patience} rounds"
            if self._env.infos[TEACHER]["steps"] >= self._env.max_cycles:
                reason = f"{self._env.max_cycles} rounds were not enough"
            self.news = f"That attempt is discarded: {reason}."

    def show_end(self) -> None:
        """Show the last picture until the person presses Enter."""
        self._update_view()
        self._show(f"{self.news} Press Enter to close the window.")
        with suppress(QuitRequest):
            self._confirm()

    def _choose(self) -> Behaviour:
        """Wait for the behaviour of the next round: a new key, or one that is still held when the round is due."""
        chosen = None
        while chosen is None:
            pressed = self._next_key(waits=not self._pressed)
            chosen = self._caption.held if pressed is None else pressed[0]
        self._due = time.monotonic() + self._period
        self._caption = self._caption._replace(last=chosen)
        return chosen

    def _confirm(self) -> None:
        """Wait for Enter, and forget the keys pressed before it."""
        while self._event() not in CONFIRM:
            pass
        self._pressed.clear()
        self._caption = self._caption._replace(held=None, last=None)

    def _event(self, timeout: float | None = None) -> tuple[str, bool] | None:
        """The next key, and whether it goes down; None if there is none in time."""
        event = self._window.wait(timeout)
        if event == QUIT:
            raise QuitRequest
        return event

    def _next_key(self, waits: bool) -> tuple[Behaviour | None] | None:
        """The behaviour, if any, that the next key event chooses; None if there is none before the round is due."""
        event = self._event(None if waits else max(0.0, self._due - time.monotonic()))
        if event is None:
            return None
        if event == RESTART:
            raise RestartRequest
        key, down = event
        self._pressed.pop(key, None)
        chosen = (self._caption.last if key == REPEAT else BEHAVIOUR_OF.get(key)) if down else None
        if chosen is not None:
            self._pressed[key] = chosen
        held = next(reversed(self._pressed.values()), None)
        if held != self._caption.held:
            self._caption = self._caption._replace(held=held)
            self._window.show(self._view, self._caption)
        return (chosen,)

    def _update_view(self) -> None:
        view = self._env.view()
        robots = (
            view.robots if self._hints else tuple(robot._replace(state=None, correct=None) for robot in view.robots)
        )
        title = f"You are the teacher: episode {self.episode} of {self._episodes}"
        self._view = view._replace(robots=robots, title=title)

    def _show(self, message: str, warning: bool = False) -> None:
        self._caption = self._caption._replace(message=message, warning=warning)
        self._window.show(self._view, self._caption)


@command(
    options.ARENA,
    options.FOOD_TYPE,
    options.episodes(1, "complete training episodes, one file each"),
    options.out("taught", "folder for g1.csv, g2.csv, ..."),
    options.seed("the same seed gives the same episodes"),
    option("--pace", _PACE, real_number(0.0, 1000.0, "rounds a second"), default=5.0),
    flag("--hints", "also show the state of table 4.1, which determines what the hand-coded teacher would do"),
    options.DECISION,
    description="You are the teacher: choose behaviours with keys. The learner records each one, executes it too, and "
    f"follows the teacher. Enter begins an attempt. Keys: {_KEYS}. A tap is one round, a held key repeats the "
    "behaviour, and without a key nothing moves. Space: repeat the last behaviour; Backspace: discard this attempt and "
    "begin again; Escape: end, and keep the complete episodes. While the learner is separated the robots bring it back "
    "by themselves.",
)
def teach_command(arguments: argparse.Namespace) -> None:
    """Be the teacher yourself, with keys in a window."""
    decisions, arena = options.decisions_of(arguments), options.arena_of(arguments)
    files = planned_files(arguments.out, arguments.episodes, arguments.seed)
    require_new(files, "choose another --out, or remove it first")
    require("teaching", "render")
    from khepera_forage.cli.teach_window import TeachingWindow

    env = raw_env(arena, food_types=arguments.food_type, decisions=decisions)
    with closing(env), closing(TeachingWindow()) as window:
        arguments.out.mkdir(parents=True, exist_ok=True)
        teacher = HumanTeacher(env, window, arguments.episodes, arguments.pace, arguments.hints)
        _teach(env, teacher, files, arguments)


def _teach(env: TrainingEnv, teacher: HumanTeacher, files: list[PlannedFile], arguments: argparse.Namespace) -> None:
    """Record one complete episode for each file, until the person quits; print a summary and the next command."""
    recorded: list[Path] = []
    vectors = choices = agreed = 0
    for number, path, each in files:
        teacher.episode = number
        try:
            experience = _record_episode(env, teacher, path, each)
        except (QuitRequest, KeyboardInterrupt):
            path.unlink(missing_ok=True)  # the file of an incomplete attempt
            break
        recorded.append(path)
        vectors, choices, agreed = vectors + len(experience), choices + teacher.choices, agreed + teacher.agreed
        summary = f"{len(experience)} experience vectors, {_agreement(teacher.agreed, teacher.choices)}"
        print(f"{path}: {summary}", flush=True)
        teacher.news = f"Episode {number} is complete: {summary}."
    if not recorded:
        print("no episode is complete, so no file is kept")
        return
    print(f"{len(recorded)} episode(s), {vectors} experience vectors, {_agreement(agreed, choices)}")
    decisions = [word for assignment in arguments.decision for word in ("--decision", assignment)]
    words = ["recall", "--arena", arguments.arena or CORRIDOR, "--experience", *map(str, recorded), *decisions]
    words += ["--food-type", arguments.food_type] if arguments.food_type else []
    print(f"next: khepera-forage {shlex.join(words)}", flush=True)
    if len(recorded) == len(files):
        teacher.show_end()


def _record_episode(env: TrainingEnv, teacher: HumanTeacher, path: Path, seed: np.random.SeedSequence) -> Experience:
    """One complete episode; after each restart by the person it begins again with another seed."""
    while True:
        try:
            return training.train(env, seed, path=path, callback=teacher.after_round, teacher=teacher)[0]
        except RestartRequest:
            path.unlink(missing_ok=True)
            (seed,) = seed.spawn(1)


def _agreement(agreed: int, choices: int) -> str:
    return f"{100 * agreed / max(choices, 1):.0f} % of the behaviours as the hand-coded teacher's"
