"""What robots sense and what the overhead camera shows at the end of a round. Plain functions, also compiled.

A robot senses its optical barrier, arm, jaw, and the eight infra-reds; `robots.proximity` says where their response
comes from. The camera turns true poses into regions, with the troubles of sections 3.5 and 3.7.

The picture is 640 x 480 pixels of 5 mm, its lower left corner at (0, 0) mm. A frame is taken once a round.

- *Jitter.* A region's centre is off by a normal error in x and in y, a marker's orientation by one in degrees; it is
  then rounded to whole degrees. First pixel and edge flag follow the reported centre; area, perimeter and compactness
  are those of the whole shape.
- *Reversal.* Now and then, in single frames, an orientation is reported the wrong way round (4.2.2).
- *Losses.* Now and then the tracker does not see a region for a while: a two-hole marker more often than a one-hole
  one (3.5), any region more often under a cable (3.7). How long is geometrically distributed. Nothing is lost in the
  first frame after a reset: an operator starts when everything is tracked.
- *Cables.* Each robot's cable is a straight line from the overhead anchor to the middle of its own marker, which it
  does not disturb. It lies over food when it passes over the disc, and over the marker of another robot in its arena
  when it passes within half the marker's width of its centre.
- *Hiding.* Food whose disc touches a marker is not seen, whether or not that marker is itself lost; the markers of
  robots without a gripper are no larger than these, and hide none. A region whose
  centre is outside the picture is not seen.

Each robot has a track of its own, which never ends. Food becomes tracks by the rule of `vision.association`. A place
is visible to that rule when food lying there would be clear of every marker by five standard deviations of the jitter
(no last place is known better: with less, food just gone under the rim of a marker is taken for vanished) and would not
touch food that is under a loss (whatever hides that also hides the floor around it).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from khepera_forage.counter_rng import (
    DRAW_FOOD,
    DRAW_MARKER,
    DRAW_PROXIMITY,
    FOOD_DRAWS,
    draw,
    lower,
    normal,
    random_bits,
    upper,
)
from khepera_forage.geometry.plane import cosine_sine, is_near
from khepera_forage.noise import Noise
from khepera_forage.records import in_python
from khepera_forage.robots.khepera import ARM_DOWN, ARM_ON_FLOOR, FOOD_RADIUS, JAW_OPEN, MARKER_WIDTH, PRESENT, RADIUS
from khepera_forage.robots.proximity import (
    HIDDEN_BY_ARM,
    MAX_READING,
    RANGE,
    REACH,
    RESPONSE_AT_RANGE,
    RESPONSE_GAIN,
    RESPONSE_OFFSET,
)
from khepera_forage.sim.driving import grip_place, in_barrier, is_lifted, put_down, seen_from
from khepera_forage.sim.records import Enclosure, FoodDetection, FoodState, RobotState
from khepera_forage.vision.association import Track, match, may_vanish, start_tracks
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene, Truth
from khepera_forage.vision.shapes import (
    FOOD_FEATURES,
    FOOD_RADIUS_PX,
    MARKER_FEATURES,
    PICTURE_HEIGHT,
    PICTURE_WIDTH,
    Plate,
    in_picture,
    marker_outline,
    touches_plate,
)

_SMOOTHING = 9
"""Number of the bits that smooth the error of a marker's heading; their key are the 64 random bits of that error."""
_FRONT = 6
"""Sensors that a lowered arm hides."""
_SURE = 5.0
"""Standard deviations of jitter by which a place must be clear of a marker to count as visible."""
_HIDDEN_LOW, _HIDDEN_VALUES = float(HIDDEN_BY_ARM[0]), float(HIDDEN_BY_ARM[1] - HIDDEN_BY_ARM[0] + 1)


def begin(enclosure: Enclosure, constants: Any) -> None:
    """Begin an episode: robots stand at their poses, at rest, and nothing is tracked."""
    for i in range(len(enclosure.robots)):
        put_down(enclosure.robots[i], constants)
    forget_tracks(enclosure.foods, enclosure.tracks)


