"""The watchdog: a process that stops a robot when its driver has ended or is frozen.

`Watchdog` starts this file as a script, one process a port:

    python -I -S watchdog.py DESCRIPTOR PORT STOP

The script imports the standard library alone, so that it runs after some milliseconds. The open port is inherited: a
port opened again could be locked, a terminal server could refuse a second connection. Standard input is a pipe from the
driver, whose end it reads even if the driver is killed.
"""

import contextlib
import logging
import os
import re
import select
import signal
import subprocess
import sys
import threading
import time

_LOG = logging.getLogger(__name__)
_SIGN_OF_LIFE, _CLOSED = b".", b"c"
"""What the driver sends: that it runs, and that it has stopped the robot and closes the port."""
_MAX_SILENCE = 0.5
"""Seconds without a sign of life after which the driver counts as frozen."""
_INTERVAL = _MAX_SILENCE / 5
"""Seconds between two signs of life: a busy computer may delay some of them."""
_END_TIMEOUT = 1.0
"""Seconds that the process may take to end."""
_CONFIRMATION = re.compile(rb"(?:^|[\r\n\xf0])d[\r\n]")
"""The reply to a stop. Over `rfc2217://` a telnet command, which ends with byte 240, may precede it."""
_CONFIRMATIONS, _REPEAT, _STOP_TIMEOUT = 2, 0.2, 5.0
"""Replies to wait for, one of which may belong to the driver's last command; seconds after which a stop is sent again,
and after which a robot that has not confirmed it is reported."""
_DRIVER = 0
"""Descriptor of the pipe from the driver: standard input."""


class Watchdog:
    """A process that stops a robot when this one ends in any way, or is frozen for more than 0.5 s.

    It covers what no program can catch: `kill -9`, a crash, `os._exit`, SIGSTOP. It runs in a session of its own, which
    signals to the driver's group of processes do not reach, inherits the descriptor of the open port, and ends when the
    driver closes the port. `stop` is the request that stops the robot.

    Raises:
        OSError: The process cannot be started.
    """

    def __init__(self, port: str, descriptor: int, stop: bytes) -> None:
        self._port = port
        self._ended = threading.Event()
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", __file__, str(descriptor), port, stop.decode()],
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

    def end(self) -> None:
        """End the process, before the port is closed; a second call does nothing."""
        if self._ended.is_set():
            return
        self._ended.set()
        self._thread.join()
        with contextlib.suppress(OSError):
            self._pipe.write(_CLOSED)
        self._pipe.close()
        try:
            self._process.wait(_END_TIMEOUT)
        except subprocess.TimeoutExpired:  # somebody has stopped it
            self._process.kill()
            self._process.wait()

    def _send_signs_of_life(self) -> None:
        while not self._ended.wait(_INTERVAL):
            try:
                self._pipe.write(_SIGN_OF_LIFE)  # None if the pipe is full
            except OSError:
                _LOG.error("the watchdog of %s has ended: a kill -9 would no longer stop the robot", self._port)
                return


def start_watchdog(port: str, descriptor: int | None, stop: bytes) -> Watchdog | None:
    """Start the watchdog of a port; log why there is none, where it cannot work."""
    if os.name != "posix":
        reason = f"it requires a POSIX system, not {os.name}"
    elif descriptor is None:
        reason = "the port has no file descriptor"
    else:
        try:
            return Watchdog(port, descriptor, stop)
        except OSError as error:
            reason = str(error)
    _LOG.warning("%s has no watchdog, a kill -9 would not stop the robot: %s", port, reason)
    return None


# What follows runs in the process of the watchdog.


def _watch(port: int, name: str, request: bytes) -> int:
    """Watch the driver until it ends or closes the port; returns 1 if a robot may still be moving, otherwise 0."""
    stopped = False
    while True:
        if select.select([_DRIVER], [], [], _MAX_SILENCE)[0]:
            signs = os.read(_DRIVER, 1000)
            if _CLOSED in signs:
                return 0
            if not signs:
                break
            stopped = False
        elif not stopped:
            stopped = _stop(port, request, until_driver_returns=True)
    if _stop(port, request):
        return 0
    with contextlib.suppress(OSError):
        print(f"{name} may still be moving: its driver has ended, and it confirms no stop", file=sys.stderr)
    return 1


def _stop(port: int, request: bytes, until_driver_returns: bool = False) -> bool:
    """Send stops until the robot has confirmed them; returns whether it has, within 5 s."""
    received = b""
    # The first line end terminates a request that the driver has not finished.
    data = request[-1:] + request
    end = time.monotonic() + _STOP_TIMEOUT
    try:
        _read(port)  # replies to the driver
        while time.monotonic() < end:
            # A port may accept nothing within the time of a repetition.
            if select.select([], [port], [], _REPEAT)[1]:
                with contextlib.suppress(BlockingIOError):
                    os.write(port, data)
            data = request
            repeat = time.monotonic() + _REPEAT
            while (rest := repeat - time.monotonic()) > 0:
                sources = [port, _DRIVER] if until_driver_returns else [port]
                ready = select.select(sources, [], [], rest)[0]
                if _DRIVER in ready:
                    return True  # The driver is back, and controls the port again.
                if ready:
                    received += _read(port)
                    if len(_CONFIRMATION.findall(received)) >= _CONFIRMATIONS:
                        return True
                    if received.endswith((b"d\n", b"d\r")):
                        break  # confirmed once: send it again at once
    except OSError:
        pass  # The cable is disconnected: nothing can be sent any more.
    return False


def _read(port: int) -> bytes:
    """The bytes that have arrived; raises `OSError` if the port is disconnected."""
    data = b""
    while select.select([port], [], [], 0)[0]:
        piece = os.read(port, 1000)
        if not piece:
            raise ConnectionError("the port is disconnected")
        data += piece
    return data


if __name__ == "__main__":
    # Outlive the driver whatever ends its session or its group of processes; only `kill -9` ends the watchdog.
    for number in signal.valid_signals():
        with contextlib.suppress(OSError, ValueError):
            signal.signal(number, signal.SIG_IGN)
    sys.exit(_watch(int(sys.argv[1]), sys.argv[2], sys.argv[3].encode()))
