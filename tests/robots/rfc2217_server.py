"""A serial device server (RFC 2217) for one client, built on pyserial's implementation of the protocol."""

import contextlib
import select
import socket
import threading
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import serial
from serial.rfc2217 import PortManager


@contextlib.contextmanager
def rfc2217_server(device: str) -> Iterator[str]:
    """Serve a port; yields the URL of the server.

    Args:
        device: A port with modem status lines, which `socket://` emulates; a pseudo-terminal has none.
    """
    stopping = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as listener, serial.serial_for_url(device, 38400, timeout=0) as port:

        def serve() -> None:
            client, _ = listener.accept()
            # Its type hints are narrower than its documentation, which accepts any port and any object with `write`.
            manager = PortManager(cast(Any, port), cast(Any, SimpleNamespace(write=client.sendall)))
            ends: list[Any] = [client, port]
            with client, contextlib.suppress(ConnectionError):
                while not stopping.is_set():
                    ready, _, _ = select.select(ends, [], [], 0.02)
                    if client in ready:
                        data = client.recv(1000)
                        if not data:
                            return
                        port.write(b"".join(manager.filter(data)))
                    if port in ready:
                        client.sendall(b"".join(manager.escape(port.read(1000))))

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield f"rfc2217://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            stopping.set()
            thread.join()
