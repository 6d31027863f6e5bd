"""The driver's end of the watchdog: starts the process for a port, and sends it signs of life."""

import contextlib
import logging
import os
import subprocess
import sys
import threading

from khepera_forage.robots.serial import watchdog_process

_LOG = logging.getLogger(__name__)
_INTERVAL = watchdog_process.MAX_SILENCE / 5
"""Seconds between two signs of life: a busy computer may delay some of them."""
_END_TIMEOUT = 1.0
"""Seconds that the process may take to end."""


class Watchdog:
    """A process that stops a robot when this one ends in any way, or is frozen for more than 0.5 s.

    It covers what no program can catch: `kill -9`, a crash, `os._exit`, SIGSTOP. It runs in a session of its own, which
    signals to the driver's group of processes do not reach, and ends when the driver closes the port.

    Args:
        port: Name of the port in messages.
        descriptor: File descriptor of the open port, which the process inherits.
        stop: The request that stops the robot.

    Raises:
        OSError: The process cannot be started.
    """

    def __init__(self, port: str, descriptor: int, stop: bytes) -> None:
        self._port = port
        self._ended = threading.Event()
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", watchdog_process.__file__, str(descriptor), port, stop.decode()],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            pass_fds=(descriptor,),
            start_new_session=True,
            bufsize=0,
        )
        assert self._process.stdin is not None
        self._pipe = self._process.stdin
        os.set_blocking(self._pipe.fileno(), False)
        self._thread = threading.Thread(target=self._send_signs_of_life, name=f"watchdog {port}", daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        """Identifier of the process."""
        return self._process.pid

    def end(self) -> None:
        """End the process, before the port is closed; a second call does nothing."""
        if self._ended.is_set():
            return
        self._ended.set()
        self._thread.join()
        with contextlib.suppress(OSError):
            self._pipe.write(watchdog_process.CLOSED)
        self._pipe.close()
        try:
            self._process.wait(_END_TIMEOUT)
        except subprocess.TimeoutExpired:  # somebody has stopped it
            self._process.kill()
            self._process.wait()

    def _send_signs_of_life(self) -> None:
        while not self._ended.wait(_INTERVAL):
            try:
                self._pipe.write(watchdog_process.SIGN_OF_LIFE)  # None if the pipe is full
            except OSError:
                _LOG.error(
                    "the watchdog of %s has ended: a kill -9 would no longer stop the robot", self._port
                )
                return


def start_watchdog(port: str, descriptor: int | None, stop: bytes) -> Watchdog | None:
    """Start the watchdog of a port; log why there is none, where it cannot work.

    Args:
        port: Name of the port.
        descriptor: Its file descriptor, or None if it has none.
        stop: The request that stops the robot.
    """
    reason = "the port has no file descriptor" if descriptor is None else ""
    if os.name != "posix":
        reason = f"it requires a POSIX system, not {os.name}"
    if not reason:
        assert descriptor is not None
        try:
            return Watchdog(port, descriptor, stop)
        except OSError as error:
            reason = str(error)
    _LOG.warning("%s has no watchdog, a kill -9 would not stop the robot: %s", port, reason)
    return None
