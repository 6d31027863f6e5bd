"""The decisions of earlier versions, value by value.

Files, rows and environment ids name a version, so the values of a version never change. The present version has the
defaults of `Decisions`; before a next version changes them, this module must keep them under their present name.
"""

from collections.abc import Mapping
from typing import Any

CURRENT = "v1"
"""Name of the default decisions."""

V0_1: Mapping[str, Any] = {
    "round_duration": 0.1,
    "arm_travel_time": 1.0,
    "jaw_travel_time": 0.6,
    "start_to_wall": 90.0,
    "food_to_home": 180.0,
    "home_to_wall": 100.0,
    "home_radius": 100.0,
    "start_aside": 0.0,
    "food_aside": 0.0,
    "home_aside": 0.0,
    "food_beside_robot": "seen at its last place",
    "redetection_time": 0.0,
    "distances": "straight",
    "no_food_distance": "diagonal of the arena",
    "held_food": "candidate at its last place",
    "next_to_food": 20.0,
    "close_to_food": 30.0,
    "equal_distance": "nearer state",
    "carry_margin": 10.0,
    "search_speed": 12.0,
    "home_speed": 12.0,
    "slow_speed": 8.0,
    "push_speed": 8.0,
    "orient_speed": 4.0,
    "lowering_speed": 4.0,
    "retreat_speed": 5.0,
    "circle_speed": 1.5,
    "turn_speed": 5.0,
    "quick_turn_speed": 8.0,
    "searching_arm": "raised",
    "search_without_food": "small circle",
    "beside_food": "back off",
    "back_off_distance": 13.0,
    "orienting": "lowered before food",
    "arm_after_orienting": "raised",
    "aimed": 5.0,
    "astray": 20.0,
    "missed_distance": 10.0,
    "release_depth": 7.0,
    "same_place": 2.0,
    "same_heading": 8.0,
    "separation": 14.0,
    "recovery_speed": 6.0,
    "following_gain": 0.1,
    "patience": 100,
    "most_attempts": 200,
    "rounds_after_training": 0,
    "poison_in_training": "left with the arm raised",
    "distance_arithmetic": "exact",
    "food_to_walls": 50.0,
    "food_spacing": 100.0,
    "recall_marker": 2,
}
"""Version 0.1 of this package."""
