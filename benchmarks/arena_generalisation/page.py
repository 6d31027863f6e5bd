"""The page: the thesis's question first, then a paragraph, a figure and a table for each question."""

from collections.abc import Mapping

from arena_generalisation import method_texts, pictures, tables, texts
from arena_generalisation.analysis import Analysis
from khepera_forage.experiments.page import Page, Picture


def page(found: Analysis, steps: int, left_out: Mapping[str, str]) -> Page:
    """All that was found.

    Args:
        found: Estimates from the rows.
        steps: Environment steps of each training of a reinforcement learner.
        left_out: Why some learners were left out, by name.
    """
    training = (
        method_texts.left_out(left_out),
        method_texts.querying(found),
        method_texts.reinforcement(found, steps),
    )
    return Page(
        "Does foraging carry over to other arenas?",
        [
            texts.answer(found),
            method_texts.method(found),
            *filter(None, training),
            texts.arenas(found),
            Picture("generalisation_arenas", "food delivered in each arena", pictures.arenas_picture(found)),
            tables.arenas_table(found),
            tables.trainings_table(found),
            texts.difficulty(found),
            Picture(
                "generalisation_difficulty",
                "food delivered against difficulty",
                pictures.difficulty_picture(found),
            ),
            tables.difficulty_table(found),
            texts.attributes(found),
            Picture("generalisation_wrong", "wrong decisions of the imitator", pictures.wrong_picture(found)),
            tables.changes_table(found),
            texts.path(found),
            Picture(
                "generalisation_path",
                "straight distances and distances along the path",
                pictures.path_picture(found),
            ),
            tables.path_table(found),
            method_texts.limits(found),
        ],
        (tables.all_recalls(found), tables.all_decisions(found)),
    )
