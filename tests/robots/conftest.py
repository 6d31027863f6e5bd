import os
import threading
from collections.abc import Iterator

import pytest

from tests.robots.rig import Rig, make_stage


@pytest.fixture
def stage() -> Rig:
    """A virtual robot in an open arena."""
    return make_stage()


@pytest.fixture(params=[None, 0], ids=["pty", "tcp"])
def tcp(request: pytest.FixtureRequest) -> int | None:
    """Both kinds of endpoint: a pseudo-terminal, or TCP port 0."""
    port: int | None = request.param
    return port


@pytest.fixture
def no_leaks() -> Iterator[None]:
    """Check that the test leaves no thread and no open file."""
    threads, files = threading.active_count(), len(os.listdir("/proc/self/fd"))
    yield
    assert threading.active_count() <= threads
    assert len(os.listdir("/proc/self/fd")) <= files
