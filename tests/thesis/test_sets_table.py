"""The table of simulated sets: what is written is read, and nothing else."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from khepera_forage import Decisions, Noise
from khepera_forage.thesis.inference.admissible import Check
from khepera_forage.thesis.inference.prior import Laboratory
from khepera_forage.thesis.inference.simulate import Simulated
from khepera_forage.thesis.inference.table import (
    Contents,
    Sets,
    delete_chunks,
    joined,
    read_chunk,
    sets_of,
    write_chunk,
)

pytest.importorskip("numba")
CONTENTS = Contents(seed=3, experiments=2, chunk=2, prior="some prior")
WIDTH = len(CONTENTS.statistics)


def some_sets(first: int = 0) -> Sets:
    laboratory = Laboratory(Decisions(next_to_food=17), Noise.laboratory())
    fine = Simulated(
        laboratory, Check("", (1.0, 0.99), (60, 170), 0.9), np.arange(2.0 * WIDTH).reshape(2, WIDTH)
    )
    poor = Simulated(
        laboratory, Check("too slow in the corridor", (1.0, np.nan), (90, np.nan), np.nan), np.zeros((0, 0))
    )
    return sets_of(first, [fine, poor], 2)


def test_chunk_is_read_as_it_was_written(tmp_path: Path) -> None:
    sets = some_sets(first=8)
    write_chunk(tmp_path, 4, CONTENTS, sets)
    assert read_chunk(tmp_path, 3, CONTENTS) is None
    again = read_chunk(tmp_path, 4, CONTENTS)
    assert again is not None
    for name in Sets._fields:
        assert np.array_equal(
            getattr(again, name), getattr(sets, name), equal_nan=name not in ("laboratories", "reasons")
        )
    assert again.numbers.tolist() == [8, 9]
    assert again.reasons.tolist() == ["", "too slow in the corridor"]
    assert np.isnan(again.statistics[1]).all()
    stored = json.loads(again.laboratories[0])
    assert stored == {
        "decisions": asdict(Decisions(next_to_food=17)),
        "noise": asdict(Noise.laboratory()),
    }
    assert not list(tmp_path.glob("*.part"))


def test_chunks_are_joined_in_order() -> None:
    assert joined([some_sets(0), some_sets(2)]).numbers.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"seed": 4}, "made with seed 3; allowed: the same as in this run"),
        ({"experiments": 5}, "made with experiments 2; allowed"),
        ({"prior": "another prior of the same fields"}, "made with another prior; allowed"),
        ({"statistics": ("fewer",)}, "made with another statistics; allowed"),
    ],
)
def test_chunk_of_another_run_is_an_error(tmp_path: Path, changed: dict[str, object], message: str) -> None:
    write_chunk(tmp_path, 0, CONTENTS, some_sets())
    other = Contents(**({"seed": 3, "experiments": 2, "chunk": 2, "prior": "some prior"} | changed))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message):
        read_chunk(tmp_path, 0, other)


def test_damaged_chunk_is_an_error_that_names_the_file(tmp_path: Path) -> None:
    write_chunk(tmp_path, 0, CONTENTS, some_sets())
    path = tmp_path / "sets_00000.npz"
    whole = path.read_bytes()
    for damaged in (b"", whole[: len(whole) // 2], b"text" * 50):
        path.write_bytes(damaged)
        with pytest.raises(
            ValueError, match=r"sets_00000.npz: .*allowed: a chunk of simulated sets; delete the file"
        ):
            read_chunk(tmp_path, 0, CONTENTS)
    delete_chunks(tmp_path)
    assert read_chunk(tmp_path, 0, CONTENTS) is None
