"""`benchmarks/backends.py`: without ORIENT nobody delivers, and both backends have the same episodes."""

from pathlib import Path

import gymnasium as gym
import pytest

from khepera_forage.envs import paired_corridors_v1
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("numba")

from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.rollouts.compiled.training import train_learners

BACKENDS = ("pymunk", "compiled")


@pytest.fixture(scope="module")
def kernels() -> None:
    """All kernels, compiled before other processes need them: one process takes half the time of several."""
    gym.make("khepera_forage/Corridor-v1", backend="compiled").reset(seed=0)
    run_teacher("corridor", 1)
    train_learners(1)
    paired_corridors_v1.vector_env(1).reset(seed=0)
    paired_corridors_v1.parallel_env(backend="compiled").reset(seed=0)


@pytest.fixture(scope="module")
def out(kernels: None, quick_run: QuickRun) -> Path:
    return quick_run("backends")


def test_teacher_delivers_nearly_all_food_and_needs_orient(out: Path) -> None:
    lines = read(out / "table_deliveries.csv")
    assert {line["arenas"] for line in lines} == {"corridor", "rectangle", *FAMILY, *DIFFICULTIES, "all procedural"}
    for line in lines:
        for backend in BACKENDS:
            share = line[f"{backend}: delivered (%)"]
            assert line["policy"] != "SEARCH for ORIENT" or float(share) == 0
            if line["arenas"] in ("corridor", "rectangle") and line["policy"] == "teacher":
                assert share == "" if line["food"] == "POISONOUS" else float(share) > 90
                assert line[f"{backend}: poison brought home"] == "0"
            steps = [float(line[f"{backend}: steps{end}"]) for end in (": low", "", ": high")]
            assert steps == sorted(steps)


def test_both_backends_have_the_same_recalls_and_lines_share_their_starts(out: Path) -> None:
    rows = [row for row in read(out / "recalls.csv") if row["part"] != "imitators"]
    names = ("policy", "arena", "level", "food", "seed", "foods", "deliverable")
    one, other = (
        sorted([row[name] for name in names] for row in rows if row["backend"] == backend) for backend in BACKENDS
    )
    assert one == other
    for arena in ("corridor", "rectangle"):
        seeds: dict[tuple[str, str], list[str]] = {}
        for policy, place, _, food, seed, *_ in one:
            if place == arena:
                seeds.setdefault((policy, food), []).append(seed)
        assert len(seeds) == 4
        assert len(set(map(tuple, seeds.values()))) == 1


def sides_of(line: dict[str, str], rows: list[dict[str, str]]) -> list[list[dict[str, str]]]:
    """The rows of a line in a table, on each backend."""
    arena = line.get("arena") or line["arenas"]
    arenas = list(DIFFICULTIES) if arena == "all procedural" else [arena]
    keys = [key for key in ("policy", "food") if key in line]
    own = [row for row in rows if row["arena"] in arenas and all(row[key] == line[key] for key in keys)]
    return [[row for row in own if row["backend"] == backend] for backend in BACKENDS]


def test_tables_count_what_the_rows_hold(out: Path) -> None:
    rows = read(out / "recalls.csv")
    for line in read(out / "table_deliveries.csv"):
        for backend, own in zip(BACKENDS, sides_of(line, rows), strict=True):
            assert len(own) == int(line["recalls"])
            deliverable = sum(int(row["deliverable"]) for row in own)
            if deliverable:
                share = 100.0 * sum(int(row["delivered"]) for row in own) / deliverable
                assert float(line[f"{backend}: delivered (%)"]) == pytest.approx(share, abs=0.01)


def ended(row: dict[str, str]) -> bool:
    """Whether a training episode is complete, or a recall delivered everything."""
    return row["complete"] == "1" if "complete" in row else row["delivered"] == row["deliverable"]


def test_episodes_are_compared_pair_by_pair(out: Path) -> None:
    for table, rows in (("backends", "recalls"), ("trainings", "trainings")):
        for line in read(out / f"table_{table}.csv"):
            sides = sides_of(line, read(out / f"{rows}.csv"))
            same = sum(row["same"] == "1" for row in sides[0])
            assert float(line["the same (%)"]) == pytest.approx(100 * same / len(sides[0]), abs=0.01)
            pairs = [(ended(one), ended(other)) for one, other in zip(*sides, strict=True)]
            ends = {"pymunk only": (True, False), "compiled only": (False, True), "both": (True, True)}
            ends["neither"] = (False, False)
            assert {name: int(line[name]) for name in ends} == {name: pairs.count(end) for name, end in ends.items()}
            assert int(line["episodes"]) == len(pairs)
            for one, other in zip(*sides, strict=True):
                assert one["same"] == "0" or one | {"backend": ""} == other | {"backend": ""}
