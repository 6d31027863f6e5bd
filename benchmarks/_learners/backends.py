"""Where units are done: processes of this machine, or the workers of a Ray or a Dask cluster.

A cluster needs this package installed on its workers; the rooms of this benchmark are sent there.
"""

import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from joblib import Parallel, cpu_count, delayed, parallel_config

from _learners.rows import Batch
from _learners.units import Unit

ROOMS = Path(__file__).parent


class Workers(NamedTuple):
    """Who works.

    Attributes:
        title: What they are, for people.
        number: How many.
        streams: Whether the backend hands over each unit as it is done; Ray's gives all of them at the end.
    """

    title: str
    number: int
    streams: bool = True

    def done(self, units: Sequence[Unit]) -> Iterator[list[Batch]]:
        """The rows of each unit, soon after it is done and in whatever order."""
        if self.streams:
            yield from Parallel(return_as="generator_unordered", batch_size=1)(map(delayed(Unit.run), units))
            return
        with Parallel(batch_size=1) as workers:
            # In portions: what is killed loses no more than one.
            for start in range(0, len(units), 2 * self.number):
                yield from workers(map(delayed(Unit.run), units[start : start + 2 * self.number]))


@contextmanager
def loky(jobs: int, address: str | None) -> Iterator[Workers]:
    """Processes of this machine, which have no address."""
    with parallel_config("loky", n_jobs=jobs):
        yield Workers("processes of this machine", _count(jobs))


@contextmanager
def ray(jobs: int, address: str | None) -> Iterator[Workers]:
    """The cluster at an address, or one of this machine for as long as this lasts."""
    import ray
    from ray.util.joblib import register_ray

    register_ray()
    here: dict[str, Any] = {} if address else {"num_cpus": _count(jobs), "include_dashboard": False}
    ray.init(
        address=address,
        runtime_env={"py_modules": [str(ROOMS)]},
        log_to_driver=False,
        logging_level="error",
        **here,
    )
    try:
        workers = int(ray.cluster_resources()["CPU"])
        with parallel_config("ray", n_jobs=workers):
            yield Workers("workers of Ray", workers, streams=False)
    finally:
        ray.shutdown()


@contextmanager
def dask(jobs: int, address: str | None) -> Iterator[Workers]:
    """The cluster at an address, or one of this machine for as long as this lasts.

    Raises:
        SystemExit: A worker with several threads: learners whose libraries draw from global sources of chance would
            draw from each other's.
    """
    from distributed import Client, LocalCluster

    with ExitStack() as stack:
        folder = stack.enter_context(TemporaryDirectory())
        here = {"n_workers": _count(jobs), "threads_per_worker": 1, "dashboard_address": None}
        cluster = address or stack.enter_context(LocalCluster(**here))
        client = stack.enter_context(Client(cluster))
        client.upload_file(shutil.make_archive(f"{folder}/rooms", "zip", ROOMS.parent, ROOMS.name))
        threads = list(client.nthreads().values())
        if max(threads, default=1) > 1:
            sys.exit(f"a worker of Dask has {max(threads)} threads; allowed: 1 (dask worker --nthreads 1)")
        stack.enter_context(parallel_config("dask", n_jobs=len(threads)))
        yield Workers("workers of Dask", len(threads))


BACKENDS: dict[str, Callable[[int, str | None], AbstractContextManager[Workers]]] = {
    "loky": loky,
    "ray": ray,
    "dask": dask,
}
"""By name: each is given the number of processes and an address."""


def unavailable(backend: str, address: str | None) -> str:
    """Why a backend cannot be used so; empty if it can."""
    if backend == "loky":
        return "" if address is None else f"--address is {address!r}; allowed: with --backend ray or dask"
    if find_spec(backend) is None or (backend == "dask" and find_spec("distributed") is None):
        return f"--backend {backend} needs the extra {backend}: pip install 'khepera-forage[{backend}]'"
    return ""


def _count(jobs: int) -> int:
    return cpu_count() if jobs < 0 else jobs
