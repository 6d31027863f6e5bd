"""Frame sources: the newest frame, and its age, from a camera device, a video file or a network stream (3.4)."""

import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from khepera_forage.extras import require

FRAME_SHAPE = (480, 640)

if TYPE_CHECKING:
    import cv2

_CLOSE_TIMEOUT = 5.0
"""Seconds that `close` waits for a read that hangs in a driver."""


class CameraLost(ConnectionError):  # noqa: N818 (named for the event, as `RobotLost` is)
    """A camera has no more frames.

    Args:
        source: Name of the camera.
        reason: Cause of the loss.
        age: Seconds since the last frame; None if there never was one.
    """

    def __init__(self, source: str, reason: str, age: float | None) -> None:
        last = "no frame ever came" if age is None else f"the last frame is {age:.1f} s old"
        super().__init__(f"camera {source}: {reason}; {last}")
        self.source = source
        self.reason = reason
        self.age = age


class FrameSource(Protocol):
    """A source of frames."""

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        """The newest frame, 480 x 640 grey levels with row 0 at the top, and its age in s."""
        ...

    def close(self) -> None:
        """Release the device; a second call does nothing."""
        ...


class VideoSource:
    """A `FrameSource` for anything that OpenCV can open, read by a separate thread.

    The thread reads frames as they arrive and keeps only the newest, so that a slow user never receives old frames from
    a driver's buffer. A video file is played at its own speed, like a camera, and is lost when it ends. Colour becomes
    grey. Frames of another size with the aspect ratio 4 : 3 are scaled to 640 x 480. Other aspect ratios are refused,
    because such frames would be distorted or cut.

    A context manager: leaving it closes the source.

    Args:
        source: Number of a device, path of a file, or URL.
        timeout: Seconds without a new frame after which the camera is lost; the first frame may take ten times as
            long.

    Raises:
        ImportError: OpenCV is not installed.
        FileNotFoundError: The file does not exist.
        CameraLost: The source cannot be opened, or has no first frame.
        ValueError: A timeout that is not above 0, or frames that are not 4 : 3.
    """

    def __init__(self, source: int | str | Path, *, timeout: float = 2.0) -> None:
        require("a video source", "camera")
        if not 0 < timeout < float("inf"):
            raise ValueError(f"timeout is {timeout!r} s; allowed: above 0")
        if isinstance(source, Path) or (isinstance(source, str) and "://" not in source):
            if str(source).isdigit():
                source = int(str(source))
            elif not Path(source).exists():
                raise FileNotFoundError(f"camera {source}: there is no such file or device")
        self._name = str(source)
        self._timeout = timeout
        self._changed = threading.Condition()
        self._frame: NDArray[np.uint8] | None = None
        self._taken = 0.0
        self._end: Exception | None = None
        self._closing = threading.Event()
        capture = _opened(source, self._name)
        self._reader = threading.Thread(
            target=self._read, args=(capture,), name=f"camera {self._name}", daemon=True
        )
        self._reader.start()
        try:
            self._await_first_frame()
        except BaseException:
            self.close()
            raise

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        """The newest frame and its age in s, without waiting. The frame is shared between calls and read-only.

        Raises:
            CameraLost: The video has ended, the device is gone, no frame has arrived for `timeout` seconds, or the
                frames changed their shape.
            ValueError: The source was closed.
        """
        with self._changed:
            frame, age, end = self._frame, time.monotonic() - self._taken, self._end
        if self._closing.is_set():
            raise ValueError(f"camera {self._name} was closed; allowed: newest() before close()")
        if end is not None:
            raise CameraLost(self._name, _reason(end), age) from end
        if age > self._timeout:
            raise CameraLost(self._name, f"no new frame within {self._timeout:g} s", age)
        assert frame is not None
        return frame, age

    def close(self) -> None:
        """Stop the thread and release the device; a second call does nothing."""
        self._closing.set()
        if self._reader is not threading.current_thread():
            # If the driver hangs longer, the thread releases the device when its read returns.
            self._reader.join(_CLOSE_TIMEOUT)

    def __enter__(self) -> "VideoSource":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _await_first_frame(self) -> None:
        with self._changed:
            self._changed.wait_for(
                lambda: self._frame is not None or self._end is not None, 10 * self._timeout
            )
            if self._frame is not None:
                return
            end = self._end
        if isinstance(end, ValueError):
            raise ValueError(f"camera {self._name} has {end}")
        reason = f"opened, but no frame within {10 * self._timeout:g} s" if end is None else _reason(end)
        raise CameraLost(self._name, reason, None) from end

    def _read(self, capture: "cv2.VideoCapture") -> None:
        """The thread's loop: read frames until the source ends or is closed."""
        import cv2

        length = capture.get(cv2.CAP_PROP_FRAME_COUNT)
        period = 1 / max(1.0, capture.get(cv2.CAP_PROP_FPS)) if length > 0 else 0.0
        due = time.monotonic()
        try:
            while not self._closing.is_set():
                good, picture = capture.read()
                if not good:
                    reason = "the video has ended" if length > 0 else "it has no more frames"
                    raise CameraLost(self._name, reason, None)
                frame = _grey(picture)  # type: ignore[arg-type] # uint8
                with self._changed:
                    self._frame, self._taken = frame, time.monotonic()
                    self._changed.notify_all()
                due += period
                self._closing.wait(max(0.0, due - time.monotonic()))
        except Exception as error:  # `newest` raises any error in the user's thread
            with self._changed:
                self._end = error
                self._changed.notify_all()
        finally:
            capture.release()


def _reason(error: Exception) -> str:
    """What ended the frames, in one line."""
    if isinstance(error, CameraLost):
        return error.reason
    return (
        f"it has {error}"
        if isinstance(error, ValueError)
        else f"reading failed: {' '.join(str(error).split())}"
    )


def _opened(source: int | str | Path, name: str) -> "cv2.VideoCapture":
    import cv2

    capture = cv2.VideoCapture(source if isinstance(source, int) else str(source))
    if not capture.isOpened():
        raise CameraLost(name, "cannot be opened", None)
    if (
        capture.get(cv2.CAP_PROP_FRAME_COUNT) <= 0
    ):  # a device: request the thesis's format, which it may refuse
        rows, columns = FRAME_SHAPE
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, columns)
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, rows)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    return capture


def _grey(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A frame as 480 x 640 grey levels, read-only."""
    import cv2

    rows, columns = FRAME_SHAPE
    height, width = picture.shape[:2]
    if width * rows != height * columns:
        raise ValueError(
            f"frames of {width} x {height}; allowed: {columns} x {rows}, or another size with the aspect ratio 4 : 3"
        )
    if picture.ndim == 3:
        picture = picture[:, :, 0] if picture.shape[2] == 1 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)  # type: ignore[assignment]
    if height != rows:
        interpolation = cv2.INTER_AREA if height > rows else cv2.INTER_LINEAR
        picture = cv2.resize(picture, (columns, rows), interpolation=interpolation)  # type: ignore[assignment]
    picture = np.ascontiguousarray(picture)
    picture.setflags(write=False)
    return picture
