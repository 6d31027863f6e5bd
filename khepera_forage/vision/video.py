"""Frame sources: the newest frame, and its age, from a camera device, a video file or a network stream (3.4)."""

import logging
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from khepera_forage.extras import require
from khepera_forage.files import has_utf8_name
from khepera_forage.vision.calibration import DEFAULT_SIZE, Size

if TYPE_CHECKING:
    import cv2

Frame = NDArray[np.uint8]
_LOG = logging.getLogger(__name__)
_CLOSE_TIMEOUT = 5.0
"""Seconds that `close` waits for a read that hangs in a driver."""
_LEAST_PERIOD = 0.001
"""Seconds between two frames of a file at least."""
_RETRY, _REOPEN = 0.02, 0.5
"""Seconds from a failed read to the next, and from one attempt to open a stream again to the next."""


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

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.source, self.reason, self.age), {"args": self.args}


@dataclass(frozen=True, slots=True)
class VideoSettings:
    """Settings of a camera device; what is None is left as it is.

    Attributes:
        size: Width and height of the frames in pixels; by default 640 x 480, or what the camera has.
        rate: Frames a second.
        exposure: In the driver's unit, on V4L2 0.1 ms; it switches the automatic exposure off.
        focus: In the driver's unit; it switches the automatic focus off.

    Raises:
        ValueError: A size or rate that no camera has.
    """

    size: Size | None = None
    rate: float | None = None
    exposure: float | None = None
    focus: float | None = None

    def __post_init__(self) -> None:
        size = self.size
        if size is not None and not (len(size) == 2 and all(type(n) is int and 16 <= n <= 16384 for n in size)):
            raise ValueError(f"camera size is {size!r}; allowed: width and height, 16 to 16384 pixels each")
        if self.rate is not None and not 0 < self.rate <= 1000:
            raise ValueError(f"camera rate is {self.rate!r}; allowed: above 0, up to 1000 frames a second")


def as_grey(frame: Frame) -> Frame:
    """A frame as grey levels: itself, or the brightness of its colours (blue, green, red, as OpenCV has them).

    Raises:
        ValueError: Anything else.
    """
    import cv2

    if frame.dtype != np.uint8 or frame.ndim not in (2, 3) or frame.shape[2:] not in ((), (1,), (3,)):
        raise ValueError(
            f"frame is {frame.shape} of {frame.dtype}; allowed: rows x columns of uint8 grey levels, or x 3 colours"
        )
    if frame.ndim == 2:
        return frame
    return frame[:, :, 0] if frame.shape[2] == 1 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)  # type: ignore[return-value]


class FrameSource(Protocol):
    """A source of frames."""

    def newest(self) -> tuple[Frame, float]:
        """The newest frame, rows x columns of grey levels with row 0 at the top, and its age in s."""
        ...

    def close(self) -> None:
        """Release the device; a second call does nothing."""
        ...


