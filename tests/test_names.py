"""The names of daily use: at the top of the package, and imported when they are used."""

import pytest

import khepera_forage


def test_names_of_daily_use_are_at_the_top() -> None:
    # A list of its own: a name that users import stays.
    names = "Arena Decisions Experience NearestNeighbourImitator Noise Teacher as_policy dagger read_arena recall"
    assert {*names.split(), "recall_env", "train", "__version__"} == set(khepera_forage.__all__)
    assert set(khepera_forage.__all__) <= set(dir(khepera_forage))
    assert all(getattr(khepera_forage, name) for name in khepera_forage.__all__)


def test_other_names_do_not_exist() -> None:
    with pytest.raises(AttributeError, match="module 'khepera_forage' has no attribute 'Nothing'"):
        _ = khepera_forage.Nothing
