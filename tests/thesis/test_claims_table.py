"""Claims under many laboratories: the table on disk, and the table of a page."""

import json
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from khepera_forage import Decisions, Noise
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.thesis.claims import Claim, Verdict
from khepera_forage.thesis.inference import claims_table
from khepera_forage.thesis.inference.chunks import joined
from khepera_forage.thesis.inference.claims_table import (
    CLAIMS,
    ClaimsContents,
    MeasuredClaims,
    delete_claims,
    measure,
    verdict_table,
)
from khepera_forage.thesis.inference.laboratory_text import laboratory_from_text, laboratory_text
from khepera_forage.thesis.inference.prior import PRIOR, Laboratory

CONTENTS = ClaimsContents(seed=3, replications=5)
HOPELESS = 14
"""Number of the laboratory in which training is never complete."""
SUPPORTED, NOT, UNDECIDED = Verdict


def laboratories(*numbers: int) -> dict[int, Laboratory]:
    """Laboratory k has food at 15 + k pixels."""
    return {k: Laboratory(Decisions(next_to_food=15 + k), Noise.laboratory()) for k in numbers}


class Simulation:
    """Claims without a simulation: their value is that of `next_to_food`, and the calls are counted."""

    def __init__(self) -> None:
        self.measured: list[float] = []
        self.seeds: list[int] = []

    def claims_of(self, laboratory: Laboratory, seed: int, replications: int) -> list[Claim]:
        value = float(laboratory.decisions.next_to_food)
        if value == 15 + HOPELESS:
            raise IncompleteTrainingError("none of 200 attempts was complete")
        self.measured.append(value)
        self.seeds.append(seed)
        verdict = SUPPORTED if value > 17 else NOT
        return [replace(claim, value=value, low=-1.0, high=99.0, verdict=verdict) for claim in CLAIMS]


@pytest.fixture
def simulation(monkeypatch: pytest.MonkeyPatch) -> Simulation:
    simulation = Simulation()
    monkeypatch.setattr(claims_table, "claims_of", simulation.claims_of)
    return simulation


def measured(folder: Path, *numbers: int, contents: ClaimsContents = CONTENTS) -> MeasuredClaims:
    return joined(list(measure(folder, laboratories(*numbers), contents, batch=2)))


def by_hand(verdicts: Iterable[str], effects: Iterable[float] = ()) -> MeasuredClaims:
    """The same verdict on all claims under a laboratory; an empty one was not measured."""
    given = np.array(list(verdicts))
    values = np.array(list(effects) or [1.0] * len(given))
    return MeasuredClaims(
        np.arange(len(given)),
        np.full(len(given), "{}"),
        np.where(given == "", "some reason", ""),
        np.repeat(given[:, None], len(CLAIMS), axis=1),
        np.where(given == "", np.nan, values)[:, None, None].repeat(len(CLAIMS), 1).repeat(3, 2),
    )


def test_measured_claims_are_read_as_they_were_written(tmp_path: Path, simulation: Simulation) -> None:
    first = measured(tmp_path, 0, 1, 2, 3, 4)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "claims_000000.npz",
        "claims_000002.npz",
        "claims_000004.npz",
    ]
    again = measured(tmp_path, 0, 1, 2, 3, 4)
    assert simulation.measured == [15, 16, 17, 18, 19]
    assert len(set(simulation.seeds)) == 5
    for name in MeasuredClaims._fields:
        assert np.array_equal(getattr(first, name), getattr(again, name)), name
    assert first.verdicts[:, 0].tolist() == [NOT, NOT, NOT, SUPPORTED, SUPPORTED]
    assert first.effects[2, 5].tolist() == [17, -1, 99]
    assert laboratory_from_text(first.laboratories[4]) == laboratories(4)[4]


def test_killed_run_continues(tmp_path: Path, simulation: Simulation) -> None:
    run = measure(tmp_path, laboratories(0, 1, 2, 3, 4), CONTENTS, batch=2)
    next(run)
    del run
    (tmp_path / "claims_000002.npz.part").write_bytes(b"half")
    assert simulation.measured == [15, 16]
    assert measured(tmp_path, 0, 1, 2, 3, 4).numbers.tolist() == [0, 1, 2, 3, 4]
    assert simulation.measured == [15, 16, 17, 18, 19]


def test_only_new_laboratories_are_measured(tmp_path: Path, simulation: Simulation) -> None:
    measured(tmp_path, 0, 2, 4)
    assert measured(tmp_path, 1, 2).numbers.tolist() == [2, 1]
    assert simulation.measured == [15, 17, 19, 16]
    assert measured(tmp_path, 4).numbers.tolist() == [4]


def test_a_laboratory_has_the_same_seed_in_every_run(tmp_path: Path, simulation: Simulation) -> None:
    measured(tmp_path / "one", 0, 1, 2)
    measured(tmp_path / "two", 2)
    assert simulation.seeds[2] == simulation.seeds[3]


def test_laboratory_without_complete_training_has_a_reason(tmp_path: Path, simulation: Simulation) -> None:
    for _ in range(2):
        found = measured(tmp_path, 4, HOPELESS)
        assert found.reasons.tolist() == ["", "none of 200 attempts was complete"]
        assert found.verdicts[1].tolist() == [""] * len(CLAIMS)
        assert np.isnan(found.effects[1]).all()
    assert simulation.measured == [19]


