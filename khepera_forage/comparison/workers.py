"""Where units run: processes of this machine, or the workers of a Ray or a Dask cluster.

The workers of a cluster need `khepera_forage` installed, and the packages of all learners.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from importlib.util import find_spec
from typing import Any, NamedTuple

from joblib import Parallel, cpu_count, delayed, parallel_config

from khepera_forage.study import Done, Unit, done


class Workers(NamedTuple):
    """Processes that do units.

    Attributes:
        title: For people.
        number: How many.
        streams: Whether the backend returns each unit when it is done; Ray's returns all of them at the end.
    """

    title: str
    number: int
    streams: bool = True

    def execute(self, units: Sequence[Unit]) -> Iterator[Done]:
        """The rows of each unit soon after it is done, in any order."""
        print(f"{len(units)} units for {self.number} {self.title}", flush=True)
        if self.streams:
            yield from Parallel(return_as="generator_unordered", batch_size=1)(map(delayed(done), units))
            return
        with Parallel(batch_size=1) as workers:
            # In portions: a run that is killed loses one portion at most.
            for start in range(0, len(units), 2 * self.number):
                yield from workers(map(delayed(done), units[start : start + 2 * self.number]))


@contextmanager
def loky(jobs: int, address: str | None) -> Iterator[Workers]:
    """Processes of this machine; they have no address."""
    with parallel_config("loky", n_jobs=jobs):
        yield Workers("processes of this machine", _count(jobs))


@contextmanager
def ray(jobs: int, address: str | None) -> Iterator[Workers]:
    """The cluster at an address, or a temporary one on this machine."""
    import ray
    from ray.util.joblib import register_ray

    register_ray()
    here: dict[str, Any] = {} if address else {"num_cpus": _count(jobs), "include_dashboard": False}
    ray.init(
        address=address,
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
    """The cluster at an address, or a temporary one on this machine.

    Raises:
        ValueError: A worker has several threads. Learners whose libraries use global random numbers would share them.
    """
    from distributed import Client, LocalCluster

    with ExitStack() as stack:
        here = {"n_workers": _count(jobs), "threads_per_worker": 1, "dashboard_address": None}
        cluster = address or stack.enter_context(LocalCluster(**here))
        client = stack.enter_context(Client(cluster))
        threads = list(client.nthreads().values())
        if max(threads, default=1) > 1:
            raise ValueError(
                f"a worker of Dask has {max(threads)} threads; allowed: 1 (dask worker --nthreads 1)"
            )
        stack.enter_context(parallel_config("dask", n_jobs=len(threads)))
        yield Workers("workers of Dask", len(threads))


BACKENDS: dict[str, Callable[[int, str | None], AbstractContextManager[Workers]]] = {
    "loky": loky,
    "ray": ray,
    "dask": dask,
}
"""By name; each takes a number of processes and an address."""


def unavailable(backend: str, address: str | None) -> str:
    """Why a backend cannot be used with this address; empty if it can."""
    if backend == "loky":
        return "" if address is None else f"--address is {address!r}; allowed: with --backend ray or dask"
    if find_spec(backend) is None or (backend == "dask" and find_spec("distributed") is None):
        return f"--backend {backend} needs the extra {backend}: pip install 'khepera-forage[{backend}]'"
    return ""


def _count(jobs: int) -> int:
    return cpu_count() if jobs < 0 else jobs
