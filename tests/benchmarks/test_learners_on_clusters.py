"""`khepera-forage compare` on a Dask cluster: the same rows as on one machine (extra `dask`)."""

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest

from tests.benchmarks.running import command_of, read

pytest.importorskip("distributed", reason="needs the extra dask")

WORK = ["--quick", "--only", "tree", "--only", "teacher", "--seeds", "3", "--seed", "1"]


def run(out: Path, *arguments: str) -> str:
    """What a run prints; what a cluster has to say on its way is no matter."""
    command = [*command_of("learners"), *WORK, "--out", str(out), *arguments]
    finished = subprocess.run(command, capture_output=True, text=True, cwd=out.parent, timeout=300)
    assert finished.returncode == 0, finished.stderr
    return finished.stdout


def rows(out: Path) -> list[dict[str, str]]:
    """Rows but for wall times."""
    return [{name: value for name, value in row.items() if name != "seconds"} for row in read(out / "rows.csv")]


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, str]]:
    out = tmp_path_factory.mktemp("here") / "learners"
    run(out, "--jobs", "1")
    return rows(out)


def test_two_workers_make_the_same_rows(here: list[dict[str, str]], tmp_path: Path) -> None:
    with socket.socket() as dashboard:  # of another cluster
        with suppress(OSError):
            dashboard.bind(("", 8787))
        printed = run(tmp_path / "learners", "--backend", "dask", "--jobs", "2")
    assert "6 units for 2 workers of Dask" in printed
    assert rows(tmp_path / "learners") == here


def test_a_worker_that_dies_ends_the_run_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "late.py").write_text(
        "import os\n"
        "from sklearn.tree import DecisionTreeClassifier\n"
        "class Dies(DecisionTreeClassifier):\n"
        "    def fit(self, X, y):\n"
        "        return super().fit(X, y) if len(X) < 150 else os._exit(7)\n"
    )
    work = ["--quick", "--seeds", "1", "--recalls", "1", "--arenas", "corridor", "--learner", "late:Dies"]
    command = [*command_of("learners"), *work, "--backend", "dask", "--jobs", "1", "--out", "out"]
    once = {**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
    finished = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=300, env=once)
    assert finished.returncode == 2
    assert "khepera-forage compare: a process of the work was killed, or died" in finished.stderr


@pytest.fixture
def dask_cluster(tmp_path: Path) -> Iterator[str]:
    """A scheduler and two workers, each a process of its own, in the folders `scheduler` and `worker`."""
    where = tmp_path / "scheduler.json"
    told = ["--scheduler-file", str(where)]
    local = ["--host", "127.0.0.1", "--no-dashboard"]
    with ExitStack() as stack:
        for part in (
            ["scheduler", *told, *local, "--port", "0"],
            *(["worker", *told, *local, "--nthreads", "1", "--no-nanny"] for _ in range(2)),
        ):
            (tmp_path / part[0]).mkdir(exist_ok=True)
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", *part], cwd=tmp_path / part[0], env=os.environ, stderr=subprocess.DEVNULL
            )
            stack.callback(process.wait)
            stack.callback(process.terminate)
        from distributed import Client

        with Client(scheduler_file=str(where), timeout=60) as client:
            client.wait_for_workers(2, timeout=60)
            yield client.scheduler.address


def test_a_cluster_at_an_address_makes_the_same_rows(
    dask_cluster: str, here: list[dict[str, str]], tmp_path: Path
) -> None:
    printed = run(tmp_path / "learners", "--backend", "dask", "--address", dask_cluster)
    assert "6 units for 2 workers of Dask" in printed
    assert rows(tmp_path / "learners") == here


def test_a_learner_that_workers_lack_ends_the_run_in_one_line(dask_cluster: str, tmp_path: Path) -> None:
    here = tmp_path / "scheduler"
    (here / "far.py").write_text("from sklearn.naive_bayes import GaussianNB\nclass Far(GaussianNB): pass\n")
    arguments = ["--quick", "--learner", "far:Far", "--backend", "dask", "--address", dask_cluster]
    command = [*command_of("learners"), *arguments]
    finished = subprocess.run(command, capture_output=True, text=True, cwd=here, timeout=60)
    assert finished.returncode == 2
    assert "khepera-forage compare: Dask cluster: No module named 'far'; allowed: what its scheduler" in finished.stderr