class VideoSource:
    """A `FrameSource` for anything that OpenCV can open, read by a separate thread.

    The thread reads frames as they arrive and keeps only the newest, so that a slow user never receives old frames from
    a driver's buffer. A video file is played at its own speed, which may vary, like a camera, and is lost when it
    ends; a still picture stays. Failed reads are repeated, and streams opened again, until the timeout. Colour becomes
    grey.

    Frames of another size with the aspect ratio of `settings.size` are scaled to it, and other aspect ratios are
    refused. Without a size, that of the first frame is taken.

    A context manager: leaving it closes the source.

    Args:
        source: Number or path of a device, path of a file, or URL (http, rtsp).
        timeout: Seconds without a new frame after which the camera is lost; the first frame may take ten times as
            long.
        settings: Of the camera device.
        paced: Whether a file plays at its own speed; if not, every call of `newest` returns its next frame.

    Raises:
        ImportError: OpenCV is not installed.
        FileNotFoundError: The file does not exist.
        CameraLost: The source cannot be opened, or has no first frame.
        ValueError: A timeout that is not above 0, or frames of another aspect ratio than the size.
    """

    def __init__(
        self,
        source: int | str | Path,
        *,
        timeout: float = 2.0,
        settings: VideoSettings | None = None,
        paced: bool = True,
    ) -> None:
        require("a video source", "camera")
        if not 0 < timeout < float("inf"):
            raise ValueError(f"timeout is {timeout!r} s; allowed: above 0")
        if isinstance(source, Path) or (isinstance(source, str) and "://" not in source):
            if str(source).isdigit():
                source = int(str(source))
            elif not Path(source).exists():
                raise FileNotFoundError(f"camera {source}: there is no such file or device")
        self._name, self._timeout = str(source), timeout
        self._source, self._settings = source, settings or VideoSettings()
        self._size: Size | None = self._settings.size
        self._is_file = not isinstance(source, int) and Path(source).is_file()
        # The newest frame and when it came; why the source ended, and the error. Both are replaced as a whole.
        self._latest: tuple[Frame, float] | None = None
        self._end: tuple[str, Exception | None] | None = None
        self._frames = 0
        self._ready, self._closing = threading.Event(), threading.Event()
        self._reader: threading.Thread | None = None
        self._capture = self._opened()
        try:
            if paced or not self._is_file:
                self._reader = threading.Thread(target=self._read_all, name=f"camera {self._name}", daemon=True)
                self._reader.start()
            else:
                self._read_one()
            self._ready.wait(10 * timeout)
            if self._latest is None:
                reason, cause = self._end or (f"opened, but no frame within {10 * timeout:g} s", None)
                if isinstance(cause, ValueError):
                    raise ValueError(f"camera {self._name} has {cause}")
                raise CameraLost(self._name, reason, None) from cause
        except BaseException:
            self.close()
            raise

    def newest(self) -> tuple[Frame, float]:
        """The newest frame and its age in s, without waiting. The frame is shared between calls and read-only.

        A file that is not paced reads its next frame instead.

        Raises:
            CameraLost: The video has ended, the device is gone, no frame has arrived for `timeout` seconds, or the
                frames changed their shape.
            ValueError: The source was closed.
        """
        if self._closing.is_set():
            raise ValueError(f"camera {self._name} was closed; allowed: newest() before close()")
        assert self._latest is not None
        frame, taken = self._latest
        age = time.monotonic() - taken
        if self._end is not None:
            reason, cause = self._end
            raise CameraLost(self._name, reason, age) from cause
        if self._reader is None:
            self._read_one()  # the next frame
            return frame, 0.0
        if age > self._timeout:
            raise CameraLost(self._name, f"no new frame within {self._timeout:g} s", age)
        return frame, age

    def close(self) -> None:
        """Stop the thread and release the device; a second call does nothing."""
        self._closing.set()
        if self._reader is None:
            self._capture.release()
        else:
            # If the driver hangs longer, the thread releases the device when its read returns.
            self._reader.join(_CLOSE_TIMEOUT)

    def __enter__(self) -> "VideoSource":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _opened(self) -> "cv2.VideoCapture":
        import cv2

        source = self._source
        if not has_utf8_name(str(source)):
            raise CameraLost(self._name, "cannot be opened; allowed: a name in UTF-8", None)
        capture = cv2.VideoCapture(source if isinstance(source, int) else str(source))
        if not capture.isOpened():
            raise CameraLost(self._name, "cannot be opened", None)
        if isinstance(source, int) or Path(source).is_char_device():
            _configure(capture, self._settings, self._name)
        return capture

    def _read_all(self) -> None:
        """The thread: read frames until the source ends or is closed."""
        import cv2

        period = 1 / max(1.0, self._capture.get(cv2.CAP_PROP_FPS))  # of a file
        began = due = last = opened = time.monotonic()
        while self._end is None and not self._closing.is_set():
            now = time.monotonic()
            if self._read_one():
                last = now
                if self._is_file:
                    # By its time in the file, as far as the file has times.
                    seconds = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
                    planned = (began + seconds if seconds > 0 else due) + period
                    due = max(due + _LEAST_PERIOD, planned)
                    self._closing.wait(max(0.0, due - time.monotonic()))
                continue
            patience = self._timeout if self._latest is not None else 10 * self._timeout
            if now - last > patience:
                self._finish(f"it has had no more frames for {patience:g} s")
            elif not isinstance(self._source, int) and now - opened > _REOPEN:
                opened = now
                # If a stream cannot be opened again, for whatever reason, it stays as it is.
                with suppress(Exception):
                    again = self._opened()
                    self._capture.release()
                    self._capture = again
            self._closing.wait(_RETRY)
        self._capture.release()

    def _read_one(self) -> bool:
        """Read a frame; whether there was one. Any error ends the source, and `newest` raises it."""
        try:
            good, picture = self._capture.read()
            if good:
                self._latest = self._scaled(as_grey(picture)), time.monotonic()  # type: ignore[arg-type] # uint8
                self._frames += 1
                self._ready.set()
            elif self._is_file and self._frames == 1:
                # A still picture: a view of it counts as another frame.
                good, self._latest = True, (self._latest[0][:], time.monotonic())  # type: ignore[index]
            elif self._is_file:
                self._finish("it has no frames" if self._latest is None else "the video has ended")
            return good
        except ValueError as error:
            self._finish(f"it has {error}", error)
        except Exception as error:
            self._finish(f"reading failed: {' '.join(str(error).split())}", error)
        return False

    def _finish(self, reason: str, cause: Exception | None = None) -> None:
        self._end = reason, cause
        self._ready.set()

    def _scaled(self, grey: Frame) -> Frame:
        """A frame of the size that all frames have, read-only."""
        import cv2

        height, width = grey.shape
        wide, high = self._size = self._size or (width, height)
        if width * high != height * wide:
            raise ValueError(
                f"frames of {width} x {height}; allowed: {wide} x {high}, or another size with this aspect ratio"
            )
        if height != high:
            interpolation = cv2.INTER_AREA if height > high else cv2.INTER_LINEAR
            grey = cv2.resize(grey, (wide, high), interpolation=interpolation)  # type: ignore[assignment]
        grey = np.ascontiguousarray(grey)
        grey.setflags(write=False)
        return grey


def _configure(capture: "cv2.VideoCapture", settings: VideoSettings, name: str) -> None:
    """Set a device; what it refuses is logged."""
    import cv2

    width, height = settings.size or DEFAULT_SIZE
    if width > DEFAULT_SIZE[0]:
        # Compressed frames: uncompressed ones are too many for USB.
        capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*"MJPG"))
    capture.set(cv2.CAP_PROP_FRAME_WIDTH, width)
    capture.set(cv2.CAP_PROP_FRAME_HEIGHT, height)
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    if settings.exposure is not None:
        capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, 1)  # V4L2: manual
    if settings.focus is not None:
        capture.set(cv2.CAP_PROP_AUTOFOCUS, 0)
    for what, number, value in (
        ("rate", cv2.CAP_PROP_FPS, settings.rate),
        ("exposure", cv2.CAP_PROP_EXPOSURE, settings.exposure),
        ("focus", cv2.CAP_PROP_FOCUS, settings.focus),
    ):
        if value is not None and not capture.set(number, value):
            _LOG.warning("camera %s does not accept %s %g; its own setting stays", name, what, value)