def test_select_gives_rows_in_order_and_as_often_as_wanted(tmp_path: Path, simulation: Simulation) -> None:
    found = measured(tmp_path, 0, 1, 2)
    chosen = found.select([2, 0, 2])
    assert chosen.numbers.tolist() == [2, 0, 2]
    assert chosen.effects[:, 0, 0].tolist() == [17, 15, 17]
    with pytest.raises(ValueError, match="laboratory 7 is not measured; allowed: 3 other numbers"):
        found.select([0, 7])


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"seed": 4}, "claims_000000.npz: made with seed 3; allowed: the same as in this run"),
        ({"replications": 6}, "claims_000000.npz: made with replications 5; allowed"),
        ({"claims": ("one",)}, "claims_000000.npz: made with another claims; allowed"),
    ],
)
def test_file_of_another_run_is_an_error(
    tmp_path: Path, simulation: Simulation, changed: dict[str, object], message: str
) -> None:
    measured(tmp_path, 0)
    with pytest.raises(ValueError, match=message):
        measured(tmp_path, 0, contents=replace(CONTENTS, **changed))  # type: ignore[arg-type]


def test_another_laboratory_of_the_same_number_is_an_error(tmp_path: Path, simulation: Simulation) -> None:
    measured(tmp_path, 0, 1)
    with pytest.raises(
        ValueError, match=r"claims_000000.npz: laboratory 1 is another one; allowed: the same"
    ):
        list(measure(tmp_path, {1: laboratories(9)[9]}, CONTENTS))


def test_laboratory_of_a_file_may_leave_out_what_is_as_in_version_0_1(
    tmp_path: Path, simulation: Simulation, monkeypatch: pytest.MonkeyPatch
) -> None:
    def short(laboratory: Laboratory) -> str:
        changed = laboratory.decisions.differing(Decisions.v0_1())
        parts = json.loads(laboratory_text(laboratory))
        return json.dumps({**parts, "decisions": {name: own for name, (own, _) in changed.items()}})

    with monkeypatch.context() as patch:
        patch.setattr(claims_table, "laboratory_text", short)
        measured(tmp_path, 0, 1)
    (known,) = measure(tmp_path, laboratories(0, 1), CONTENTS)
    assert known.numbers.tolist() == [0, 1]
    with pytest.raises(ValueError, match="laboratory 1 is another one"):
        list(measure(tmp_path, {1: laboratories(9)[9]}, CONTENTS))


def test_damaged_or_foreign_file_is_an_error_that_names_it(tmp_path: Path, simulation: Simulation) -> None:
    measured(tmp_path, 0)
    path = tmp_path / "claims_000000.npz"
    whole = path.read_bytes()
    flipped = bytearray(whole)
    for place in range(len(whole) // 3, len(whole) // 3 + 100):
        flipped[place] ^= 0xFF
    np.savez_compressed(tmp_path / "other.npz", contents=np.array("{}"), numbers=np.arange(2))
    np.save(tmp_path / "array.npy", np.arange(3))
    foreign = [(tmp_path / name).read_bytes() for name in ("other.npz", "array.npy")]
    for damaged in (b"", whole[: len(whole) // 2], bytes(flipped), b"text" * 50, *foreign):
        path.write_bytes(damaged)
        with pytest.raises(
            ValueError, match=r"claims_000000.npz: .+; allowed: claims under laboratories; delete the file"
        ):
            measured(tmp_path, 0)
    delete_claims(tmp_path)
    assert measured(tmp_path, 0).numbers.tolist() == [0]


def test_verdict_table_has_shares_with_intervals_and_the_median_effect() -> None:
    prior = by_hand([SUPPORTED, NOT, UNDECIDED, SUPPORTED, ""])
    posterior = by_hand([SUPPORTED] * 3, [2.0, 5.0, np.nan])
    table = verdict_table(prior, posterior)
    assert len(table.rows) == len(CLAIMS)
    assert "Share of 4 admissible laboratories of the prior, and of 3 laboratories" in table.note
    assert (
        "| More episodes improve the learner (corridor) | 5.4.1.2 | 50 [15, 85] | 100 [44, 100] | +3.5 points |"
        in (table.markdown())
    )
    generalises = next(row for row in table.rows if str(row[0]).startswith("The learner generalises"))
    assert generalises[-1] == "+350 points", "a difference of shares is shown in percentage points"


def test_verdict_table_without_a_posterior_has_dashes() -> None:
    assert (
        "| 5.4.1.2 | 100 [21, 100] | - | - |" in verdict_table(by_hand([SUPPORTED]), by_hand([])).markdown()
    )


def test_text_of_a_laboratory_describes_it() -> None:
    laboratory = PRIOR.draw(np.random.default_rng(1))
    assert laboratory_from_text(laboratory_text(laboratory)) == laboratory
    for wrong in ("", "17", '{"decisions": {"next_to_foot": 1}, "noise": {}}', '{"noise": {}}'):
        with pytest.raises(ValueError, match="is no laboratory: "):
            laboratory_from_text(wrong)
