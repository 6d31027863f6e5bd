"""Colours of the pictures. The colours of food are from the Okabe-Ito palette, made for colour-blind readers."""

from khepera_forage.task.states import FoodType

Colour = tuple[int, int, int]

BACKGROUND: Colour = (244, 246, 249)
CARD: Colour = (255, 255, 255)  # background of panels and keys; symbols and text on dark colours
EDGE: Colour = (218, 223, 230)  # outlines of cards, dividers
TRACK: Colour = (233, 237, 242)  # empty part of a bar
INK: Colour = (31, 41, 55)  # main text
MUTED: Colour = (110, 120, 135)  # labels and secondary text

FLOOR: Colour = (228, 233, 239)
WALL: Colour = (71, 82, 99)
HOME: Colour = (245, 231, 196)
HOME_EDGE: Colour = (206, 170, 96)

BODY: Colour = (55, 65, 81)
WHEEL: Colour = (17, 24, 39)
LOWERED: Colour = (31, 41, 55)  # a lowered gripper
RAISED: Colour = (250, 250, 252)  # a raised gripper
SHADOW: Colour = (186, 193, 204)
MARKER: Colour = (255, 255, 255)
INFRA_RED: Colour = (213, 94, 0)

FOUND: Colour = (0, 128, 138)  # a region that is tracked
LOST: Colour = (204, 32, 48)  # a region that is lost
LOST_FILL: Colour = (253, 228, 230)
OBJECT_PRESENT: Colour = (240, 176, 0)  # an object is in the optical barrier
WARNING: Colour = (180, 83, 9)
WARNING_FILL: Colour = (254, 240, 205)

TEACHER: Colour = (0, 114, 178)
LEARNERS: tuple[Colour, ...] = ((170, 68, 153), (102, 82, 176), (136, 34, 85), (122, 92, 58))

FOOD: dict[FoodType, Colour] = {
    FoodType.UNKNOWN: (255, 255, 255),  # as in the thesis, where all food is wrapped in white paper (3.1)
    FoodType.PICKABLE: (0, 158, 115),
    FoodType.PUSHABLE: (86, 180, 233),
    FoodType.POISONOUS: (213, 94, 0),
}


def blended(a: Colour, b: Colour, share: float) -> Colour:
    """A mixture of two colours; `share` 0..1 is that of `b`."""
    return (
        round(a[0] + (b[0] - a[0]) * share),
        round(a[1] + (b[1] - a[1]) * share),
        round(a[2] + (b[2] - a[2]) * share),
    )