def sense_all(enclosure: Enclosure, constants: Any) -> None:
    """What the robots of an arena sense, once food in their grippers has moved along."""
    for i in range(len(enclosure.robots)):
        robot = enclosure.robots[i]
        if robot.held >= 0:
            enclosure.foods[robot.held].x, enclosure.foods[robot.held].y = grip_place(robot)
    for i in range(len(enclosure.robots)):
        sense(enclosure.robots, i, enclosure.foods, enclosure.walls, constants)


def sense(robots: Any, i: int, foods: Any, walls: Any, constants: Any) -> None:
    """Read all sensors of robot `i`. Arguments as in `sim.driving`."""
    robot = robots[i]
    senses = robot.senses
    senses.left_pulses, senses.right_pulses = int(robot.left_pulses), int(robot.right_pulses)
    if robot.has_gripper:
        _sense_gripper(robot, foods)
    else:
        _sense_food_ahead(robot, foods, constants.reach)
    for sensor in range(8):
        robot.response[sensor] = 0.0
    first = _FRONT if robot.arm >= ARM_ON_FLOOR else 0
    for k in range(len(walls)):
        wall = walls[k]
        if is_near(robot.x, robot.y, wall, REACH):
            _see_wall(robot, wall, first, constants.sensors)
    for k in range(len(foods)):
        dx, dy = foods[k].x - robot.x, foods[k].y - robot.y
        if dx * dx + dy * dy < (REACH + FOOD_RADIUS) ** 2 and not is_lifted(robots, k):
            _see_disc(robot, foods[k].x, foods[k].y, FOOD_RADIUS, first, constants.sensors)
    for j in range(len(robots)):
        dx, dy = robots[j].x - robot.x, robots[j].y - robot.y
        if j != i and dx * dx + dy * dy < (REACH + RADIUS) ** 2:
            _see_disc(robot, robots[j].x, robots[j].y, RADIUS, first, constants.sensors)
    for pair in range(4):
        bits = draw(robot, DRAW_PROXIMITY + pair)
        one, other = 2 * pair, 2 * pair + 1
        senses.proximity[one] = _measured(robot, one, one < first, constants.noise, upper(bits))
        senses.proximity[other] = _measured(robot, other, one < first, constants.noise, lower(bits))


def _sense_gripper(robot: Any, foods: Any) -> None:
    senses = robot.senses
    senses.object_presence = 0
    raised = (1.0 + robot.arm_reading_error) * (ARM_DOWN - robot.arm)
    senses.arm, senses.jaw = math.floor(ARM_DOWN - raised + 0.5), math.floor(robot.jaw + 0.5)
    for k in range(len(foods)):
        if robot.held == k or (robot.held < 0 and robot.arm >= ARM_ON_FLOOR):
            u, v = seen_from(robot, foods[k].x, foods[k].y)
            if in_barrier(u, v, robot.jaw):
                senses.object_presence = PRESENT


def _sense_food_ahead(robot: Any, foods: Any, reach: float) -> None:
    """What stands for the readings of a gripper: an object is present while food lies before the robot."""
    robot.senses.object_presence, robot.senses.arm, robot.senses.jaw = 0, ARM_DOWN, JAW_OPEN
    for k in range(len(foods)):
        ahead, aside = seen_from(robot, foods[k].x, foods[k].y)
        if 0.0 < ahead <= reach and abs(aside) <= FOOD_RADIUS:
            robot.senses.object_presence = PRESENT


def _see_wall(robot: Any, wall: Any, first: int, sensors: Any) -> None:
    """Keep the readings of a wall that are the largest; `first` is the first sensor that is not hidden."""
    cos, sin = robot.cos, robot.sin
    dx, dy = wall.x1 - robot.x, wall.y1 - robot.y
    ahead, aside = dx * cos + dy * sin, dy * cos - dx * sin
    along, across = wall.ex * cos + wall.ey * sin, wall.ey * cos - wall.ex * sin
    for sensor in range(first, 8):
        dx, dy = ahead - sensors[4 * sensor], aside - sensors[4 * sensor + 1]
        t = min(1.0, max(0.0, -(dx * along + dy * across) * wall.share))
        _keep_largest(robot, sensor, dx + t * along, dy + t * across, 0.0, sensors)


