"""The picture for a person who teaches: message, hint and keys."""

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.cli.teach import BEHAVIOUR_OF, LETTERS, Caption
from khepera_forage.cli.teach_window import COLUMNS, with_caption
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.picture import Painter, to_array
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import CORRIDOR

VIEW = View((CORRIDOR,), step=3, limit=500, title="You are the teacher")
PLAIN = Caption("Press the key of a behaviour.")


def pixels(view: View, caption: Caption) -> NDArray[np.uint8]:
    return to_array(with_caption(Painter().paint(view), caption))


def test_every_behaviour_has_a_letter_and_a_number() -> None:
    assert list(LETTERS) == list(Behaviour)[:10]
    assert len(set(LETTERS.values())) == 10
    for behaviour, letter in LETTERS.items():
        assert letter.upper() in behaviour.name
        assert BEHAVIOUR_OF[letter] == BEHAVIOUR_OF[str(int(behaviour))] == behaviour


def test_picture_of_the_environment_is_above_the_keys() -> None:
    picture, above = pixels(VIEW, PLAIN), to_array(Painter().paint(VIEW))
    assert picture.shape[1] == above.shape[1]
    np.testing.assert_array_equal(picture[: len(above)], above)


@pytest.mark.parametrize("behaviour", list(LETTERS))
@pytest.mark.parametrize("mark", ["held", "last"])
def test_marked_key_changes_only_its_cell(behaviour: Behaviour, mark: str) -> None:
    marked = PLAIN._replace(held=behaviour) if mark == "held" else PLAIN._replace(last=behaviour)
    before, after = pixels(VIEW, PLAIN), pixels(VIEW, marked)
    rows, columns = np.nonzero((before != after).any(axis=2))
    assert len(rows) > 300
    height, width = len(to_array(Painter().paint(VIEW))), before.shape[1]
    row, column = divmod(int(behaviour), COLUMNS)
    middle = (columns.min() + columns.max()) / 2
    assert abs(middle / width - (column + 0.5) / COLUMNS) < 0.03
    assert height + 36 + 38 * row <= rows.min() <= rows.max() < height + 36 + 38 * (row + 1)


@pytest.mark.parametrize(
    "changed",
    [PLAIN._replace(message="Wait."), PLAIN._replace(warning=True), PLAIN._replace(message="word " * 60)],
    ids=["message", "warning", "without the hint"],
)
def test_message_and_warning_are_visible(changed: Caption) -> None:
    before, after = pixels(VIEW, PLAIN), pixels(VIEW, changed)
    rows = np.nonzero((before != after).any(axis=2))[0]
    height = len(to_array(Painter().paint(VIEW)))
    assert len(rows) > 0
    assert height <= rows.min() <= rows.max() < height + 36
