"""Teacher and learners beside each other: who is apart, and the way a learner is led (4.5.2)."""

from collections.abc import Sequence

from khepera_forage.envs.forager import Forager
from khepera_forage.robots.khepera import Motors
from khepera_forage.task.following import follow, recover, separated


class Company:
    """The robots of a training episode, the teacher first; its own entry in each list means nothing.

    Args:
        foragers: Each in its own copy of the arena.

    Attributes:
        apart: Whether each learner is separated from the teacher.
        rounds: For how many rounds it has been.
        separations: How often it has become so.
    """

    def __init__(self, foragers: Sequence[Forager]) -> None:
        self._foragers = foragers
        count = len(foragers)
        self.apart = [False] * count
        self.rounds = [0] * count
        self.separations = [0] * count
        self.update()

    def teacher_beside(self, i: int) -> tuple[float, float, float]:
        """Where the teacher is, moved into another robot's arena: x and y in pixels, degrees."""
        teacher, there, here = self._foragers[0].raw, self._foragers[0].site, self._foragers[i].site
        x = teacher.x + here.home_x - there.home_x
        return x, teacher.y + here.home_y - there.home_y, teacher.orientation

    def update(self) -> None:
        """Look who is apart after a round."""
        for i, forager in enumerate(self._foragers[1:], 1):
            x, y, _ = self.teacher_beside(i)
            apart = separated(forager.raw.x, forager.raw.y, x, y)
            self.separations[i] += apart and not self.apart[i]
            self.rounds[i] = self.rounds[i] + 1 if apart else 0
            self.apart[i] = apart

    def lead(self, i: int, motors: Motors, silent: bool) -> Motors:
        """A learner's motors, bent towards the teacher.

        Args:
            i: The learner.
            motors: What its behaviour commands.
            silent: Whether it hears nothing; if it is apart too, it recovers.
        """
        own, (x, y, orientation) = self._foragers[i].raw, self.teacher_beside(i)
        if self.apart[i] and silent:
            return recover(motors, own.x, own.y, own.orientation, x, y)
        return follow(motors, own.x, own.y, own.orientation, x, y, orientation)
