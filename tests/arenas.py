"""Three different arenas, for tests of environments with a pool of them: convex, L-shaped, and with obstacles."""

from khepera_forage.sim.arena import Arena, Point, Pose


def corners(*places: tuple[float, float]) -> tuple[Point, ...]:
    return tuple(Point(x, y) for x, y in places)


HALL = Arena(
    "hall",
    corners((0, 0), (600, 0), (600, 450), (0, 450)),
    Point(500, 225),
    70.0,
    Pose(90, 225, 0.0),
    (Point(330, 225),),
)
L_ROOM = Arena(
    "L-room",
    corners((100, 50), (900, 50), (900, 350), (450, 350), (450, 800), (100, 800)),
    Point(790, 190),
    80.0,
    Pose(270, 680, -1.5),
    (Point(280, 400),),
)
BLOCKS = Arena(
    "blocks",
    corners((50, 100), (1150, 100), (1150, 800), (50, 800)),
    Point(1000, 450),
    90.0,
    Pose(180, 450, 0.0),
    (Point(350, 250),),
    (corners((500, 330), (600, 330), (600, 430), (500, 430)), corners((700, 520), (780, 520), (740, 600))),
)
POOL = (HALL, L_ROOM, BLOCKS)
