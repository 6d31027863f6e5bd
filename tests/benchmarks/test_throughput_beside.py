"""`benchmarks/throughput.py --beside COMMIT`: both checkouts are measured, and nothing of them is left."""

import os
import subprocess
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
from timing.beside import CASES, Case, CaseError, Timed, page, pairs, value_of
from timing.beside_cases import CASES as FUNCTIONS
from timing.checkouts import Checkout, checkouts, commit_id

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import ROOT, command_of, help_of, read, refused

VERSIONS = (
    Checkout("b91f85b", "b91f85b", Path("commit"), Path("commit_kernels")),
    Checkout("this checkout", "1234567", Path("this"), Path("this_kernels")),
)
in_a_checkout = pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs a git checkout")


def git(folder: Path, *arguments: str) -> str:
    identity = ("-c", "user.name=Test", "-c", "user.email=test@example.org")
    done = subprocess.run(
        ["git", "-C", folder, *identity, *arguments], check=True, capture_output=True, text=True
    )
    return done.stdout.strip()


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A repository whose first commit has no package; the second has one, edited since."""
    root = tmp_path / "repository"
    root.mkdir()
    git(root, "init", "--quiet")
    git(root, "commit", "--quiet", "--allow-empty", "-m", "Begin")
    (root / "khepera_forage").mkdir()
    source = root / "khepera_forage" / "__init__.py"
    source.write_text("committed = True\n")
    git(root, "add", ".")
    git(root, "commit", "--quiet", "-m", "Add the package")
    source.write_text("committed = False\n")
    return root


def table(rows: list[Timed]) -> dict[str, str]:
    """Each line of the page's table as printed, by the label of its case."""
    text = page(rows, *VERSIONS, repeats=7, quick=False).tables[0].markdown()
    return {line.split(" | ")[0].strip("| "): line for line in text.splitlines() if line.startswith("| ")}


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="needs cores that can be chosen")
def test_pairs_of_a_case_with_one_thread_take_turns_between_the_cores() -> None:
    cores = sorted(os.sched_getaffinity(0))
    for case in CASES:
        own = pairs([case], VERSIONS, repeats=len(cores) + 1, quick=True, seed=0)
        chosen = [pair.core for pair in own if pair.number >= 0]
        one_thread = case.name in ("pymunk", "one_world")
        assert chosen == ([*cores, cores[0]] if one_thread else [None] * len(chosen)), case.name


@in_a_checkout
def test_comparison_of_a_commit_is_written_and_printed(quick_run: QuickRun) -> None:
    out = quick_run("throughput", "--beside", "HEAD", "--only", "pymunk")
    rows = read(out / "beside.csv")
    head = rows[0]["checkout"]
    assert git(ROOT, "rev-parse", "--short", head) == head
    assert [(row["pair"], row["checkout"]) for row in rows] == [
        (pair, checkout) for pair in "01" for checkout in (head, "this checkout")
    ]
    assert all(float(row["value"]) > 0 for row in rows)
    text = (out / "beside.md").read_text(encoding="utf-8")
    assert f"beside commit {head}" in text
    assert " --beside HEAD --only pymunk\n" in text
    line = next(line for line in text.splitlines() if line.startswith("| Corridor-v0 on pymunk"))
    assert "at least 0.60" in line
    assert line in (out.parent / "printed").read_text(encoding="utf-8")


def test_help_names_every_case() -> None:
    told = help_of("throughput")
    assert all(word in told for word in ("--beside COMMIT", "--only", *FUNCTIONS))


def test_every_case_has_a_function() -> None:
    assert [case.name for case in CASES] == list(FUNCTIONS)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_case_measures_this_version(case: Case) -> None:
    if case.name != "pymunk" and find_spec("numba") is None:
        pytest.skip("compiled worlds need numba, the extra `fast`")
    assert value_of(case.name, case.quick, 1, ROOT) > 0


def test_case_finds_names_of_the_older_version(tmp_path: Path) -> None:
    folder = tmp_path / "khepera_forage" / "envs" / "batch"
    folder.mkdir(parents=True)
    for package in (folder, folder.parent, folder.parents[1]):
        (package / "__init__.py").touch()
    (folder / "episodes.py").write_text("def run_teacher(arena, episodes, seed): assert episodes == 128\n")
    assert value_of("first_run_teacher", 128, 1, tmp_path) > 0
    with pytest.raises(CaseError, match=r"case first_train_learners failed .* has none of .*train_learners"):
        value_of("first_train_learners", 128, 1, tmp_path)