def _see_disc(robot: Any, x: float, y: float, radius: float, first: int, sensors: Any) -> None:
    """Keep the readings of food or another robot that are the largest; `first` as for `_see_wall`."""
    ahead, aside = seen_from(robot, x, y)
    for sensor in range(first, 8):
        dx, dy = ahead - sensors[4 * sensor], aside - sensors[4 * sensor + 1]
        _keep_largest(robot, sensor, dx, dy, radius, sensors)


def _keep_largest(robot: Any, sensor: int, dx: float, dy: float, radius: float, sensors: Any) -> None:
    """Keep the reading of an obstacle (dx, dy) mm from a sensor, if it is the largest (see `robots.proximity`)."""
    along = dx * sensors[4 * sensor + 2] + dy * sensors[4 * sensor + 3]
    if along <= 0.0:
        return
    distance = math.sqrt(dx * dx + dy * dy)
    if distance - radius >= RANGE or 2.0 * along <= distance:
        return
    near = max(distance - radius, 0.0) + RESPONSE_OFFSET
    # One division gives both 1 / near ** 2 and along / distance.
    inverse = 1.0 / (near * near * distance)
    response = min(float(MAX_READING), RESPONSE_GAIN * (inverse * distance - RESPONSE_AT_RANGE))
    reading = response * (2.0 * along * (inverse * near * near) - 1.0)
    robot.response[sensor] = max(robot.response[sensor], reading)


def _measured(robot: Any, sensor: int, hidden: bool, noise: Any, uniform: float) -> int:
    """The reading of a sensor as a robot reports it: a whole number with noise."""
    if hidden:
        return math.floor(_HIDDEN_LOW + _HIDDEN_VALUES * (uniform if noise.proximity_gain > 0.0 else 0.5))
    clean = robot.response[sensor] * (1.0 + robot.infra_red_error)
    reading = min(clean * (1.0 + noise.proximity_gain * (2.0 * uniform - 1.0)), float(MAX_READING))
    floor = noise.proximity_floor
    if reading <= floor and floor > 0.0:
        reading = (floor + 1.0) * uniform
    return math.floor(float(reading))


def look(enclosure: Enclosure, anchor_x: float, anchor_y: float, noise: Any) -> None:
    """Take one frame, in which the first time after a reset nothing is lost, and continue the tracks.

    The robots' cables hang from the anchor, a place in mm.
    """
    robots, foods, tracks, detections = enclosure.robots, enclosure.foods, enclosure.tracks, enclosure.detections
    first_frame = robots[0].first_frame  # which looking at its marker ends
    for i in range(len(robots)):
        _look_at_marker(robots, i, anchor_x, anchor_y, noise)
    count = 0
    for k in range(len(foods)):
        if _look_at_food(robots, foods[k], k, detections[count], anchor_x, anchor_y, first_frame, noise):
            count += 1
    new = match(tracks, detections, count, False)
    clearance = FOOD_RADIUS + _SURE * noise.position_jitter * MM_PER_PIXEL
    for k in range(len(tracks)):
        if may_vanish(tracks[k], False) and _is_visible(robots, foods, tracks[k], clearance):
            tracks[k].label = -1
    if new:
        robots[0].next_label = start_tracks(tracks, detections, count, robots[0].next_label)


def forget_tracks(foods: Any, tracks: Any) -> None:
    """Begin with nothing tracked and nothing lost."""
    for k in range(len(foods)):
        foods[k].lost = False
    for k in range(len(tracks)):
        track = tracks[k]
        track.label = track.detection = -1
        track.x = track.y = 0.0
        track.holes = 0
        track.found = False


def _is_lost(lost: bool, chance: float, rate: float, loss_rounds: float) -> bool:
    """Whether the tracker does not see a region in this frame: losses begin at a rate and last some rounds."""
    return chance >= 1.0 / loss_rounds if lost else chance < rate


