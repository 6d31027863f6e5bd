"""A laboratory that loses a robot or the camera: all robots are stopped, and `reset` reconnects."""

import os
import pickle
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.envs.laboratories import load_settings
from khepera_forage.lab.laboratory import Laboratory
from khepera_forage.lab.operator import OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.real_robot import RobotSuspended
from khepera_forage.vision.video import CameraLost, FrameSource
from tests.lab.laboratories import ARENAS, LAYOUT, drive_all, is_stopped, quiet_laboratory
from tests.version_0_1 import V0_1
from tests.vision.scene_renderer import write_film


class FailingSource:
    """Frames that a test can turn black."""

    def __init__(self, frames: FrameSource) -> None:
        self.frames, self.black, self.closed = frames, False, False

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        frame, age = self.frames.newest()
        return (frame // 32 if self.black else frame), age

    def close(self) -> None:
        self.closed = True


@pytest.mark.parametrize(
    "lost", [RobotLost("p", "D", 3, "mute"), RobotSuspended("p", "", 0, "slept"), CameraLost("0", "closed", None)]
)
def test_losses_reach_other_processes(lost: Exception) -> None:
    lost.args = (f"{lost}; it may still be moving",)  # as a laboratory adds it
    copied = pickle.loads(pickle.dumps(lost))
    assert (type(copied), str(copied), vars(copied)) == (type(lost), str(lost), vars(lost))


def test_lost_camera_is_opened_again_until_it_has_the_right_frames() -> None:
    opened: list[FailingSource] = []

    def camera(frames: FrameSource) -> FrameSource:
        opened.append(FailingSource(frames))
        if len(opened) == 2:
            raise ValueError("camera 0 has frames of 640 x 360")
        return opened[-1]

    with quiet_laboratory(camera=camera) as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        drive_all(lab)
        opened[0].black = True
        with pytest.raises(CameraLost, match="its picture shows nothing"):
            lab.advance()
        assert is_stopped(lab)
        lab.reset(np.random.default_rng(1), LAYOUT)
        assert [source.closed for source in opened] == [True, False, False]
        first, second, _ = (request.reason for request in lab.virtual_operator.requests)
        assert "its picture shows nothing" in first
        assert second == "reconnect what was lost: camera 0 has frames of 640 x 360"
        drive_all(lab)


@pytest.mark.parametrize("stopped", [False, True])
def test_robot_that_cannot_be_stopped_is_named_in_the_same_message(
    stopped: bool, lab: VirtualLaboratory, caplog: pytest.LogCaptureFixture
) -> None:
    drive_all(lab)
    if stopped:
        lab.stop()
    lab.virtual_kheperas[1].interrupted = True
    with pytest.raises(RobotLost) as lost:
        lab.advance()
    warning = f"; {lab.settings.robots[1].port} may still be moving: switch it off"
    assert str(lost.value).endswith(warning) != stopped
    assert lab.firmwares[1].turning != stopped, "it is out of reach"
    assert not lab.firmwares[0].turning
    lab.virtual_kheperas[1].interrupted = False
    lab.reset(np.random.default_rng(1), LAYOUT)
    assert lab.virtual_operator.requests[0].reason == f"reconnect what was lost: {lost.value}"
    assert caplog.messages == []
    drive_all(lab)


def test_suspension_ends_the_episode_and_asks_the_operator(lab: VirtualLaboratory) -> None:
    drive_all(lab)
    os.kill(os.getpid(), signal.SIGCONT)  # as after Ctrl-Z
    assert is_stopped(lab)
    with pytest.raises(RobotLost, match="the program was suspended"):
        lab.advance()
    assert is_stopped(lab)
    with pytest.raises(RuntimeError, match="reset"):
        lab.advance()
    lab.reset(np.random.default_rng(1), LAYOUT)
    assert [request.reason.split(":")[0] for request in lab.virtual_operator.requests] == [
        "reconnect what was lost",
        "start of an episode",
    ]
    drive_all(lab)


def test_interrupt_stops_all(lab: VirtualLaboratory, monkeypatch: pytest.MonkeyPatch) -> None:
    drive_all(lab)

    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(lab.clock, "wait", interrupted)
    with pytest.raises(KeyboardInterrupt):
        lab.advance()
    assert is_stopped(lab)


def test_laboratory_from_a_file_runs_until_its_video_ends(tmp_path: Path) -> None:
    """The real driver on the ports in the file, a real video source, and the wall clock."""
    with quiet_laboratory() as virtual:
        virtual.reset(np.random.default_rng(0), LAYOUT)
        film = write_film(tmp_path / "film.avi", [virtual.frame_source.newest()[0] for _ in range(60)], 20)
        ports = virtual.port_urls
        for robot in virtual.robots:
            robot.close()  # only one driver can open a port
        path = tmp_path / "lab.toml"
        path.write_text(
            f'safe_speed = 3\n[camera]\nsource = "{film}"\n'
            + "".join(
                f'[[robots]]\nport = "{url}"\ntimeout = 5\noffset = [0, {300 * i}]\n' for i, url in enumerate(ports)
            )
        )
        requests: list[OperatorRequest] = []
        with Laboratory(load_settings(path, V0_1), requests.append) as lab:
            assert lab.arenas == ARENAS
            lab.reset(np.random.default_rng(0), LAYOUT)
            assert len(requests) == 1
            assert lab.robots[0].drive(Motors(10, 10, 215, 200)) == Motors(3, 3, 215, 200)
            lab.advance()
            with pytest.raises(CameraLost, match="the video has ended"):  # noqa: PT012 (in one of the rounds)
                for _ in range(100):
                    lab.advance()
            assert lab.clock.rounds > 2
            assert is_stopped(virtual)


def test_missing_port_closes_the_other_devices(tmp_path: Path) -> None:
    with quiet_laboratory() as virtual:
        for robot in virtual.robots:
            robot.close()
        first, second = virtual.settings.robots
        settings = replace(virtual.settings, robots=(first, replace(second, port=str(tmp_path / "none"))))
        for _ in range(2):
            with pytest.raises(ConnectionError, match="none"):
                Laboratory(settings, source=lambda: virtual.frame_source)
