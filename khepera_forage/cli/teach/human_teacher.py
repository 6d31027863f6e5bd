"""A person as the teacher: a policy that shows the environment in a window and reads behaviours from keys."""

from contextlib import suppress
from typing import Protocol

import numpy as np

from khepera_forage.cli.teach.keys import LETTERS, BehaviourKeys, Caption, Keys, QuitRequest
from khepera_forage.envs.rendering import View
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.policies import Observation, Teacher
from khepera_forage.policies.policy import SEPARATED, is_training
from khepera_forage.task.states import Behaviour

CHOOSE = "Press the key of a behaviour: a tap is one round, a held key repeats it."
OTHER_KEYS = "Space: repeat · Backspace: begin again · Esc: end"
SEPARATED_WARNING = "The learner is separated: wait until it is back; keys have no effect."


class Screen(Keys, Protocol):
    """Shows pictures and delivers key events."""

    def show(self, view: View, caption: Caption) -> None:
        """Show a picture with a caption under it."""
        ...


class HumanTeacher:
    """A teacher policy whose behaviours a person chooses with keys, round by round.

    While the learner is separated the teacher WAITs (4.5) and keys have no effect. Every attempt begins with Enter,
    so that a key held since the previous attempt chooses nothing.

    Args:
        env: The training environment, which is shown to the person.
        screen: Shows the environment and delivers keys.
        episodes: Number of episodes to teach, for the title.
        pace: Rounds a second while a key is held.
        hints: Show the state of table 4.1, which determines what the hand-coded teacher would do.

    Attributes:
        episode: Number of the current episode, from 1.
        choices: Number of behaviours chosen in this attempt, without WAIT.
        agreed: Number of choices that agree with the hand-coded teacher on the same state vector.
        news: Message shown at the beginning of the next attempt.
    """

    def __init__(self, env: TrainingEnv, screen: Screen, episodes: int, pace: float, hints: bool) -> None:
        self.episode = 1
        self.choices = self.agreed = 0
        self.news = ""
        self._env = env
        self._screen = screen
        self._episodes = episodes
        self._hints = hints
        self._teacher = Teacher.of(env)
        self._keys = BehaviourKeys(screen, 1.0 / pace, self._show)
        self._view = View(env.arenas)
        self._message, self._warning = CHOOSE, False

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour that the person chooses for this round; WAIT while the learner is separated.

        Args:
            observation: Of the teacher in the training environment.
            rng: Not used.

        Raises:
            ValueError: Not an observation of a training environment.
            RestartRequest: The person discards this attempt.
            QuitRequest: The person ends the teaching.
        """
        if not is_training(observation):
            raise ValueError(
                f"observation is {observation!r}; allowed: seven integers of a training environment"
            )
        self._update_view()
        if self._env.infos[TEACHER]["steps"] == 0:
            self.choices = self.agreed = 0
            self._show_message(f"{self.news} Press Enter to begin.".lstrip())
            self.news = ""
            self._keys.confirm()
        if observation[SEPARATED]:
            self._show_message(SEPARATED_WARNING, warning=True)
            self._keys.rest()
            return Behaviour.WAIT
        self._show_message(CHOOSE)
        chosen = self._keys.choose()
        self.choices += 1
        self.agreed += chosen == self._teacher.act(observation)
        return chosen

    def after_round(self) -> None:
        """Remember why an attempt failed; the next attempt begins with that message."""
        if self._env.truncations[TEACHER]:
            out_of_time = self._env.infos[TEACHER]["steps"] >= self._env.max_cycles
            reason = (
                f"{self._env.max_cycles} rounds were not enough"
                if out_of_time
                else f"the learner was separated for {self._env.patience} rounds"
            )
            self.news = f"That attempt is discarded: {reason}."

    def show_end(self) -> None:
        """Show the last picture until the person presses Enter."""
        self._update_view()
        self._show_message(f"{self.news} Press Enter to close the window.")
        with suppress(QuitRequest):
            self._keys.confirm()

    def _update_view(self) -> None:
        view = self._env.view()
        robots = view.robots if self._hints else tuple(robot._replace(state=None) for robot in view.robots)
        title = f"You are the teacher: episode {self.episode} of {self._episodes}"
        self._view = view._replace(robots=robots, title=title)

    def _show_message(self, message: str, warning: bool = False) -> None:
        self._message, self._warning = message, warning
        self._show()

    def _show(self) -> None:
        caption = Caption(
            LETTERS,
            self._message,
            OTHER_KEYS,
            self._warning,
            held=self._keys.held,
            last=self._keys.last,
        )
        self._screen.show(self._view, caption)