def _look_at_marker(robots: Any, i: int, anchor_x: float, anchor_y: float, noise: Any) -> None:
    """What this frame shows of a robot's marker."""
    robot = robots[i]
    jitter, chances = noise.position_jitter, draw(robot, DRAW_MARKER + 4)
    smoothing = draw(robot, DRAW_MARKER + 2)
    x = robot.x / MM_PER_PIXEL + jitter * normal(draw(robot, DRAW_MARKER), smoothing)
    y = robot.y / MM_PER_PIXEL + jitter * normal(draw(robot, DRAW_MARKER + 1), smoothing >> 32)
    rate = noise.loss_rate_one_hole if robot.holes == 1 else noise.loss_rate_two_holes
    chance = upper(chances)
    # A robot's own cable never disturbs its marker (3.7).
    if not robot.marker_lost and rate <= chance < rate * noise.cable_loss_factor:
        for j in range(len(robots)):
            if j != i and _is_under_cable(robot, MARKER_WIDTH / 2, robots[j], anchor_x, anchor_y):
                rate = rate * noise.cable_loss_factor
                break
    lost = _is_lost(robot.marker_lost, chance, rate, noise.loss_rounds)
    robot.marker_lost = lost and not robot.first_frame
    robot.marker_found = not robot.marker_lost and 0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT
    robot.first_frame = False
    if not robot.marker_found:
        return
    turn = draw(robot, DRAW_MARKER + 3)
    degrees = robot.heading * (180.0 / math.pi)
    degrees += noise.heading_jitter * normal(turn, random_bits(turn, _SMOOTHING))
    degrees = math.floor(degrees + (180.5 if lower(chances) < noise.reversal_rate else 0.5))
    robot.marker_x, robot.marker_y = x, y
    robot.marker_heading = float(degrees % 360)


def _look_at_food(
    robots: Any, food: Any, k: int, detection: Any, anchor_x: float, anchor_y: float, first_frame: bool, noise: Any
) -> bool:
    """What this frame shows of food object `k`; returns whether it is seen, and then writes the detection."""
    robot, jitter, number = robots[0], noise.position_jitter, DRAW_FOOD + k * FOOD_DRAWS
    chance, rate = upper(draw(robot, number + 3)), noise.loss_rate_food
    # A cable makes a loss likelier: so seldom that only then cables are looked at.
    if not food.lost and rate <= chance < rate * noise.cable_loss_factor:
        for i in range(len(robots)):
            if _is_under_cable(food, FOOD_RADIUS, robots[i], anchor_x, anchor_y):
                rate = rate * noise.cable_loss_factor
                break
    food.lost = _is_lost(food.lost, chance, rate, noise.loss_rounds) and not first_frame
    if food.lost or _is_hidden(robots, food.x, food.y, FOOD_RADIUS):
        return False
    smoothing = draw(robot, number + 2)
    x = food.x / MM_PER_PIXEL + jitter * normal(draw(robot, number), smoothing)
    y = food.y / MM_PER_PIXEL + jitter * normal(draw(robot, number + 1), smoothing >> 32)
    detection.x = detection.first_x = x
    detection.y, detection.first_y = y, y + FOOD_RADIUS_PX
    detection.holes = 0
    return bool(0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT)


def _is_under_cable(what: Any, radius: float, robot: Any, anchor_x: float, anchor_y: float) -> bool:
    """Whether a robot's cable passes within a radius of something: a straight line from the anchor to its marker."""
    to_x, to_y = robot.x - anchor_x, robot.y - anchor_y
    dx, dy = what.x - anchor_x, what.y - anchor_y
    t = min(1.0, max(0.0, (dx * to_x + dy * to_y) / max(to_x * to_x + to_y * to_y, 1e-9)))
    dx, dy = dx - t * to_x, dy - t * to_y
    return bool(dx * dx + dy * dy <= radius * radius)


def _is_hidden(robots: Any, x: float, y: float, radius: float) -> bool:
    """Whether a disc on the floor touches the marker of any robot."""
    for i in range(len(robots)):
        robot = robots[i]
        if robot.has_gripper and touches_plate(x, y, radius, Plate(robot.x, robot.y, robot.cos, robot.sin)):
            return True
    return False


