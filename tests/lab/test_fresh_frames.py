"""Frames of a round: old, frozen and empty ones are waited out, with the wheels stopped, or the camera is lost."""

import numpy as np
import pytest

from khepera_forage.lab.devices import FreshFrames
from khepera_forage.lab.settings_file import CameraSettings, LabSettings
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.video import CameraLost
from tests.lab.laboratories import Time
from tests.version_0_1 import CORRIDOR
from tests.vision.scene_renderer import PAIR, Frame, render_frame, render_frames

OLDEST = 0.2
SETTINGS = LabSettings(CORRIDOR, (), CameraSettings(oldest=OLDEST), period=0.02)
BLACK = np.zeros((480, 640), np.uint8)
SCENES = render_frames(PAIR, frames=3)
for number, frame in enumerate(SCENES):
    frame[0, 0] = number  # each differs from the others


@pytest.fixture(autouse=True)
def time(monkeypatch: pytest.MonkeyPatch) -> Time:
    time = Time()
    monkeypatch.setattr("khepera_forage.lab.devices.time", time)
    return time


class Source:
    """A source that returns its frames one after the other, each taken now, and the last one again and again."""

    def __init__(self, *frames: Frame) -> None:
        self.frames = list(frames)
        self.age = 0.0

    def newest(self) -> tuple[Frame, float]:
        return self.frames.pop(0) if len(self.frames) > 1 else self.frames[0], self.age

    def close(self) -> None: ...


class Setting:
    """Frames of a source, robots whose counters a test sets, and the number of times that wheels were stopped."""

    def __init__(self, *frames: Frame) -> None:
        self.source, self.pulses, self.stops = Source(*frames), [0, 0], 0
        self.frames = FreshFrames(self.source, Tracker(), SETTINGS, lambda: list(self.pulses), self.stop)

    def stop(self) -> None:
        self.stops += 1

    def next_round(self) -> Frame:
        self.frames.begin_round()
        return self.frames.newest()[0]


def test_frame_from_before_the_round_is_not_taken(time: Time) -> None:
    setting = Setting(SCENES[0])
    setting.source.age = 0.05
    begin = time.now
    setting.next_round()
    assert 0.05 <= time.now - begin < 0.06, "the age stays the same: the frame is taken later and later"
    assert setting.stops == 1, "after two periods"


def test_old_frame_loses_the_camera() -> None:
    setting = Setting(SCENES[0])
    setting.source.age = OLDEST + 0.01
    with pytest.raises(CameraLost, match=r"camera 0: no frame for 0\.2 s"):
        setting.next_round()


def test_empty_frames_are_left_out() -> None:
    setting = Setting(SCENES[0], BLACK, BLACK, SCENES[1])
    setting.next_round()
    assert setting.next_round() is SCENES[1]


BRIGHT = np.clip(render_frame(PAIR) * 2.0, 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("later", "pulses", "message"),
    [
        (BLACK, 0, "its picture shows nothing: all grey levels are 0 to 0"),
        (BRIGHT, 0, r"its picture is overexposed: .* reduce the camera's exposure"),
        (SCENES[0], 100, "its picture has not changed, although a robot has travelled 8 mm"),
    ],
    ids=["black", "overexposed", "frozen"],
)
def test_camera_that_shows_no_new_scene_is_lost(later: Frame, pulses: int, message: str) -> None:
    setting = Setting(SCENES[0], later)
    setting.next_round()
    setting.pulses = [0, pulses]
    with pytest.raises(CameraLost, match=message):
        setting.next_round()
    assert setting.stops == 1


def test_picture_that_stays_the_same_while_robots_stand_is_accepted() -> None:
    setting = Setting(SCENES[0])
    for _ in range(3):
        setting.next_round()
    setting.pulses = [0, 100]
    setting.frames.forget()
    setting.next_round()
    assert setting.stops == 0


def test_constant_overexposure_is_accepted() -> None:
    Setting(BRIGHT).next_round()
