"""The robot's end of a virtual serial line: a pseudo-terminal, or a TCP port on this machine.

Writing never waits for a host that does not read: bytes that exceed the buffer are lost, as on a line without flow
control.
"""

import contextlib
import errno
import os
import socket
from typing import Protocol

_CHUNK = 4096


class Endpoint(Protocol):
    """Reads and writes bytes without blocking.

    Attributes:
        url: Argument of `serial.serial_for_url` that opens the other end.
    """

    url: str

    def filenos(self) -> list[int]:
        """File descriptors that become readable when `read` has bytes to return."""
        ...

    def read(self) -> bytes:
        """The bytes that have arrived; may be empty."""
        ...

    def write(self, data: bytes) -> None:
        """Send as many of these bytes as the buffer has room for."""
        ...

    def close(self) -> None:
        """Disconnect the host. A second call does nothing."""
        ...


class PtyEndpoint:
    """A pseudo-terminal, without echo or translation of line endings.

    The host's end also stays open here, so that hosts can disconnect and reconnect.

    Raises:
        OSError: The system has no pseudo-terminals, as Windows.
    """

    def __init__(self) -> None:
        # Imported here: systems without pseudo-terminals can still use `TcpEndpoint`.
        try:
            import pty
            import tty
        except ImportError:
            raise OSError(
                "a virtual robot's serial port is a pseudo-terminal, which this system does not have; allowed: Linux, "
                "macOS, or Windows Subsystem for Linux"
            ) from None

        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url = os.ttyname(self._slave)
        self._open = True

    def filenos(self) -> list[int]:
        """The robot's end of the pseudo-terminal."""
        return [self._master] if self._open else []

    def read(self) -> bytes:
        """The bytes that have arrived."""
        try:
            return os.read(self._master, _CHUNK)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send bytes."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        """Disconnect the host: its reads fail from now on."""
        if self._open:
            self._open = False
            os.close(self._master)
            os.close(self._slave)


class TcpEndpoint:
    """A TCP port on 127.0.0.1 for one host at a time; a second connection is closed at once.

    Args:
        port: Port number; 0 takes any free port.

    Raises:
        OSError: The port is in use or not allowed.
    """

    def __init__(self, port: int) -> None:
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.setblocking(False)
        self._host: socket.socket | None = None
        self.url = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"

    def filenos(self) -> list[int]:
        """The host's connection and the listening socket."""
        ends = [self._listener] if self._host is None else [self._host, self._listener]
        return [end.fileno() for end in ends if end.fileno() >= 0]

    def read(self) -> bytes:
        """The bytes that have arrived; also accepts a new host after the last one has disconnected."""
        data = self._receive()
        with contextlib.suppress(BlockingIOError):
            host, _ = self._listener.accept()
            if self._host is not None:
                host.close()
            else:
                host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                host.setblocking(False)
                self._host = host
        return data

    def _receive(self) -> bytes:
        data = b""
        while self._host is not None:
            try:
                piece = self._host.recv(_CHUNK)
            except BlockingIOError:
                break
            except OSError:
                piece = b""
            if not piece:
                self._disconnect()
            data += piece
        return data

    def write(self, data: bytes) -> None:
        """Send bytes, if a host is connected."""
        if self._host is None:
            return
        try:
            self._host.send(data)
        except BlockingIOError:
            pass
        except OSError as error:
            if error.errno not in (errno.EPIPE, errno.ECONNRESET):
                raise
            self._disconnect()

    def close(self) -> None:
        """Disconnect the host and stop listening."""
        self._disconnect()
        self._listener.close()

    def _disconnect(self) -> None:
        if self._host is not None:
            self._host.close()
            self._host = None