def _is_visible(robots: Any, foods: Any, track: Any, clearance: float) -> bool:
    """Whether food at the last place of a track would have shown in this frame."""
    x, y = track.x * MM_PER_PIXEL, track.y * MM_PER_PIXEL
    for k in range(len(foods)):
        # Whatever hides a food object also hides the floor around it.
        dx, dy = x - foods[k].x, y - foods[k].y
        if foods[k].lost and dx * dx + dy * dy <= 4 * FOOD_RADIUS * FOOD_RADIUS:
            return False
    return not _is_hidden(robots, x, y, clearance)


class SimulatedCamera:
    """The `Camera` of a simulated world: the markers' regions come first, in the order of the robots; food follows.

    Args:
        robots: `RobotState` records.
        enclosures: What is in each arena.
    """

    def __init__(self, robots: Sequence[Any] = (), enclosures: Sequence[Enclosure] = ()) -> None:
        self._robots, self._enclosures = robots, enclosures

    def look(self) -> Scene:
        """The regions of the last frame; none before the first reset."""
        regions = [marker_region(i, in_python(robot)) for i, robot in enumerate(self._robots)]
        foods = []
        for number, enclosure in enumerate(self._enclosures):
            for track in map(in_python, enclosure.tracks):
                if track.label >= 0:
                    # Each arena numbers its own tracks.
                    label = len(self._robots) + int(track.label) * len(self._enclosures) + number
                    x, y = float(track.x), float(track.y)
                    edge = not in_picture(x, y, FOOD_RADIUS_PX, FOOD_RADIUS_PX)
                    first = x, y + FOOD_RADIUS_PX
                    foods.append(Region(label, x, y, 0, 0, bool(track.found), edge, *first, *FOOD_FEATURES))
        return Scene((*regions, *sorted(foods)))


class OverheadCamera(SimulatedCamera):
    """A camera of its own above what a world says is there.

    Args:
        truth: Called once a frame. The numbers of markers and foods stay the same between two resets; there is at least
            one marker.
        noise: Sizes and rates. With `Noise.none()` the scene is exact, but food is still hidden by markers, and
            orientations are still whole degrees.
        anchor: Where the cables hang from, in mm as seen from above; None hangs no cables.
    """

    def __init__(self, truth: Callable[[], Truth], noise: Noise, anchor: tuple[float, float] | None = None) -> None:
        super().__init__()
        self._truth, self._anchor = truth, anchor or (0.0, 0.0)
        self._noise = noise if anchor else replace(noise, cable_loss_factor=1.0)

    def reset(self, rng: np.random.Generator) -> None:
        """Forget all tracks and losses, and take the first frame; `rng` only spawns another."""
        key = int(rng.spawn(1)[0].integers(2**64, dtype=np.uint64))
        truth = self._truth()
        robots = [RobotState(key=key + i, holes=marker[3], first_frame=True) for i, marker in enumerate(truth.markers)]
        foods = [FoodState() for _ in truth.foods]
        tracks, detections = [Track() for _ in range(2 * len(foods))], [FoodDetection() for _ in foods]
        super().__init__(robots, [Enclosure(robots, foods, tracks, detections, (), ())])
        self.expose()

    def expose(self) -> None:
        """Take the frame of this round.

        Raises:
            RuntimeError: The camera was never reset.
        """
        if not self._enclosures:
            raise RuntimeError("expose() before any reset(rng); allowed: after one")
        truth, enclosure = self._truth(), self._enclosures[0]
        for robot, (x, y, heading, _) in zip(enclosure.robots, truth.markers, strict=True):
            robot.x, robot.y, robot.heading = x, y, heading
            robot.cos, robot.sin = cosine_sine(heading)
            robot.round += 1
        for food, place in zip(enclosure.foods, truth.foods, strict=True):
            food.x, food.y = place
        look(enclosure, *self._anchor, self._noise)


def marker_region(label: int, robot: Any) -> Region:
    """The region of a robot's marker, as last shown."""
    x, y, holes = float(robot.marker_x), float(robot.marker_y), int(robot.holes)
    heading, found = int(robot.marker_heading), bool(robot.marker_found)
    turned = math.radians(heading)
    half_width, half_height, first = marker_outline(math.cos(turned), math.sin(turned))
    edge = not in_picture(x, y, half_width, half_height)
    return Region(label, x, y, holes, heading, found, edge, x + first, y + half_height, *MARKER_FEATURES[holes])
