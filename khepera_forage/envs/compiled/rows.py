"""How the task of a block of worlds lies in memory: rows as in `sim.compiled.rows`, beside the bodies'."""

# What the robot sensed when the round began.
BEFORE_PRESENT, BEFORE_ARM, BEFORE_JAW = range(3)
HELD = 3
"""Number of the food object that the register takes to be in the gripper, -1 without."""
DELIVERED, POISON_HOME, DELIVERABLE = 4, 5, 6
# Raw data beyond what the robot senses and where the camera sees it.
FOOD_SEEN, FOOD_X, FOOD_Y, FOOD_TYPE, WALL_DISTANCE, WALL_BEARING = range(7, 13)
# The state vector, and the state it stands for.
PRESENCE, HOME_DISTANCE, VECTOR_TYPE, VECTOR_ARM, FOOD_DISTANCE, STATE = range(13, 19)
VECTOR = PRESENCE
"""The first of the five."""
BEHAVIOUR = 19
"""What was decided on."""
STEPS, CORRECT = 20, 21
EPISODE = 22
"""Number of the episode that is under way, -1 when the lane has none left."""
REWARD, TERMINATED, TRUNCATED = 23, 24, 25
FRESH = 26
"""Whether the last frame was the first of its episode."""
HOME_WAY, HOME_BEARING, FOOD_WAY, FOOD_BEARING = 27, 28, 29, 30
"""Distances and bearings of the raw data, not rounded."""
TASK_ROWS = 31

# A food object, as the register knows it: where it is (pixels), its type as drawn, its type as far as it is known,
# whether it has been brought home, and whether it was in the gripper since it was last seen.
PLACE_X, PLACE_Y, TYPE, KNOWN, HOME, CARRIED = range(6)
SETTLED = 6
"""Whether the track that shows this food is no candidate for nearest food."""
TASK_FOOD_ROWS = 7
