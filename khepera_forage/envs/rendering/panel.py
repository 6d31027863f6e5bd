"""A robot's panel: its senses, its state vector and state, and its behaviour.

Lengths are pixels at text scale 1; `u` is the text scale by which they are multiplied.
"""

from dataclasses import dataclass

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.layout import Box, Layout
from khepera_forage.envs.rendering.palette import Colour
from khepera_forage.envs.rendering.text import Anchor, TextRenderer
from khepera_forage.envs.rendering.view import RobotView
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.task.states import NUM_BEHAVIOURS, Behaviour, FoodType, StateVector, behaviour_for

PAD = 13.0
"""Space between the edge of a panel and its content."""
ROW = 16.0
"""Least height of a line in the list of behaviours."""
HEADING, LABEL, VALUE, SMALL, TINY = 15.0, 17.0, 18.0, 14.0, 12.5
"""Sizes of text."""
ATTRIBUTES = ("ObjectPresence", "RobotHomeDistance", "FoodType", "ArmsHeight", "RobotFoodDistance")
BEHAVIOURS = tuple(Behaviour)[:NUM_BEHAVIOURS]


def sentence_case(name: str) -> str:
    """The name of an enum member as text: READY_TO_PICK_UP_FOOD is "Ready to pick up food"."""
    return name.replace("_", " ").capitalize()


