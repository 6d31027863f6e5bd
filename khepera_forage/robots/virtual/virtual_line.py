"""The robot's end of a serial line that is no cable: a pseudo-terminal, or a TCP port on this machine.

Neither waits for a host that does not read: what finds no room is lost, as on a line without flow control.
"""

import contextlib
import errno
import os
import socket
from typing import Protocol

_CHUNK = 4096


class VirtualLine(Protocol):
    """Bytes in and out, without waiting.

    Attributes:
        url: What `serial.serial_for_url` takes to open the other end.
    """

    url: str

    def filenos(self) -> list[int]:
        """File descriptors that are readable when there is something to `read`."""
        ...

    def read(self) -> bytes:
        """What has arrived; nothing if nothing has."""
        ...

    def write(self, data: bytes) -> None:
        """Send as much of this as there is room for."""
        ...

    def close(self) -> None:
        """Cut the line; the host notices. A second call does nothing."""
        ...


class PtyLine:
    """A pseudo-terminal, without echo or translation of line ends.

    The host's end is kept open here too: hosts may come and go.
    """

    def __init__(self) -> None:
        # Only where there are pseudo-terminals: the TCP line serves without them.
        import pty
        import tty

        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url = os.ttyname(self._slave)
        self._open = True

    def filenos(self) -> list[int]:
        """The robot's end."""
        return [self._master] if self._open else []

    def read(self) -> bytes:
        """What has arrived."""
        try:
            return os.read(self._master, _CHUNK)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        """Hang up: the host reads an error from now on."""
        if self._open:
            self._open = False
            os.close(self._master)
            os.close(self._slave)


class TcpLine:
    """A TCP port on 127.0.0.1 for one host at a time; while there is one, another is turned away.

    Args:
        port: Its number; 0 takes any that is free.

    Raises:
        OSError: The port is taken or not allowed.
    """

    def __init__(self, port: int) -> None:
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.setblocking(False)
        self._host: socket.socket | None = None
        self.url = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"

    def filenos(self) -> list[int]:
        """The host's connection, and where the next one knocks."""
        ends = [self._listener] if self._host is None else [self._host, self._listener]
        return [end.fileno() for end in ends if end.fileno() >= 0]

    def read(self) -> bytes:
        """What has arrived; a host that hung up makes room for the next one."""
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
                self._hang_up()
            data += piece
        return data

    def write(self, data: bytes) -> None:
        """Send, if there is a host."""
        if self._host is None:
            return
        try:
            self._host.send(data)
        except BlockingIOError:
            pass
        except OSError as error:
            if error.errno not in (errno.EPIPE, errno.ECONNRESET):
                raise
            self._hang_up()

    def close(self) -> None:
        """Hang up and listen no longer."""
        self._hang_up()
        self._listener.close()

    def _hang_up(self) -> None:
        if self._host is not None:
            self._host.close()
            self._host = None
