"""Learners from other packages: registered, installed, or named as text."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sklearn.ensemble import RandomForestClassifier
from sklearn.naive_bayes import GaussianNB

import khepera_forage
from khepera_forage.cli.main import main
from khepera_forage.experience import Experience
from khepera_forage.policies import as_policy, register_learner
from khepera_forage.policies.learner_registry import LearnerError, installed_learners, learner_at, own_errors
from khepera_forage.policies.learners import LEARNERS, OfflineImitation

X = np.array([[0, 90, 0, 215, 60], [0, 50, 0, 215, 18], [1, 48, 0, 255, 14], [1, 48, 1, 215, 14]] * 3)
Y = np.array([0, 2, 3, 7] * 3)


@pytest.fixture(autouse=True)
def own_registry(monkeypatch: pytest.MonkeyPatch) -> None:
    known = dict(LEARNERS)
    monkeypatch.setattr("khepera_forage.policies.learner_registry.LEARNERS", known)


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A package as pip installs it, with entry points: some cannot be used."""
    name = "learners_of_a_test"
    (tmp_path / f"{name}.py").write_text(
        "from sklearn.ensemble import RandomForestClassifier\n"
        "def forest(random_state=None):\n"
        "    return RandomForestClassifier(3, random_state=random_state)\n"
        "number = 7\n"
    )
    (tmp_path / f"{name}_exits.py").write_text("raise SystemExit('no license')\n")
    info = tmp_path / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        f"[khepera_forage.learners]\nforest = {name}:forest\nmissing = {name}:missing\n"
        f"number = {name}:number\ntree = {name}:forest\nbad name = {name}:forest\n"
        f"forest = {name}_exits:forest\nexits = {name}_exits:forest\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)
    yield name
    sys.modules.pop(name, None)


def test_a_registered_learner_learns_and_decides() -> None:
    learner = register_learner("forest", RandomForestClassifier)
    assert isinstance(learner, OfflineImitation)
    assert (learner.title, learner.seeded, learner.diagonal) == ("forest", True, False)
    one, other = (learner.learn(X, Y, seed=3) for _ in range(2))
    assert one.act(X[2], np.random.default_rng(0)) == other.act(X[2], np.random.default_rng(0))
    assert register_learner("forest", RandomForestClassifier) == learner, "a second time changes nothing"
    described = OfflineImitation("naive Bayes", GaussianNB, sample=False)
    assert register_learner("naive_bayes", described) is described


def test_names_are_checked() -> None:
    for name in ("my forest", 3):
        with pytest.raises(ValueError, match=f"name of a learner is {name!r}; allowed: letters, digits"):
            register_learner(name, GaussianNB)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="name of a learner is 'tree', as that of another"):
        register_learner("tree", GaussianNB)


def test_what_makes_no_classifier_is_refused() -> None:
    with pytest.raises(
        TypeError, match=r"learner mine is .*; allowed: OfflineImitation, InteractiveImitation, ReinforcementLearner"
    ):
        register_learner("mine", GaussianNB())


def test_learners_of_installed_packages_are_found(package: str) -> None:
    found = installed_learners()
    assert set(found.learners) == {"forest"}
    forest = found.learners["forest"]
    assert isinstance(forest, OfflineImitation)
    assert as_policy(forest.classifier(seed=1).fit(X, Y)).act(X[0], np.random.default_rng(0)) in Y
    assert set(found.broken) == {"missing", "number", "tree", "bad name", "forest", "exits"}
    assert found.broken["missing"].startswith(f"{package}:missing: AttributeError")
    assert "TypeError: learner number is 7" in found.broken["number"]
    assert found.broken["exits"].endswith("SystemExit: no license")
    for name in ("tree", "forest"):
        assert "its name is that of another learner" in found.broken[name]
    assert found.broken["bad name"].endswith(
        "name of a learner is 'bad name'; allowed: letters, digits and underscores"
    )


def test_commands_say_why_a_learner_of_a_package_is_broken(
    package: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    reason = f"{package}:missing: AttributeError: module '{package}' has no attribute 'missing'"
    taking_part: list[str] = []
    monkeypatch.setattr("khepera_forage.comparison.protocol.run", lambda _, found, __: taking_part.extend(found))
    for command in ("compare --list", "compare --protocol"):
        assert not main(command.split())
        assert f"\nmissing is left out: {reason}\n" in f"\n{capsys.readouterr().out}"
    assert {"tree", "forest"} <= set(taking_part), "ours, and that of the package"
    Experience([(0, 60, 0, 215, 40)], [0]).save("g1.csv")
    for words in ("compare --only", "recall --experience g1.csv --learner"):
        assert main([*words.split(), "missing"]) == 2
        told = capsys.readouterr().err
        assert f"{words.split()[-1]} is 'missing', which cannot be used ({reason}); allowed: " in told


def test_error_in_a_package_whose_name_begins_like_ours_shows_where_it_is() -> None:
    names: dict[str, Any] = {}
    place = Path(khepera_forage.__file__).parent.with_name("khepera_forage_mine") / "learner.py"
    exec(compile("def fit(): raise IndexError('too late')", str(place), "exec"), names)
    with pytest.raises(LearnerError, match=r"mine failed\n(.|\n)*IndexError: too late"), own_errors("mine"):
        names["fit"]()


@pytest.mark.parametrize("place", ["nowhere:forest", "{0}", ":forest", "./{0}.py:forest", "{0}:missing", "{0}:number"])
def test_a_wrong_place_is_named(place: str, package: str) -> None:
    place = place.format(package)
    with pytest.raises(ValueError, match=f"learner is '{place}'.*; allowed: .*what makes a classifier$"):
        learner_at(place)
