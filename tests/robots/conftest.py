import os
import threading
from collections.abc import Iterator

import pytest

from tests.robots.stage import Stage, staged


@pytest.fixture
def stage() -> Stage:
    """A virtual robot in an open arena."""
    return staged()


@pytest.fixture(params=[None, 0], ids=["pty", "tcp"])
def tcp(request: pytest.FixtureRequest) -> int | None:
    """Either kind of virtual line."""
    port: int | None = request.param
    return port


@pytest.fixture
def nothing_left_behind() -> Iterator[None]:
    """The test leaves no thread and no open file."""
    threads, files = threading.active_count(), len(os.listdir("/proc/self/fd"))
    yield
    assert threading.active_count() <= threads
    assert len(os.listdir("/proc/self/fd")) <= files