@dataclass(frozen=True, slots=True)
class Panel:
    """One robot's panel in one picture.

    Attributes:
        picture: The picture, with the background of the panel.
        box: Position and size of the panel.
        layout: The picture's layout.
        text: Draws text and boxes.
        robot: The robot.
        colour: The robot's colour.
    """

    picture: pygame.Surface
    box: Box
    layout: Layout
    text: TextRenderer
    robot: RobotView
    colour: Colour

    def draw(self) -> None:
        """Draw everything except the background."""
        u = self.layout.text_scale
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
            # The bars and the list of behaviours share the height below the state vector.
            behaviours = bottom - max((24 + 10 * ROW) * u, 0.56 * (bottom - top - 121 * u))
            self._infra_red(left, right, top + 107 * u, behaviours - 14 * u)
            self._behaviours(left, right, behaviours, bottom - 12 * u)
        self._rule(left, right, bottom - 6 * u)
        self._turret(left, right, bottom + 10 * u)

    def _title(self, left: float, right: float, y: float) -> None:
        """Name, warnings, and the note, shortened if necessary."""
        robot, u = self.robot, self.layout.text_scale
        warnings = [
            (text, ink, fill, self.text.width(text, LABEL * u) + 14 * u)
            for shown, text, ink, fill in (
                (robot.separated, "separated", palette.WARNING, palette.WARNING_FILL),
                (not robot.tracked, "lost", palette.LOST, palette.LOST_FILL),
            )
            if shown
        ]
        room = right - left - 19 * u - sum(width + 8 * u for *_, width in warnings)
        name = self.text.fitted(robot.name, 23 * u, room)
        self.text.dot(self.picture, left + 6 * u, y, 6 * u, self.colour)
        self._write(name, left + 19 * u, y, 23)
        x = left + 29 * u + self.text.width(name, 23 * u)
        for text, ink, fill, width in warnings:
            self.text.box(self.picture, (x, y - 9 * u, width, 18 * u), fill, 9 * u)
            self._write(text, x + 7 * u, y, LABEL, ink)
            x += width + 6 * u
        self._write(
            self.text.fitted(robot.note, LABEL * u, right - x), right, y, LABEL, palette.MUTED, "right"
        )

    def _decision(self, left: float, y: float) -> None:
        """State, heard and executed behaviour, with a mark where the executed behaviour differs from the other two."""
        robot, u = self.robot, self.layout.text_scale
        state = "–" if robot.state is None else sentence_case(robot.state.name)
        silent = robot.heard == Behaviour.WAIT
        heard = "–" if robot.heard is None else "Silence" if silent else sentence_case(robot.heard.name)
        column = left + 80 * u
        for label, text, differs in (
            ("State", state, self._differs_from_state()),
            ("Heard", heard, self._differs_from_heard()),
        ):
            self._write(label, left, y, LABEL, palette.MUTED)
            self._write(text, column, y, VALUE)
            if differs:
                beside = column + self.text.width(text, VALUE * u) + 11 * u
                self._write("differs", beside, y, LABEL, palette.WARNING)
            y += 20 * u
        self._write("Executed", left, y, LABEL, palette.MUTED)
        if robot.executed is None:
            self._write("–", column, y, VALUE)
            return
        text = sentence_case(robot.executed.name)
        box = (column - 8 * u, y - 10 * u, self.text.width(text, VALUE * u) + 16 * u, 20 * u)
        if self._differs_from_state() or self._differs_from_heard():
            self.text.box(self.picture, box, palette.WARNING_FILL, 6 * u, palette.WARNING)
            self._write(text, column, y, VALUE, palette.WARNING)
        else:
            self.text.box(self.picture, box, self.colour, 6 * u)
            self._write(text, column, y, VALUE, palette.CARD)

    def _differs_from_state(self) -> bool:
        """Whether the executed behaviour is not the one that belongs to the state."""
        state, executed = self.robot.state, self.robot.executed
        return state is not None and executed is not None and behaviour_for(state) != executed

    def _differs_from_heard(self) -> bool:
        """Whether the executed behaviour is not the one that was heard."""
        heard, executed = self.robot.heard, self.robot.executed
        return heard is not None and executed is not None and heard != executed

    def _vector(self, left: float, right: float, y: float) -> None:
        """The state vector (4.3), one attribute per line."""
        u = self.layout.text_scale
        self._heading("STATE VECTOR", left, y)
        values = ("–",) * 5 if self.robot.vector is None else _attribute_values(self.robot.vector)
        for row, (attribute, value) in enumerate(zip(ATTRIBUTES, values, strict=True)):
            height = y + (row + 1) * 17 * u
            self._write(attribute, left, height, LABEL, palette.MUTED)
            self._write(value, right, height, LABEL, palette.INK, "right")

    def _infra_red(self, left: float, right: float, y: float, bottom: float) -> None:
        """Eight bars over the whole height, with the robot's own sensor numbers."""
        u = self.layout.text_scale
        self._heading("INFRA-RED", left, y)
        pitch = (right - left) / 8
        top, base = y + 23 * u, bottom - 12 * u
        for number, reading in enumerate(self.robot.proximity[:8]):
            x = left + number * pitch
            share = max(0.0, min(1.0, reading / MAX_READING))
            self.text.box(self.picture, (x + 3 * u, top, pitch - 6 * u, base - top), palette.TRACK)
            full = (base - top) * share
            self.text.box(self.picture, (x + 3 * u, base - full, pitch - 6 * u, full), palette.INFRA_RED)
            self._write(str(round(reading)), x + pitch / 2, top - 7 * u, TINY, palette.INK, "centre")
            self._write(str(number), x + pitch / 2, base + 8 * u, SMALL, palette.MUTED, "centre")

    def _behaviours(self, left: float, right: float, y: float, bottom: float) -> None:
        """All ten behaviours: marks for the state's own, the heard and the executed one, and confidence levels."""
        robot, u = self.robot, self.layout.text_scale
        self._heading("BEHAVIOUR", left, y)
        if robot.confidence is not None:
            self._write("confidence", right, y, HEADING, palette.MUTED, "right")
        differs = self._differs_from_state() or self._differs_from_heard()
        fill = palette.WARNING if differs else self.colour
        own = None if robot.state is None else behaviour_for(robot.state)
        pitch = (bottom - y - 8 * u) / NUM_BEHAVIOURS
        bar = (right - 74 * u, right - 33 * u)
        for behaviour in BEHAVIOURS:
            middle = y + 8 * u + (behaviour + 0.5) * pitch
            text = sentence_case(behaviour.name)
            pill = (left + 9 * u, middle - 7.5 * u, self.text.width(text, 16 * u) + 10 * u, 15 * u)
            ink = palette.INK
            if behaviour == robot.executed:
                ink = palette.CARD
                self.text.box(self.picture, pill, fill, 5 * u)
            elif behaviour == robot.heard:
                self.text.box(self.picture, pill, palette.CARD, 5 * u, palette.INK)
            if behaviour == own:
                self.text.dot(self.picture, left + 3 * u, middle, 3 * u, palette.INK)
            self._write(text, left + 14 * u, middle, 16, ink)
            if robot.confidence is not None and behaviour < len(robot.confidence):
                share = max(0.0, min(1.0, robot.confidence[behaviour]))
                track = (bar[0], middle - 4 * u, bar[1] - bar[0], 8 * u)
                self.text.box(self.picture, track, palette.TRACK)
                self.text.box(self.picture, (*track[:2], track[2] * share, track[3]), self.colour)
                share_ink = palette.INK if share > 0 else palette.MUTED
                self._write(f"{share:.0%}", right, middle, SMALL, share_ink, "right")

    def _turret(self, left: float, right: float, y: float) -> None:
        """Arm, jaw and optical barrier."""
        robot, u = self.robot, self.layout.text_scale
        present = robot.vector is not None and robot.vector.object_presence != 0
        arm = "down" if robot.arm >= ARM_DOWN else "raised" if robot.arm <= ARM_RAISED else f"{robot.arm:.0f}"
        jaw = "open" if robot.jaw >= JAW_OPEN else "closed" if robot.jaw <= JAW_CLOSED else f"{robot.jaw:.0f}"
        gauges = (
            (0.0, 0.3, "Arm", arm, (ARM_DOWN - robot.arm) / (ARM_DOWN - ARM_RAISED), self.colour),
            (0.3, 0.3, "Jaw", jaw, robot.jaw / JAW_OPEN, self.colour),
            (0.6, 0.4, "Object", "present" if present else "none", float(present), palette.OBJECT_PRESENT),
        )
        gap = 14 * u
        for start, part, label, value, share, colour in gauges:
            x = left + start * (right - left + gap)
            width = part * (right - left + gap) - gap
            self._write(label, x, y, LABEL, palette.MUTED)
            self._write(value, x + width, y, LABEL, palette.INK, "right")
            self.text.box(self.picture, (x, y + 9 * u, width, 6 * u), palette.TRACK)
            self.text.box(self.picture, (x, y + 9 * u, width * max(0.0, min(1.0, share)), 6 * u), colour)

    def _heading(self, text: str, x: float, y: float) -> None:
        self._write(text, x, y, HEADING, palette.MUTED)

    def _rule(self, left: float, right: float, y: float) -> None:
        self.text.box(self.picture, (left, y, right - left, 1), palette.EDGE)

    def _write(
        self,
        text: str,
        x: float,
        y: float,
        size: float,
        colour: Colour = palette.INK,
        anchor: Anchor = "left",
    ) -> None:
        self.text.write(self.picture, text, x, y, size * self.layout.text_scale, colour, anchor)


def _attribute_values(vector: StateVector) -> tuple[str, ...]:
    """The values of a state vector as text."""
    known = vector.food_type in tuple(FoodType)
    return (
        "true" if vector.object_presence else "false",
        f"{vector.robot_home_distance} px",
        sentence_case(FoodType(vector.food_type).name) if known else str(vector.food_type),
        str(vector.arms_height),
        f"{vector.robot_food_distance} px",
    )
