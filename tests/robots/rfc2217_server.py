"""A serial device server (RFC 2217) in front of a port, for one client: pyserial's own protocol, a socket, a thread."""

import contextlib
import select
import socket
import threading
from collections.abc import Iterator
from typing import Any, cast

import serial
from serial.rfc2217 import PortManager


class _Connection:
    def __init__(self, client: socket.socket) -> None:
        self._client = client
        self._writing = threading.Lock()

    def write(self, data: bytes) -> None:
        with self._writing:
            self._client.sendall(data)


@contextlib.contextmanager
def served(device: str) -> Iterator[str]:
    """The URL under which a port is to be had while this lasts.

    Args:
        device: One that has modem lines to report, as `socket://` pretends to; a pseudo-terminal has none.
    """
    over = threading.Event()
    with (
        socket.create_server(("127.0.0.1", 0)) as listener,
        serial.serial_for_url(device, 38400, timeout=0) as port,
    ):

        def serve() -> None:
            client, _ = listener.accept()
            connection = _Connection(client)
            # Its types say less than its documentation, which asks for any port and anything that writes.
            manager = PortManager(cast(Any, port), cast(Any, connection))
            ends: list[Any] = [client, port]
            with client, contextlib.suppress(ConnectionError):
                while not over.is_set():
                    ready, _, _ = select.select(ends, [], [], 0.02)
                    if client in ready:
                        data = client.recv(1000)
                        if not data:
                            return
                        port.write(b"".join(manager.filter(data)))
                    if port in ready:
                        connection.write(b"".join(manager.escape(port.read(1000))))

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield f"rfc2217://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            over.set()
            thread.join()
