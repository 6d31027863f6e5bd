"""The contracts of `Robot`, `Camera` and `World`.

There is one suite of tests for each contract, for every implementation.

A module that tests an implementation defines a fixture `stage` (a world after a reset, with one robot on open floor and
one food object well away from it), and subclasses the suites.
"""

import math
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pytest

from khepera_forage.robots.khepera import MAX_SPEED, Motors, Robot, Senses
from khepera_forage.sim.arena import Pose
from khepera_forage.sim.world import Layout, World
from khepera_forage.vision.scene import Camera, Region, Scene

STILL = Motors(0, 0, 215, 200)


class Stage(NamedTuple):
    """A world, where everything stood at its reset, and a world with the true places."""

    world: World
    layout: Layout
    truth: World

    @property
    def robot(self) -> Robot:
        return self.world.robots[0]

    @property
    def camera(self) -> Camera:
        return self.world.camera

    def rounds(self, count: int, motors: Motors) -> None:
        """Advance some rounds under one command."""
        self.robot.drive(motors)
        for _ in range(count):
            self.world.advance()


class RobotContract:
    """`Robot`: sense, drive, stop, close."""

    def test_senses_are_in_range(self, stage: Stage) -> None:
        for motors in (STILL, Motors(8, -8, 255, 0), Motors(-5, 5, 215, 200)):
            stage.rounds(12, motors)
            senses = stage.robot.sense()
            assert isinstance(senses, Senses)
            assert len(senses.proximity) == 8
            assert all(type(value) is int and 0 <= value <= 1023 for value in senses.proximity)
            assert 215 <= senses.arm <= 255
            assert 0 <= senses.jaw <= 200
            assert senses.object_presence in (0, 255)

    def test_second_sense_in_a_round_returns_the_same(self, stage: Stage) -> None:
        stage.rounds(5, Motors(6, -4, 255, 0))
        senses = stage.robot.sense()
        assert stage.robot.sense() == senses
        stage.robot.drive(STILL)
        assert stage.robot.sense() == senses, "a command takes effect with the next round"

    def test_applied_motors_are_whole_and_within_limits(self, stage: Stage) -> None:
        for motors, applied in (
            (Motors(1e300, -1e300, 10**6, -5), Motors(MAX_SPEED, -MAX_SPEED, 255, 0)),
            (Motors(7.6, -7.4, 0, 300), Motors(8, -7, 215, 200)),
            (Motors(-0.4, 0.4, 230, 101), Motors(0, 0, 230, 200)),
            (Motors(0, 0, 230, 100), Motors(0, 0, 230, 0)),
        ):
            assert stage.robot.drive(motors) == applied

    def test_values_that_are_not_finite_are_refused(self, stage: Stage) -> None:
        for field, value in product(Motors._fields, (math.nan, -math.inf)):
            changed: Any = {field: value}
            with pytest.raises(ValueError, match=f"{field}={value}.*finite"):
                stage.robot.drive(STILL._replace(**changed))

    def test_wheels_turn_what_the_encoders_count(self, stage: Stage) -> None:
        before = stage.robot.sense()
        stage.rounds(10, Motors(5, 5, 215, 200))
        after = stage.robot.sense()
        for moved in (after.left_pulses - before.left_pulses, after.right_pulses - before.right_pulses):
            assert abs(moved - 500) <= 60, "10 pulses a round and speed unit"

    def test_arm_and_jaw_arrive(self, stage: Stage) -> None:
        stage.rounds(25, Motors(0, 0, 255, 0))
        assert (stage.robot.sense().arm, stage.robot.sense().jaw) == (255, 0)
        stage.rounds(25, STILL)
        assert (stage.robot.sense().arm, stage.robot.sense().jaw) == (215, 200)


