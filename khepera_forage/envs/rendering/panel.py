"""A robot's panel: its senses, its state vector and state, and its behaviour.

Lengths are pixels at text scale 1; `u` is the text scale by which they are multiplied.
"""

from dataclasses import dataclass

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.drawing import Anchor, box, clamped, dot, fitted, text_width, write
from khepera_forage.envs.rendering.palette import Colour
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


def sentence_case(name: str) -> str:
    """The name of an enum member as text: READY_TO_PICK_UP_FOOD is "Ready to pick up food"."""
    return name.replace("_", " ").capitalize()


@dataclass(frozen=True, slots=True)
class Panel:
    """One robot's panel in one picture.

    Attributes:
        picture: The picture, with the background of the panel.
        place: Position and size of the panel.
        columns: 1 or 2.
        u: Scale of the text.
        robot: The robot.
        colour: The robot's colour.
    """

    picture: pygame.Surface
    place: pygame.Rect
    columns: int
    u: float
    robot: RobotView
    colour: Colour

    def draw(self) -> None:
        """Draw everything except the background."""
        u = self.u
        left, right = self.place.left + PAD * u, self.place.right - PAD * u
        bottom = self.place.bottom - (PAD + 24) * u
        self._title(left, right, self.place.top + 22 * u)
        self._decision(left, self.place.top + 46 * u)
        self._rule(left, right, self.place.top + 104 * u)
        top = self.place.top + 119 * u
        if self.columns == 2:
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

    def _deviates(self, *expected: Behaviour | None) -> bool:
        """Whether the executed behaviour is another than one of those expected, as far as they are known."""
        executed = self.robot.executed
        return executed is not None and any(each not in (None, executed) for each in expected)

    def _title(self, left: float, right: float, y: float) -> None:
        """Name, shortened if necessary, and warnings."""
        robot, u = self.robot, self.u
        warnings = []
        if robot.separated:
            warnings.append(("separated", palette.WARNING, palette.WARNING_FILL))
        if not robot.tracked:
            warnings.append(("lost", palette.LOST, palette.LOST_FILL))
        widths = [text_width(text, LABEL * u) + 14 * u for text, _, _ in warnings]
        name = fitted(robot.name, 23 * u, right - left - 19 * u - sum(width + 8 * u for width in widths))
        dot(self.picture, left + 6 * u, y, 6 * u, self.colour)
        self._write(name, left + 19 * u, y, 23)
        x = left + 29 * u + text_width(name, 23 * u)
        for (text, ink, fill), width in zip(warnings, widths, strict=True):
            box(self.picture, (x, y - 9 * u, width, 18 * u), fill, 9 * u)
            self._write(text, x + 7 * u, y, LABEL, ink)
            x += width + 6 * u

    def _decision(self, left: float, y: float) -> None:
        """State, heard and executed behaviour, marked where that is wrong, and where it differs from the one heard."""
        robot, u = self.robot, self.u
        state = "–" if robot.state is None else sentence_case(robot.state.name)
        silent = robot.heard == Behaviour.WAIT
        heard = "–" if robot.heard is None else "Silence" if silent else sentence_case(robot.heard.name)
        column = left + 80 * u
        for label, text in (("State", state), ("Heard", heard)):
            self._write(label, left, y, LABEL, palette.MUTED)
            self._write(text, column, y, VALUE)
            if label == "Heard" and self._deviates(robot.heard):
                beside = column + text_width(text, VALUE * u) + 11 * u
                self._write("differs", beside, y, LABEL, palette.WARNING)
            y += 20 * u
        self._write("Executed", left, y, LABEL, palette.MUTED)
        if robot.executed is None:
            self._write("–", column, y, VALUE)
            return
        text = sentence_case(robot.executed.name)
        pill = (column - 8 * u, y - 10 * u, text_width(text, VALUE * u) + 16 * u, 20 * u)
        if self._deviates(robot.correct, robot.heard):
            box(self.picture, pill, palette.WARNING_FILL, 6 * u, palette.WARNING)
            self._write(text, column, y, VALUE, palette.WARNING)
        else:
            box(self.picture, pill, self.colour, 6 * u)
            self._write(text, column, y, VALUE, palette.CARD)

    def _vector(self, left: float, right: float, y: float) -> None:
        """The state vector (4.3), one attribute per line."""
        self._write("STATE VECTOR", left, y, HEADING, palette.MUTED)
        for attribute, value in _attributes(self.robot.vector):
            y += 17 * self.u
            self._write(attribute, left, y, LABEL, palette.MUTED)
            self._write(value, right, y, LABEL, palette.INK, "right")

    def _infra_red(self, left: float, right: float, y: float, bottom: float) -> None:
        """Eight bars over the whole height, with the robot's own sensor numbers."""
        u = self.u
        self._write("INFRA-RED", left, y, HEADING, palette.MUTED)
        pitch = (right - left) / 8
        top, base = y + 23 * u, bottom - 12 * u
        for number, reading in enumerate(self.robot.proximity[:8]):
            x = left + number * pitch
            full = (base - top) * clamped(reading / MAX_READING)
            box(self.picture, (x + 3 * u, top, pitch - 6 * u, base - top), palette.TRACK)
            box(self.picture, (x + 3 * u, base - full, pitch - 6 * u, full), palette.INFRA_RED)
            self._write(str(round(reading)), x + pitch / 2, top - 7 * u, TINY, palette.INK, "centre")
            self._write(str(number), x + pitch / 2, base + 8 * u, SMALL, palette.MUTED, "centre")

    def _behaviours(self, left: float, right: float, y: float, bottom: float) -> None:
        """All ten behaviours: marks for the state's own, the heard and the executed one, and confidence levels."""
        robot, u = self.robot, self.u
        self._write("BEHAVIOUR", left, y, HEADING, palette.MUTED)
        if robot.confidence is not None:
            self._write("confidence", right, y, HEADING, palette.MUTED, "right")
        fill = palette.WARNING if self._deviates(robot.correct, robot.heard) else self.colour
        pitch = (bottom - y - 8 * u) / NUM_BEHAVIOURS
        for behaviour in tuple(Behaviour)[:NUM_BEHAVIOURS]:
            middle = y + 8 * u + (behaviour + 0.5) * pitch
            text, ink = sentence_case(behaviour.name), palette.INK
            pill = (left + 9 * u, middle - 7.5 * u, text_width(text, 16 * u) + 10 * u, 15 * u)
            if behaviour == robot.executed:
                ink = palette.CARD
                box(self.picture, pill, fill, 5 * u)
            elif behaviour == robot.heard:
                box(self.picture, pill, palette.CARD, 5 * u, palette.INK)
            if robot.state is not None and behaviour == behaviour_for(robot.state):
                dot(self.picture, left + 3 * u, middle, 3 * u, palette.INK)
            self._write(text, left + 14 * u, middle, 16, ink)
            if robot.confidence is not None and behaviour < len(robot.confidence):
                share = clamped(robot.confidence[behaviour])
                self._bar(right - 74 * u, middle - 4 * u, 41 * u, 8 * u, share, self.colour)
                share_ink = palette.INK if share > 0 else palette.MUTED
                self._write(f"{share:.0%}", right, middle, SMALL, share_ink, "right")

    def _turret(self, left: float, right: float, y: float) -> None:
        """Arm, jaw and optical barrier."""
        robot, u = self.robot, self.u
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
            self._bar(x, y + 9 * u, width, 6 * u, clamped(share), colour)

    def _bar(self, x: float, y: float, width: float, height: float, share: float, colour: Colour) -> None:
        """A bar from the left, filled to a share of its width."""
        box(self.picture, (x, y, width, height), palette.TRACK)
        box(self.picture, (x, y, width * share, height), colour)

    def _rule(self, left: float, right: float, y: float) -> None:
        box(self.picture, (left, y, right - left, 1), palette.EDGE)

    def _write(
        self, text: str, x: float, y: float, size: float, colour: Colour = palette.INK, anchor: Anchor = "left"
    ) -> None:
        write(self.picture, text, x, y, size * self.u, colour, anchor)


def _attributes(vector: StateVector | None) -> tuple[tuple[str, str], ...]:
    """The names and values of a state vector as text."""
    names = ("ObjectPresence", "RobotHomeDistance", "FoodType", "ArmsHeight", "RobotFoodDistance")
    if vector is None:
        return tuple((name, "–") for name in names)
    known = vector.food_type in tuple(FoodType)
    values = (
        "true" if vector.object_presence else "false",
        f"{vector.robot_home_distance} px",
        sentence_case(FoodType(vector.food_type).name) if known else str(vector.food_type),
        str(vector.arms_height),
        f"{vector.robot_food_distance} px",
    )
    return tuple(zip(names, values, strict=True))
