"""How a block of worlds lies in memory: one row of `LANES` numbers for each quantity, one lane for each world.

A block is one flat array with rows of a length fixed at compile time: the compiler then sees that rows do not overlap,
and works on several worlds with one instruction. Row r of lane i is at `r * LANES + i`; row r of food k is at
`(k * FOOD_ROWS + r) * LANES + i`. Everything is a float64, flags are 0 or 1. Millimetres, radians, seconds.
"""

LANES = 128
"""Worlds in a block."""

# Where the robot is, and what its gripper does.
X, Y, HEADING, COS, SIN, ARM, JAW = range(7)
HELD = 7
"""Number of the food between the closed fingers, -1 without."""
GRIP_X, GRIP_Y = 8, 9
"""Where that is in the robot's frame."""
BIAS_LEFT, BIAS_RIGHT = 10, 11
PULSES_LEFT, PULSES_RIGHT = 12, 13
# What it was told, as applied.
LEFT, RIGHT, ARM_TO, JAW_TO = 14, 15, 16, 17
# What it senses: whole numbers.
PRESENT, ARM_READ, JAW_READ = 18, 19, 20
PROXIMITY = 21
"""The first of eight."""
# The robot's own region in the camera's scene: pixels and whole degrees; and whether the marker is under a loss.
OWN_X, OWN_Y, OWN_DEGREES, OWN_FOUND, OWN_LOST = 29, 30, 31, 32, 33
NEXT_LABEL = 34
"""Label of the next new track."""
GHOSTS = 35
"""How many tracks show no food any more."""
NEW = 36
"""Whether the coming frame is the first after a reset."""
LAST_FORWARD, LAST_TURN = 37, 38
"""How the robot moved at the end of the last round."""
ROBOT_ROWS = 39

# What is needed within a round alone: one block of these rows serves all blocks that a thread works on.
FORWARD, TURN, TRAVEL = 0, 1, 2
"""How the robot is to move in this round, per second, and how far any part of it can get, mm."""
FREE_X, FREE_Y, FREE_HEADING, FREE_COS, FREE_SIN, FREE_JAW = range(3, 9)
"""Where that would bring it if nothing resisted."""
TOUCHES = 9
"""Whether it touches something on the way."""
NEAR_WALL, NEAR_FOOD = 10, 11
"""Whether anything of the robot could touch a wall, or food, in this round."""
LAG = 12
"""Share of the round in which the robot still moves as in the last one."""
MARK = 13
"""Free for use within a pass."""
SCRATCH = 14
"""The first of seventeen, free for use within a pass, too: one, and one for each food object there may be."""
WORK_ROWS = 31

# A food object: where it is, and whether the camera's tracker is missing it.
FOOD_X, FOOD_Y, LOST = 0, 1, 2
# What this round's frame shows of it, in pixels.
SEEN, SEEN_X, SEEN_Y = 3, 4, 5
# The track that shows it or showed it last: label (-1 without), place in pixels, tracked or lost, and a number that
# whoever watches the tracks may note beside it: it stays with the track, and is -1 for a new one.
TRACK, TRACK_X, TRACK_Y, TRACK_FOUND, NOTE = 6, 7, 8, 9, 10
# A further lost track, as many as foods in a world: where something was that the camera now shows as another track.
GHOST, GHOST_X, GHOST_Y, GHOST_NOTE = 11, 12, 13, 14
FOOD_ROWS = 15

# Random numbers of a world: its key, and how many rounds it has seen.
KEY, ROUND = 0, 1
KEY_ROWS = 2

# Which random number of a round is whose: a round has `DRAWS` of them.
DRAWS = 128
DRAW_WHEELS, DRAW_PROXIMITY, DRAW_MARKER, DRAW_POLICY = 0, 3, 7, 12
DRAW_FOOD = 16
"""The first food's; each has `FOOD_DRAWS`."""
FOOD_DRAWS = 4
MOST_FOODS = 16
