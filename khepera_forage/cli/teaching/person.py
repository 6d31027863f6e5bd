"""A person in the teacher's place: sees what the environment shows, and decides with keys."""

from typing import Protocol

import numpy as np

from khepera_forage.cli.teaching.keys import LETTERS, Ended, Hand, Keys
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.caption import Caption
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.policies import Observation, Teacher
from khepera_forage.policies.policy import SEPARATED, is_training
from khepera_forage.task.states import Behaviour

HOW = "Press the key of a behaviour: a tap is one round, and a held key goes on."
ASIDE = "Space: the same again · Backspace: begin again · Esc: end"
APART = "The learner is separated: the robots wait for it, and you cannot shout."


class Stage(Keys, Protocol):
    """Where a person sees what goes on, and has keys."""

    def show(self, view: View, caption: Caption) -> None:
        """Show a picture, and what stands under it."""
        ...


class Person:
    """Decides as the person at the keys does, round by round; nothing moves before a key is pressed.

    While the learner is separated the teacher WAITs, whatever is pressed (4.5): that is the routine of the training,
    not a behaviour to be taught. Every attempt begins with Enter, so that a key still held from the attempt before
    shouts nothing.

    Args:
        env: What the person sees; this is its teacher.
        stage: Where.
        episodes: How many are wanted, to be told.
        pace: Rounds a second while a key is held.
        hints: Show the state of table 4.1, which says what the hand-coded teacher would do.

    Attributes:
        episode: Number of the present one, from 1.
        decisions: Behaviours chosen in this attempt, WAIT not counted.
        agreed: Those that the hand-coded teacher would have chosen on the same state vector.
        news: Told at the beginning of the next attempt.
    """

    def __init__(self, env: TrainingEnv, stage: Stage, episodes: int, pace: float, hints: bool) -> None:
        self.episode = 1
        self.decisions = self.agreed = 0
        self.news = ""
        self._env = env
        self._stage = stage
        self._episodes = episodes
        self._hints = hints
        self._teacher = Teacher(env.home_radius)
        self._hand = Hand(stage, 1.0 / pace, self._show)
        self._view = View(env.arenas)
        self._message, self._warning = HOW, False

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """What the person wants done in this round, or WAIT.

        Args:
            observation: Of the training environment.
            rng: Not used.

        Raises:
            ValueError: Not an observation of the training environment.
            BegunAgain: The person gives this attempt up.
            Ended: The person ends the teaching.
        """
        if not is_training(observation):
            raise ValueError(
                f"observation is {observation!r}; allowed: seven integers of a training environment"
            )
        self._look()
        if self._env.infos[TEACHER]["steps"] == 0:
            self.decisions = self.agreed = 0
            self._say(f"{self.news} Press Enter to begin.".lstrip())
            self.news = ""
            self._hand.confirm()
        if observation[SEPARATED]:
            self._say(APART, warning=True)
            self._hand.rest()
            return Behaviour.WAIT
        self._say(HOW)
        chosen = self._hand.choose()
        self.decisions += 1
        self.agreed += chosen == self._teacher.act(observation)
        return chosen

    def watch(self) -> None:
        """After a round: an attempt that has gone wrong is told of when the next begins."""
        if self._env.truncations[TEACHER]:
            late = self._env.infos[TEACHER]["steps"] >= self._env.max_cycles
            why = (
                f"{self._env.max_cycles} rounds were not enough"
                if late
                else f"the learner was separated for {self._env.patience} rounds"
            )
            self.news = f"That attempt is forgotten: {why}."

    def take_leave(self) -> None:
        """Show how it ended until the person has seen it."""
        self._look()
        self._say(f"{self.news} Press Enter to close the window.")
        try:
            self._hand.confirm()
        except Ended:
            return

    def _look(self) -> None:
        view = self._env.view()
        robots = view.robots if self._hints else tuple(robot._replace(state=None) for robot in view.robots)
        title = f"You are the teacher: episode {self.episode} of {self._episodes}"
        self._view = view._replace(robots=robots, title=title)

    def _say(self, message: str, warning: bool = False) -> None:
        self._message, self._warning = message, warning
        self._show()

    def _show(self) -> None:
        caption = Caption(
            LETTERS, self._message, ASIDE, self._warning, lit=self._hand.held, last=self._hand.last
        )
        self._stage.show(self._view, caption)
