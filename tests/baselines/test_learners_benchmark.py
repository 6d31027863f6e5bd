"""`khepera-forage compare` with the reinforcement learners: a row each, beside an imitator's."""

from pathlib import Path

from khepera_forage.policies.learners import LEARNERS, Supervision
from tests.benchmarks.running import is_picture, quick, read

FROM_STEPS = [name for name, learner in LEARNERS.items() if learner.needs is Supervision.STEPS]


def test_benchmark_has_rows_of_reinforcement_learners(tmp_path: Path) -> None:
    out = tmp_path / "learners"
    names = ["imitator", *FROM_STEPS]
    only = [part for name in names for part in ("--only", name)]
    quick("learners", out, *only, "--seeds", "1", "--jobs", "1")
    rows = read(out / "rows.csv")
    assert [row["learner"] for row in rows] == ["imitator"] * 4 + [name for name in FROM_STEPS for _ in range(2)]
    for row in rows[4:]:
        assert int(row["steps"]) >= int(row["amount"]) == 1_000
        assert int(row["vectors"]) == 0
        assert float(row["seconds"]) > 0
    page = (out / "learners.md").read_text(encoding="utf-8")
    assert all(f"| `{name}` | {LEARNERS[name].title} | `" in page for name in names)
    assert is_picture(out / "learners.png")
