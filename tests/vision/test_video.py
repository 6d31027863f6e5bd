"""Frame sources on real video files and network streams, through the real OpenCV."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.vision.video import CameraLost, VideoSettings, VideoSource
from tests.vision.scene_renderer import write_film


def picture(grey: int, width: int = 640, height: int = 480) -> NDArray[np.uint8]:
    """One grey level, with a white bar on the left."""
    frame = np.full((height, width), grey, np.uint8)
    frame[:, : width // 8] = 255
    return frame


def video(path: Path, greys: list[int], fps: float, width: int = 640, height: int = 480) -> Path:
    return write_film(path, [np.repeat(picture(grey, width, height)[..., None], 3, axis=2) for grey in greys], fps)


def threads() -> list[str]:
    return [t.name for t in threading.enumerate() if t.name.startswith("camera")]


def test_video_file_plays_at_its_own_speed(tmp_path: Path) -> None:
    """20 frames per second, each lighter than the last: after half a second about ten were skipped."""
    greys = list(range(40, 240, 4))
    with VideoSource(video(tmp_path / "video.avi", greys, 20)) as source:
        first, start = int(source.newest()[0][240, 320]), time.monotonic()
        time.sleep(0.5)
        later, passed = int(source.newest()[0][240, 320]), time.monotonic() - start
        # No more frames than were due in the time measured, and far fewer than the whole video.
        assert 4 <= later - first <= 4 * (20 * passed + 2)


def test_end_of_a_video_is_reported_and_use_after_close_is_refused(tmp_path: Path) -> None:
    with VideoSource(video(tmp_path / "short.avi", [80, 90, 100], 30)) as source:
        error = lost_after(source, 10.0)
        assert "short.avi: the video has ended" in str(error)
        assert error.age is not None
        assert error.age > 0
        with pytest.raises(CameraLost, match="video has ended"):
            source.newest()
    source.close()
    with pytest.raises(ValueError, match="closed"):
        source.newest()


@pytest.mark.parametrize(
    ("width", "height", "size", "shape"),
    [
        *((320, 240, None, (240, 320)), (1280, 960, None, (960, 1280))),
        *((1280, 960, (640, 480), (480, 640)), (848, 480, (424, 240), (240, 424))),
    ],
)
def test_frames_are_scaled_to_a_size_that_is_given_and_otherwise_delivered_as_they_are(
    tmp_path: Path, width: int, height: int, size: tuple[int, int] | None, shape: tuple[int, int]
) -> None:
    path = video(tmp_path / "video.avi", [100] * 5, 10, width, height)
    with VideoSource(path, settings=VideoSettings(size=size)) as source:
        frame, age = source.newest()
        assert (frame.shape, frame.dtype) == (shape, np.dtype(np.uint8))
        assert not frame.flags.writeable
        assert age >= 0
        middle, across = frame[shape[0] // 2], shape[1]
        assert middle[int(0.09 * across)] > 250
        assert abs(int(middle[int(0.16 * across)]) - 100) <= 4
        assert len(threads()) == 1
    assert threads() == []


def test_file_that_is_not_paced_gives_every_frame(tmp_path: Path) -> None:
    greys = list(range(40, 240, 10))
    with VideoSource(video(tmp_path / "video.avi", greys, 5), paced=False) as source:
        seen = [int(source.newest()[0][240, 320]) for _ in greys]
        with pytest.raises(CameraLost, match="video has ended"):
            source.newest()
    assert seen == pytest.approx(greys, abs=4)


def test_invalid_sources_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"nowhere\.avi"):
        VideoSource(tmp_path / "nowhere.avi")
    text, empty, wide = (tmp_path / f"{name}.avi" for name in ("text", "empty", "wide"))
    text.write_text("not a video")
    with pytest.raises(CameraLost, match="cannot be opened; no frame ever came"):
        VideoSource(text)
    cv2.VideoWriter(str(empty), cv2.VideoWriter.fourcc(*"MJPG"), 5, (640, 480)).release()
    with pytest.raises(CameraLost, match=r"empty\.avi: (it has no frames|cannot be opened)"):
        VideoSource(empty)
    video(wide, [100] * 5, 10, 848, 480)
    with pytest.raises(ValueError, match=r"wide\.avi has frames of 848 x 480; allowed: 640 x 480"):
        VideoSource(wide, settings=VideoSettings(size=(640, 480)))
    (tmp_path / "not\udcffutf-8.avi").touch()
    with pytest.raises(CameraLost, match="cannot be opened; allowed: a name in UTF-8"):
        VideoSource(tmp_path / "not\udcffutf-8.avi")
    with pytest.raises(CameraLost, match="camera 99: cannot be opened"):
        VideoSource("99")
    with pytest.raises(ValueError, match="timeout is 0"):
        VideoSource(0, timeout=0)
    assert threads() == []


@contextmanager
def network_camera() -> Iterator[tuple[str, threading.Event, threading.Event]]:
    """A network camera on loopback that repeats one picture: its URL, and events that silence and disconnect it."""
    silent, disconnected = threading.Event(), threading.Event()
    jpeg = cv2.imencode(".jpg", picture(120))[1].tobytes()
    head = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
            self.end_headers()
            with suppress(OSError):
                while not disconnected.wait(0.02):
                    if not silent.is_set():
                        self.wfile.write(head + jpeg + b"\r\n")

        def log_message(self, *args: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        serving = threading.Thread(target=server.serve_forever, args=(0.05,))
        serving.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}/video.mjpg", silent, disconnected
        finally:
            disconnected.set()
            server.shutdown()
            serving.join()


def lost_after(source: VideoSource, seconds: float) -> CameraLost:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            source.newest()
        except CameraLost as lost:
            return lost
        time.sleep(0.01)
    raise AssertionError(f"camera not lost after {seconds} s")


def test_silent_and_disconnected_network_camera_is_lost_after_the_timeout() -> None:
    losses = []
    with network_camera() as (url, silent, disconnected):
        for event in (silent, disconnected):
            with VideoSource(url, timeout=2.0) as source:
                frame, _ = source.newest()
                assert abs(int(frame[240, 320]) - 120) <= 3
                event.set()
                losses.append(lost_after(source, 20.0))
                silent.clear()  # the blocked read returns
            assert threads() == []
    assert [loss.source for loss in losses] == [url, url]
    assert all(loss.age is not None and url in str(loss) for loss in losses)
    assert "no new frame within 2 s" in str(losses[0])
    assert (losses[0].age or 0) > 2


class Device:
    """A camera device below OpenCV, whose frames can change their size, or fail with an error."""

    def __init__(self) -> None:
        self.height, self.broken, self.failures = 480, False, 0
        self.values: dict[int, float] = {}

    def __call__(self, source: int | str) -> "Device":
        return self

    def isOpened(self) -> bool:  # noqa: N802 (OpenCV's name)
        return True

    def get(self, what: int) -> float:
        return -1.0

    def set(self, what: int, value: float) -> bool:
        self.values[what] = value
        return what != cv2.CAP_PROP_FOCUS

    def read(self) -> tuple[bool, NDArray[np.uint8]]:
        time.sleep(0.01)
        if self.broken:
            raise cv2.error("assertion failed\n in retrieve")
        if self.failures:
            self.failures -= 1
            return False, np.empty(0, np.uint8)
        return True, np.full((self.height, 640), 100, np.uint8)

    def release(self) -> None: ...


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Device:
    device = Device()
    monkeypatch.setattr(cv2, "VideoCapture", device)
    return device


def test_camera_that_changes_its_frames_is_lost(device: Device) -> None:
    """As after a reset of its USB port; the laboratory opens a lost camera again."""
    with VideoSource(0) as source:
        device.height = 360
        lost = lost_after(source, 5.0)
    assert "camera 0: it has frames of 640 x 360; allowed: 640 x 480" in str(lost)
    assert lost.age is not None


def test_failed_reads_are_repeated_until_the_timeout(device: Device) -> None:
    device.failures = 3
    with VideoSource(0, timeout=2.0) as source:
        device.failures = 3
        while device.failures:
            time.sleep(0.01)
        source.newest()
        device.failures = 10**6
        message = str(lost_after(source, 20.0))
        assert "no more frames for 2 s" in message or "no new frame" in message


@pytest.mark.parametrize("source", [0, "/dev/null"])
def test_settings_reach_the_device(source: int | str, device: Device, caplog: pytest.LogCaptureFixture) -> None:
    device.height = 360
    settings = VideoSettings(size=(1280, 720), rate=30.0, exposure=150.0, focus=20.0)
    with VideoSource(source, settings=settings) as video_source:
        assert video_source.newest()[0].shape == (720, 1280)
    expected = {cv2.CAP_PROP_FRAME_WIDTH: 1280, cv2.CAP_PROP_FPS: 30, cv2.CAP_PROP_EXPOSURE: 150}
    assert expected.items() <= device.values.items()
    assert device.values[cv2.CAP_PROP_AUTO_EXPOSURE] == 1
    assert f"camera {source} does not accept focus 20" in caplog.text


def test_error_of_the_driver_loses_the_camera(device: Device) -> None:
    with VideoSource(0) as source:
        device.broken = True
        assert "camera 0: reading failed: assertion failed in retrieve; " in str(lost_after(source, 5.0))
    with pytest.raises(CameraLost, match="reading failed: assertion failed in retrieve; no frame ever came"):
        VideoSource(0)
