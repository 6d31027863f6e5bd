"""Sets of decisions that between them have each alternative that is not the default."""

from khepera_forage.task.decisions import FIELDS, Decisions

CHOICES = {field.name: field.choices for field in FIELDS.values() if field.choices}
DECISIONS = (
    Decisions(),
    Decisions(next_to_food=17, close_to_food=36, separation=8, same_place=1, rounds_after_training=5),
    *(
        Decisions.from_changes(
            {name: some[i % len(some)] for name, some in CHOICES.items()} | {"redetection_time": 0.3}
        )
        for i in (-1, -2, -3)
    ),
)
IDS = ("default", "numbers", "last alternatives", "last but one", "last but two")
