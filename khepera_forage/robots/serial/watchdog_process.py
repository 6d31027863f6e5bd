"""The watchdog process: stops a robot when its driver has ended or is frozen.

`Watchdog` starts this file as a script, one process a port:

    python -I -S watchdog_process.py DESCRIPTOR PORT STOP

It imports the standard library alone, so that it runs after some milliseconds. The open port is inherited: a port
opened again could be locked, a terminal server could refuse a second connection. Standard input is a pipe from the
driver, whose end it reads even if the driver is killed.
"""

import contextlib
import os
import re
import select
import signal
import sys
import time

SIGN_OF_LIFE = b"."
CLOSED = b"c"
"""The driver has stopped the robot and closes the port: nothing is left to watch."""
MAX_SILENCE = 0.5
"""Seconds without a sign of life after which the driver counts as frozen."""

_CONFIRMATION = re.compile(rb"(?:^|[\r\n\xf0])d[\r\n]")
"""The reply to a stop. Over `rfc2217://` a telnet command, which ends with byte 240, may precede it."""
_CONFIRMATIONS = 2
"""Replies to wait for: one may belong to the driver's last command."""
_REPEAT = 0.2
"""Seconds after which a stop is sent again."""
_STOP_TIMEOUT = 5.0
"""Seconds after which a robot that has not confirmed its stop is reported."""
_DRIVER = 0
"""Descriptor of the pipe from the driver: standard input."""


def watch(port: int, name: str, request: bytes) -> int:
    """Watch the driver until it ends or closes the port.

    Args:
        port: Descriptor of the open port.
        name: Name of the port in messages.
        request: The request that stops the robot.

    Returns:
        0, or 1 if a robot may still be moving.
    """
    stopped = False
    while True:
        if select.select([_DRIVER], [], [], MAX_SILENCE)[0]:
            signs = os.read(_DRIVER, 1000)
            if CLOSED in signs:
                return 0
            if not signs:
                break
            stopped = False
        elif not stopped:
            stopped = stop(port, request, until_driver_returns=True)
    if stop(port, request):
        return 0
    with contextlib.suppress(OSError):
        print(f"{name} may still be moving: its driver has ended, and it confirms no stop", file=sys.stderr)
    return 1


def stop(port: int, request: bytes, until_driver_returns: bool = False) -> bool:
    """Send stops until the robot has confirmed them; returns whether it has, within 5 s."""
    received = b""
    # The first line end terminates a request that the driver has not finished.
    data = request[-1:] + request
    end = time.monotonic() + _STOP_TIMEOUT
    try:
        _read(port)  # replies to the driver
        while time.monotonic() < end:
            _write(port, data)
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
    """The bytes that have arrived.

    Raises:
        OSError: The port is disconnected.
    """
    data = b""
    while select.select([port], [], [], 0)[0]:
        piece = os.read(port, 1000)
        if not piece:
            raise ConnectionError("the port is disconnected")
        data += piece
    return data


def _write(port: int, data: bytes) -> None:
    """Send bytes, unless the port accepts none within the time of a repetition."""
    if select.select([], [port], [], _REPEAT)[1]:
        with contextlib.suppress(BlockingIOError):
            os.write(port, data)


def _ignore_signals() -> None:
    """Outlive the driver whatever ends its session or its group of processes; only `kill -9` ends the watchdog."""
    for number in signal.valid_signals():
        with contextlib.suppress(OSError, ValueError):
            signal.signal(number, signal.SIG_IGN)


if __name__ == "__main__":
    _ignore_signals()
    sys.exit(watch(int(sys.argv[1]), sys.argv[2], sys.argv[3].encode()))
