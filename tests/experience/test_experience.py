"""Experience in memory, saved and loaded, and written vector by vector."""

import contextlib
import os
import pickle
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.experience import Experience, ExperienceError, ExperienceWarning, ExperienceWriter
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.task.states import Behaviour, FoodType, StateVector

DISTANCES = st.one_of(st.integers(0, 177), st.integers(0, 2**31 - 1))
EMPTY_HANDED = st.builds(StateVector, st.integers(0, 1), DISTANCES, st.just(0), st.integers(215, 255), DISTANCES)
WITH_FOOD = st.builds(StateVector, st.just(1), DISTANCES, st.integers(0, 3), st.integers(215, 255), DISTANCES)
ROWS = st.lists(st.tuples(st.one_of(EMPTY_HANDED, WITH_FOOD), st.integers(0, 9)), max_size=30)
NAMES = st.text(min_size=1, max_size=20).filter(lambda text: text == text.strip() and text.isprintable())


SEEDS = st.one_of(st.none(), st.integers(), st.integers(0, 2**128))
DECISIONS = st.one_of(
    st.builds(Decisions, next_to_food=st.floats(10, 20), patience=st.integers(1, 10_000)),
    st.sampled_from([Decisions(), Decisions(equal_distance="farther state")]),
)
EXPERIENCES = st.builds(
    lambda rows, *about: Experience([row[0] for row in rows], [row[1] for row in rows], *about),
    *(ROWS, NAMES, SEEDS, st.integers(1, 100), DECISIONS),
)
SEARCH = StateVector(0, 52, 0, 215, 28)
HOME = StateVector(1, 48, FoodType.PICKABLE, 215, 14)


@settings(deadline=None)
@given(EXPERIENCES)
def test_saved_experience_loads_equal(experience: Experience) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "g1.csv")
        experience.save(path)
        loaded = Experience.load(path, arena=experience.arena)
        assert loaded == experience
        assert list(loaded) == list(experience)
        assert os.listdir(folder) == ["g1.csv"]
        assert experience.decisions is not None
        with ExperienceWriter(
            path, experience.arena, experience.seed, experience.episodes, decisions=experience.decisions, overwrite=True
        ) as writer:
            for vector, behaviour in experience:
                writer.append(vector, behaviour)
        assert Experience.load(str(path)) == experience


def test_loading_several_files_joins_them(tmp_path: Path) -> None:
    parts = [Experience([SEARCH] * n, [0] * n, seed=seed) for n, seed in [(1, 4), (2, 4), (3, 5)]]
    paths = [tmp_path / f"g{n}.csv" for n in (1, 2, 3)]
    for part, path in zip(parts, paths, strict=True):
        part.save(path)
    assert Experience.load(*paths[:2]) == parts[0] + parts[1] == Experience([SEARCH] * 3, [0] * 3, seed=4, episodes=2)
    g123 = Experience.load(*paths)
    assert g123 == Experience.load(tmp_path)
    assert (len(g123), g123.seed, g123.episodes) == (6, None, 3)
    assert pickle.loads(pickle.dumps(g123)) == g123
    text = decisions_text(Decisions())
    assert repr(g123) == (f"<Experience: 6 vectors, arena='corridor', seed=None, episodes=3, decisions={text!r}>")


def test_joining_what_does_not_fit_is_an_error(tmp_path: Path) -> None:
    corridor, rectangle = Experience([SEARCH], [0]), Experience([SEARCH], [0], arena="rectangle")
    corridor.save(tmp_path / "c.csv")
    rectangle.save(tmp_path / "r.csv")
    with pytest.raises(
        ExperienceError, match=r"r\.csv, line 3: arena is 'rectangle'; allowed: 'corridor', that of .*c\.csv"
    ):
        Experience.load(tmp_path / "c.csv", tmp_path / "r.csv")
    with pytest.raises(
        ExperienceError, match=r"c\.csv, line 3: arena is 'corridor'; allowed: 'rectangle', the argument"
    ):
        Experience.load(tmp_path / "c.csv", arena="rectangle")
    with pytest.raises(ExperienceError, match="'rectangle' added to experience of 'corridor'; allowed: the same"):
        corridor + rectangle
    assert corridor != rectangle
    with pytest.raises(TypeError, match="unsupported operand"):
        corridor + 1  # type: ignore[operator]
    with pytest.raises(ExperienceError, match="2 vectors with 1 behaviours; allowed: equal numbers"):
        Experience([SEARCH, HOME], [0])


BAD_ROWS: list[tuple[Any, Any, str]] = [
    ((2, 52, 0, 215, 28), 0, "object_presence is 2; allowed: 0 or 1"),
    ((0, -1, 0, 215, 28), 0, "robot_home_distance is -1; allowed: 0 to"),
    ((0, 52, 0, 215, 2**31), 0, "robot_food_distance is 2147483648; allowed: 0 to 2147483647 pixels"),
    ((0, 52, 0, 214, 28), 0, "arms_height is 214; allowed: 215 to 255"),
    ((0, 52, 0, 256, 28), 0, "arms_height is 256; allowed: 215 to 255"),
    ((1, 52, 4, 215, 28), 0, "food_type is 4; allowed: 0 to 3"),
    ((0, 52, 1, 215, 28), 0, "food_type is PICKABLE without an object; allowed: UNKNOWN"),
    (SEARCH, Behaviour.WAIT, "behaviour is WAIT, which means silence; allowed: a behaviour, 0 to 9"),
    (SEARCH, 11, r"behaviour 11; allowed: five integers with a behaviour, 0 to 9"),
    ((0, 52, 0, 215), 0, r"\(0, 52, 0, 215\) with behaviour 0; allowed: five integers"),
    ((0, 52.5, 0, 215, 28), 0, r"\(0, 52\.5, 0, 215, 28\) with behaviour 0; allowed: five integers"),
]