def test_case_on_another_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"case pymunk measured the package in .*; allowed: the one in "):
        value_of("pymunk", 10, 1, tmp_path)


def test_checkouts_alternate_and_first_calls_need_fewer_pairs() -> None:
    units = pairs([CASES[0], CASES[-1]], VERSIONS, repeats=5, quick=False, seed=1)
    assert [unit.number for unit in units if not unit.case.first_call] == [-1, 0, 1, 2, 3, 4]
    assert [unit.number for unit in units if unit.case.first_call] == [-1, 0, 1, 2]
    assert [unit.size for unit in units[:3:2]] == [CASES[0].quick, CASES[0].size]


def test_ratio_is_the_median_of_pairs_and_is_compared_with_its_target() -> None:
    def rows(case: str, *values: tuple[float, float]) -> list[Timed]:
        return [
            Timed(case, pair, version.name, value)
            for pair, both in enumerate(values)
            for version, value in zip(VERSIONS, both, strict=True)
        ]

    speed = rows("make_vec", (100.0, 80.0), (200.0, 180.0), (100.0, 95.0))
    slow = rows("one_world", (1000.0, 800.0))
    time = rows("design", (10.0, 30.0))
    lines = table([*speed, *slow, *time])
    expected = {
        "Corridor-v0 of make_vec, 4,096 worlds": "| 100.0 | 95.0 | 0.90 [0.80, 0.95] | at least 0.35 | yes |",
        "one compiled Corridor-v0, resets included": "| 1,000 | 800.0 | 0.80 [0.80, 0.80] | at least 0.60 | yes |",
        "1,000 replications of the thesis's design, without the report": "| 3.00 [3.00, 3.00] | at most 4.00 | yes |",
    }
    for label, end in expected.items():
        assert lines[label].endswith(end)


def test_checkouts_hold_the_commit_and_the_edited_files(repository: Path) -> None:
    before = git(repository, "status", "--porcelain")
    with checkouts("HEAD", repository) as (theirs, ours):
        sources = [(each.root / "khepera_forage" / "__init__.py").read_text() for each in (theirs, ours)]
        assert all(not each.cache.is_relative_to(each.root) for each in (theirs, ours))
    assert sources == ["committed = True\n", "committed = False\n"]
    assert theirs.name == commit_id("HEAD", repository)
    assert ours.version == f"{theirs.version} with uncommitted changes"
    assert not theirs.root.parent.exists()
    assert git(repository, "status", "--porcelain") == before
    assert len(git(repository, "worktree", "list").splitlines()) == 1


def test_checkouts_are_removed_after_an_error(repository: Path) -> None:
    with pytest.raises(KeyboardInterrupt), checkouts("HEAD", repository) as (theirs, _):
        raise KeyboardInterrupt
    assert not theirs.root.parent.exists()


@in_a_checkout
def test_checkouts_are_removed_after_a_signal(tmp_path: Path) -> None:
    command = command_of("throughput", "--beside", "HEAD", "--only", "pymunk", "--out", str(tmp_path / "out"))
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    running = subprocess.Popen(command, env={**os.environ, "TMPDIR": str(temporary)})
    until = time.monotonic() + 60
    while not list(temporary.glob("beside-*/this/khepera_forage")) and time.monotonic() < until:
        time.sleep(0.05)
    running.terminate()
    assert running.wait(timeout=60) == 128 + 15
    assert not list(temporary.glob("beside-*"))


def test_unknown_commits_and_other_folders_are_refused(repository: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"commit 'nowhere' is unknown in .*; allowed: an id, branch or tag"):
        commit_id("nowhere", repository)
    with pytest.raises(ValueError, match=r"commit 'HEAD~1' .* has no folder khepera_forage"):
        commit_id("HEAD~1", repository)
    with pytest.raises(ValueError, match="is not a git checkout"):
        commit_id("HEAD", tmp_path)


@in_a_checkout
def test_refusals_have_no_traceback() -> None:
    assert "throughput.py: commit 'nowhere' is unknown" in refused("throughput", "--beside", "nowhere")


def test_arguments_that_exclude_each_other_are_refused() -> None:
    assert "--beside measures nothing else" in refused("throughput", "--beside", "HEAD", "--compiled")
    assert "--only selects cases of --beside" in refused("throughput", "--only", "pymunk")
