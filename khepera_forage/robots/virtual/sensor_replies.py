"""What the firmware of a virtual Khepera replies to the commands that read its sensors."""

from khepera_forage.robots.khepera import Senses

BARRIER_FREE, BARRIER_CROSSED = 0, 200
"""Readings of the optical barrier: 0 without an object (KNET, KH2PY, WSU-R), more than 100 with one (PYRO)."""
INSULATED, CONDUCTING = 0, 255
"""Replies to T,1,F. The only source is PYRO, which takes more than 20 for closed fingers and less for open ones: the
reading is high while a current flows from finger to finger. The food is of wood, so only closed, empty fingers conduct.
Assumption: the ends of the scale, and that PYRO's threshold is right; the text of K-Team's manual was not found."""
DARK = 500
"""Ambient light reading without a lamp (Khepera manual 3.1.7, by way of RN)."""
_FINGERS_TOUCH = 3
"""Jaw position up to which the fingers touch each other: 0 but for the noise of the position. Assumption."""


def proximity(senses: Senses) -> tuple[int, ...]:
    """Command N: the infra-red sensors."""
    return senses.proximity


def ambient_light(senses: Senses) -> tuple[int, ...]:
    """Command O: the same sensors without their own light."""
    return (DARK,) * len(senses.proximity)


def resistivity(senses: Senses) -> tuple[int]:
    """Command T,1,F: whether a current flows between the fingers."""
    return (CONDUCTING if senses.jaw <= _FINGERS_TOUCH else INSULATED,)


def barrier(senses: Senses) -> tuple[int]:
    """Command T,1,G: the optical barrier between the fingers."""
    return (BARRIER_CROSSED if senses.object_presence else BARRIER_FREE,)


def gripper_position(senses: Senses, arm: int) -> tuple[int]:
    """Command T,1,H.

    Args:
        senses: Of the robot.
        arm: 1 for the position of the arm, 0 for that of the jaw.
    """
    return (senses.arm if arm else senses.jaw,)