@pytest.mark.parametrize(("vector", "behaviour", "message"), BAD_ROWS)
def test_invalid_row_is_an_error(vector: Any, behaviour: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises(ExperienceError, match=f"experience vector 1: .*{message}"):
        Experience([SEARCH, vector], [0, behaviour])
    with ExperienceWriter(tmp_path / "g1.csv", "corridor") as writer:
        writer.append(SEARCH, 0)
        with pytest.raises(ExperienceError, match=message):
            writer.append(vector, behaviour)
    assert Experience.load(tmp_path / "g1.csv") == Experience([SEARCH], [0])


BAD_HEADERS: list[tuple[dict[str, Any], str]] = [
    ({"arena": ""}, "arena is ''; allowed: a printable name on one line"),
    ({"arena": "a\nb"}, r"arena is 'a\\nb'; allowed"),
    ({"arena": " a"}, "arena is ' a'; allowed"),
    ({"arena": "a", "seed": 0.5}, "seed is 0.5, episodes 1; allowed: integers"),
    ({"arena": "a", "seed": 10**100}, "seed has more than 100 digits"),
    ({"arena": "a", "episodes": 0}, "episodes is 0; allowed: at least 1"),
    ({"arena": "a", "decisions": 17}, r"decisions is 17; allowed: a khepera_forage\.Decisions"),
]


@pytest.mark.parametrize(("about", "message"), BAD_HEADERS)
def test_invalid_header_is_an_error(about: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(ExperienceError, match=message):
        Experience([SEARCH], [0], **about)
    with pytest.raises(ExperienceError, match=message):
        ExperienceWriter(tmp_path / "g1.csv", **about)
    assert not list(tmp_path.iterdir())


def test_writer_replaces_a_file_only_with_overwrite(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    path.write_text("precious")
    with pytest.raises(FileExistsError, match=r"g1\.csv exists; overwrite=True replaces it"):
        ExperienceWriter(path, "corridor")
    assert path.read_text() == "precious"
    with ExperienceWriter(path, "corridor", overwrite=True) as writer:
        writer.append(SEARCH, 0)
    writer.close()
    assert writer.count == len(Experience.load(path)) == 1
    with pytest.raises(ExperienceError, match=r"g1\.csv is closed"):
        writer.append(SEARCH, 0)


def test_recording_that_an_exception_or_a_kill_ends_keeps_its_rows(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    with contextlib.suppress(KeyboardInterrupt), ExperienceWriter(path, "corridor", seed=3) as writer:
        writer.append(SEARCH, 0)
        assert path.read_bytes().endswith(b"\n0,52,UNKNOWN,215,28,SEARCH_FOR_FOOD\n"), "on disk when append returns"
        raise KeyboardInterrupt
    with pytest.raises(ExperienceError, match="1 complete rows, no incomplete line; --recover or recover=True"):
        Experience.load(path)
    with pytest.warns(ExperienceWarning, match="no line is known to be lost"):
        assert Experience.load(path, recover=True) == Experience([SEARCH], [0], seed=3)


def test_loading_nothing_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="no path to load"):
        Experience.load()
    with pytest.raises(FileNotFoundError, match=r"g1\.csv"):
        Experience.load(tmp_path / "g1.csv")
    with pytest.raises(ExperienceError, match="no experience to join; allowed: at least one"):
        Experience.join([])


OTHER = Decisions(next_to_food=17, separation=21)


def test_experience_of_different_decisions_is_joined_only_if_allowed_and_fits_no_environment(tmp_path: Path) -> None:
    default, other, path = (tmp_path / f"{name}.csv" for name in ("default", "other", "mixed"))
    parts = Experience([SEARCH], [0]), Experience([SEARCH] * 2, [0] * 2, decisions=OTHER)
    parts[0].save(default)
    parts[1].save(other)
    with pytest.raises(ExperienceError, match=r"other\.csv: recorded under other decisions: next_to_food is 17, not "):
        Experience.load(default, other)
    mixed = Experience.join(parts, allow_other_decisions=True)
    assert (len(mixed), mixed.decisions) == (3, None)
    assert Experience.load(default, other, allow_other_decisions=True) == mixed
    mixed.save(path)
    assert "# decisions: mixed\n" in path.read_text()
    assert Experience.load(path) == mixed
    for refused in (
        lambda: mixed.require_decisions(Decisions()),
        lambda: parts[0] + mixed,
        lambda: mixed + mixed,
        lambda: Experience.load(path, decisions=OTHER),
    ):
        with pytest.raises(ExperienceError, match="experience of mixed decisions; allowed: the same decisions, or"):
            refused()