class CameraContract:
    """`Camera`: look."""

    distance = angle = 10.0
    """By which regions may be away from the true places, mm and degrees."""

    def test_regions_are_at_the_true_places(self, stage: Stage) -> None:
        stage.rounds(20, Motors(6, 4, 215, 200))
        stage.rounds(2, STILL)
        regions = stage.camera.look().regions
        assert sorted(region.holes > 0 for region in regions) == [False, True]
        for region in regions:
            there = stage.truth.poses()[0] if region.holes else stage.truth.food_places()[0]
            assert math.dist((region.x * 5, region.y * 5), there[:2]) < self.distance
            if region.holes:
                turned = math.remainder(region.orientation - math.degrees(there[2]), 180)
                assert abs(turned) < self.angle

    def test_second_look_in_a_round_returns_the_same(self, stage: Stage) -> None:
        assert stage.camera.look() == stage.camera.look()

    def test_regions_are_well_formed_and_labels_are_kept(self, stage: Stage) -> None:
        stage.robot.drive(Motors(6, 4, 215, 200))
        holes: dict[int, int] = {}
        for _ in range(40):
            stage.world.advance()
            scene = stage.camera.look()
            assert isinstance(scene, Scene)
            labels = [region.label for region in scene.regions]
            assert labels == sorted(set(labels)), "oldest track first"
            for region in scene.regions:
                assert isinstance(region, Region)
                assert region.holes in (0, 1, 2)
                assert holes.setdefault(region.label, region.holes) == region.holes
                assert 0 <= region.orientation < 360
                assert 0 <= region.x <= 640
                assert 0 <= region.y <= 480
                assert abs(region.compactness * region.area / region.perimeter**2 - 1) < 1e-6

    def test_labels_are_never_reused(self, stage: Stage) -> None:
        """Food is carried away under the marker, so that its place is seen empty, and is set down elsewhere."""
        old = {region.label for region in stage.camera.look().regions}
        x, y = stage.layout.foods[0]
        stage.world.place(0, Pose(x - 57, y, 0.0))
        stage.rounds(12, Motors(0, 0, 255, 200))
        stage.rounds(8, Motors(0, 0, 255, 0))
        stage.rounds(12, Motors(0, 0, 215, 0))
        stage.rounds(25, Motors(-8, -8, 215, 0))
        assert not [region for region in stage.camera.look().regions if not region.holes], "dropped"
        stage.rounds(12, Motors(0, 0, 255, 0))
        stage.rounds(8, Motors(0, 0, 255, 200))
        stage.rounds(20, Motors(-6, -6, 255, 200))
        (food,) = [region for region in stage.camera.look().regions if not region.holes]
        assert food.label > max(old)
        assert math.dist((food.x * 5, food.y * 5), stage.world.food_places()[0][:2]) < 10


class WorldContract:
    """`World`: reset, advance, robots, camera, place, stop, close."""

    def test_reset_puts_robots_and_food_at_the_places_of_the_layout(self, stage: Stage) -> None:
        for _ in range(2):
            assert len(stage.world.robots) == len(stage.layout.starts) == len(stage.world.poses())
            assert len(stage.world.food_places()) == len(stage.layout.foods)
            assert math.dist(stage.world.poses()[0][:2], stage.layout.starts[0][:2]) < 10
            assert math.dist(stage.world.food_places()[0][:2], stage.layout.foods[0]) < 10
            stage.rounds(10, Motors(8, 8, 255, 0))
            stage.world.reset(np.random.default_rng(0), stage.layout)

    @pytest.mark.parametrize("stopped", ["robot", "world"])
    def test_stop_stops_the_wheels_until_the_next_command_and_leaves_the_gripper(
        self, stage: Stage, stopped: str
    ) -> None:
        stage.rounds(20, Motors(5, 5, 255, 0))
        getattr(stage, stopped).stop()
        before, place = stage.robot.sense(), stage.world.poses()[0]
        for _ in range(5):
            stage.world.advance()
        after = stage.robot.sense()
        assert after[1:5] == (before.left_pulses, before.right_pulses, 255, 0)
        assert math.dist(stage.world.poses()[0][:2], place[:2]) < 3.0
        stage.rounds(1, Motors(8, 8, 215, 200))
        assert stage.robot.sense()[1:3] != after[1:3]

    def test_command_takes_effect_at_the_next_advance(self, stage: Stage) -> None:
        assert stage.world.round_duration == 0.1
        before = stage.world.poses()[0]
        stage.robot.drive(Motors(10, 10, 215, 200))
        assert stage.world.poses()[0] == before
        for _ in range(5):
            stage.world.advance()
        after = stage.world.poses()[0]
        assert 25 < math.dist(after[:2], before[:2]) < 50

    def test_place_moves_the_robot_to_a_pose(self, stage: Stage) -> None:
        x, y, heading = stage.layout.starts[0]
        stage.world.place(0, Pose(x + 50, y, heading + 1.0))
        stage.world.advance()
        pose = stage.world.poses()[0]
        assert math.dist(pose[:2], (x + 50, y)) < 10
        assert abs(pose.heading - heading - 1.0) < 0.1

    def test_place_refuses_poses_off_the_free_floor(self, stage: Stage) -> None:
        x1, y1, _, _ = stage.world.arenas[0].bounds
        before = stage.world.poses()
        for pose in (Pose(x1 + 5, y1 + 5, 0.0), Pose(x1 - 500, y1, 0.0)):
            with pytest.raises(ValueError, match=f"{pose.x:g}"):
                stage.world.place(0, pose)
        assert stage.world.poses() == before

    def test_reset_refuses_another_number_of_starts(self, stage: Stage) -> None:
        starts = stage.layout.starts
        for wrong in ((), (*starts, starts[0])):
            with pytest.raises(ValueError, match=f"{len(wrong)} starts"):
                stage.world.reset(np.random.default_rng(0), stage.layout._replace(starts=wrong))

    def test_second_close_does_nothing(self, stage: Stage) -> None:
        for closed in (stage.robot, stage.robot, stage.world, stage.world):
            closed.close()
