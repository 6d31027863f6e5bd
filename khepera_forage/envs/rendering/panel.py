"""A robot's panel: what it senses, what it makes of that, and what it does."""

from dataclasses import dataclass

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.layout import Box, Layout
from khepera_forage.envs.rendering.lettering import Anchor, Lettering
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.view import RobotView
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.task.states import Behaviour, FoodType, StateVector, behaviour_for

PAD = 13.0
"""Inside the edge of a panel, at text scale 1, like all lengths below."""
ROW = 16.0
HEADING, LABEL, VALUE, SMALL, TINY = 15.0, 17.0, 18.0, 14.0, 12.5
"""Sizes of text."""
ATTRIBUTES = ("ObjectPresence", "RobotHomeDistance", "FoodType", "ArmsHeight", "RobotFoodDistance")
BEHAVIOURS = tuple(Behaviour)[:10]


def phrase(name: str) -> str:
    """READY_TO_PICK_UP_FOOD as one reads it."""
    return name.replace("_", " ").capitalize()


@dataclass(frozen=True, slots=True)
class Panel:
    """One panel of a picture, for one robot at one moment.

    Attributes:
        on: The picture; the panel's card is on it already.
        box: Where the panel lies.
        layout: The picture's layout.
        letters: Writes.
        robot: Whose panel it is.
        accent: The robot's colour.
    """

    on: pygame.Surface
    box: Box
    layout: Layout
    letters: Lettering
    robot: RobotView
    accent: Colour

    def draw(self) -> None:
        """Everything but the card."""
        u = self.layout.text
        left, right = self.box.left + PAD * u, self.box.left + self.box.width - PAD * u
        bottom = self.box.top + self.box.height - (PAD + 24) * u
        self._title(left, right, self.box.top + 22 * u)
        self._decision(left, self.box.top + 46 * u)
        self._rule(left, right, self.box.top + 104 * u)
        top = self.box.top + 119 * u
        if self.layout.columns == 2:
            middle = (left + right) / 2
            self._vector(left, middle - 10 * u, top)
            self._infra_red(left, middle - 10 * u, top + 107 * u, bottom - 12 * u)
            self._behaviours(middle + 10 * u, right, top, bottom - 12 * u)
        else:
            self._vector(left, right, top)
            # What height the state vector leaves, the bars and the behaviours share.
            behaviours = bottom - max((24 + 10 * ROW) * u, 0.56 * (bottom - top - 121 * u))
            self._infra_red(left, right, top + 107 * u, behaviours - 14 * u)
            self._behaviours(left, right, behaviours, bottom - 12 * u)
        self._rule(left, right, bottom - 6 * u)
        self._turret(left, right, bottom + 10 * u)

    def _title(self, left: float, right: float, y: float) -> None:
        """Name, warnings, and the note as far as it fits."""
        robot, u = self.robot, self.layout.text
        warnings = [
            (text, ink, fill, self.letters.width(text, LABEL * u) + 14 * u)
            for shown, text, ink, fill in (
                (robot.separated, "separated", palette.WARNING, palette.WARNING_FILL),
                (not robot.tracked, "lost", palette.LOST, palette.LOST_FILL),
            )
            if shown
        ]
        room = right - left - 19 * u - sum(width + 8 * u for *_, width in warnings)
        name = self.letters.fitted(robot.name, 23 * u, room)
        self.letters.dot(self.on, left + 6 * u, y, 6 * u, self.accent)
        self._write(name, left + 19 * u, y, 23)
        x = left + 29 * u + self.letters.width(name, 23 * u)
        for text, ink, fill, width in warnings:
            self.letters.box(self.on, (x, y - 9 * u, width, 18 * u), fill, 9 * u)
            self._write(text, x + 7 * u, y, LABEL, ink)
            x += width + 6 * u
        self._write(
            self.letters.fitted(robot.note, LABEL * u, right - x), right, y, LABEL, palette.FADED, "right"
        )

    def _decision(self, left: float, y: float) -> None:
        """State, heard, executed: marked where the last is not what was heard, or not the state's own."""
        robot, u = self.robot, self.layout.text
        state = "–" if robot.state is None else phrase(robot.state.name)
        silent = robot.heard == Behaviour.WAIT
        heard = "–" if robot.heard is None else "Silence" if silent else phrase(robot.heard.name)
        column = left + 80 * u
        for label, text, differs in (
            ("State", state, self._not_own()),
            ("Heard", heard, self._not_heard()),
        ):
            self._write(label, left, y, LABEL, palette.FADED)
            self._write(text, column, y, VALUE)
            if differs:
                beside = column + self.letters.width(text, VALUE * u) + 11 * u
                self._write("differs", beside, y, LABEL, palette.WARNING)
            y += 20 * u
        self._write("Executed", left, y, LABEL, palette.FADED)
        if robot.executed is None:
            self._write("–", column, y, VALUE)
            return
        text = phrase(robot.executed.name)
        box = (column - 8 * u, y - 10 * u, self.letters.width(text, VALUE * u) + 16 * u, 20 * u)
        if self._not_own() or self._not_heard():
            self.letters.box(self.on, box, palette.WARNING_FILL, 6 * u, palette.WARNING)
            self._write(text, column, y, VALUE, palette.WARNING)
        else:
            self.letters.box(self.on, box, self.accent, 6 * u)
            self._write(text, column, y, VALUE, palette.CARD)

    def _not_own(self) -> bool:
        """Whether something else is executed than the state's own behaviour."""
        state, executed = self.robot.state, self.robot.executed
        return state is not None and executed is not None and behaviour_for(state) != executed

    def _not_heard(self) -> bool:
        """Whether something else is executed than what was heard."""
        heard, executed = self.robot.heard, self.robot.executed
        return heard is not None and executed is not None and heard != executed

    def _vector(self, left: float, right: float, y: float) -> None:
        """The state vector (4.3), an attribute a line."""
        u = self.layout.text
        self._heading("STATE VECTOR", left, y)
        values = ("–",) * 5 if self.robot.vector is None else _shown(self.robot.vector)
        for row, (attribute, value) in enumerate(zip(ATTRIBUTES, values, strict=True)):
            height = y + (row + 1) * 17 * u
            self._write(attribute, left, height, LABEL, palette.FADED)
            self._write(value, right, height, LABEL, palette.INK, "right")

    def _infra_red(self, left: float, right: float, y: float, bottom: float) -> None:
        """Eight bars, numbered as the robot numbers its sensors; they take all the height there is."""
        u = self.layout.text
        self._heading("INFRA-RED", left, y)
        pitch = (right - left) / 8
        top, foot = y + 23 * u, bottom - 12 * u
        for number, reading in enumerate(self.robot.proximity[:8]):
            x = left + number * pitch
            share = max(0.0, min(1.0, reading / MAX_READING))
            self.letters.box(self.on, (x + 3 * u, top, pitch - 6 * u, foot - top), palette.TRACK)
            full = (foot - top) * share
            self.letters.box(self.on, (x + 3 * u, foot - full, pitch - 6 * u, full), palette.INFRA_RED)
            self._write(str(round(reading)), x + pitch / 2, top - 7 * u, TINY, palette.INK, "centre")
            self._write(str(number), x + pitch / 2, foot + 8 * u, SMALL, palette.FADED, "centre")

    def _behaviours(self, left: float, right: float, y: float, bottom: float) -> None:
        """All ten: which is the state's own, heard, executed; and how confident the imitator is of each."""
        robot, u = self.robot, self.layout.text
        self._heading("BEHAVIOUR", left, y)
        if robot.confidence is not None:
            self._write("confidence", right, y, HEADING, palette.FADED, "right")
        fill = palette.WARNING if self._not_own() or self._not_heard() else self.accent
        own = None if robot.state is None else behaviour_for(robot.state)
        pitch = (bottom - y - 8 * u) / 10
        bar = (right - 74 * u, right - 33 * u)
        for behaviour in BEHAVIOURS:
            middle = y + 8 * u + (behaviour + 0.5) * pitch
            text = phrase(behaviour.name)
            pill = (left + 9 * u, middle - 7.5 * u, self.letters.width(text, 16 * u) + 10 * u, 15 * u)
            ink = palette.INK
            if behaviour == robot.executed:
                ink = palette.CARD
                self.letters.box(self.on, pill, fill, 5 * u)
            elif behaviour == robot.heard:
                self.letters.box(self.on, pill, palette.CARD, 5 * u, palette.INK)
            if behaviour == own:
                self.letters.dot(self.on, left + 3 * u, middle, 3 * u, palette.INK)
            self._write(text, left + 14 * u, middle, 16, ink)
            if robot.confidence is not None and behaviour < len(robot.confidence):
                share = max(0.0, min(1.0, robot.confidence[behaviour]))
                track = (bar[0], middle - 4 * u, bar[1] - bar[0], 8 * u)
                self.letters.box(self.on, track, palette.TRACK)
                self.letters.box(self.on, (*track[:2], track[2] * share, track[3]), self.accent)
                faint = palette.INK if share > 0 else palette.FADED
                self._write(f"{share:.0%}", right, middle, SMALL, faint, "right")

    def _turret(self, left: float, right: float, y: float) -> None:
        """Arm, jaw and optical barrier."""
        robot, u = self.robot, self.layout.text
        present = robot.vector is not None and robot.vector.object_presence != 0
        arm = "down" if robot.arm >= ARM_DOWN else "raised" if robot.arm <= ARM_RAISED else f"{robot.arm:.0f}"
        jaw = "open" if robot.jaw >= JAW_OPEN else "closed" if robot.jaw <= JAW_CLOSED else f"{robot.jaw:.0f}"
        gauges = (
            (0.0, 0.3, "Arm", arm, (ARM_DOWN - robot.arm) / (ARM_DOWN - ARM_RAISED), self.accent),
            (0.3, 0.3, "Jaw", jaw, robot.jaw / JAW_OPEN, self.accent),
            (0.6, 0.4, "Object", "present" if present else "none", float(present), palette.LAMP),
        )
        gap = 14 * u
        for start, part, label, value, share, colour in gauges:
            x = left + start * (right - left + gap)
            width = part * (right - left + gap) - gap
            self._write(label, x, y, LABEL, palette.FADED)
            self._write(value, x + width, y, LABEL, palette.INK, "right")
            self.letters.box(self.on, (x, y + 9 * u, width, 6 * u), palette.TRACK)
            self.letters.box(self.on, (x, y + 9 * u, width * max(0.0, min(1.0, share)), 6 * u), colour)

    def _heading(self, text: str, x: float, y: float) -> None:
        self._write(text, x, y, HEADING, palette.FADED)

    def _rule(self, left: float, right: float, y: float) -> None:
        self.letters.box(self.on, (left, y, right - left, 1), palette.EDGE)

    def _write(
        self,
        text: str,
        x: float,
        y: float,
        size: float,
        colour: Colour = palette.INK,
        anchor: Anchor = "left",
    ) -> None:
        self.letters.write(self.on, text, x, y, size * self.layout.text, colour, anchor)


def _shown(vector: StateVector) -> tuple[str, ...]:
    """The values of a state vector as they are read."""
    known = vector.food_type in tuple(FoodType)
    return (
        "true" if vector.object_presence else "false",
        f"{vector.robot_home_distance} px",
        phrase(FoodType(vector.food_type).name) if known else str(vector.food_type),
        str(vector.arms_height),
        f"{vector.robot_food_distance} px",
    )
