"""What tests read from what is known of food."""

from khepera_forage.task.food_tracking import KnownFood, is_candidate


def linked_food(known: KnownFood, label: int) -> int | None:
    """Number of the food object that a track shows; None without a link."""
    foods = [link.food for link in known.links if link.label == label]
    assert len(foods) <= 1, "a track shows one food object"
    return foods[0] if foods else None


def labels_of_no_candidates(known: KnownFood) -> set[int]:
    """Labels of the tracks that show delivered food or known poison."""
    return {
        link.label
        for link in known.links
        if link.label >= 0 and not is_candidate(known.objects[link.food], link.food == known.tracker.held)
    }


def known_types(known: KnownFood) -> list[int]:
    return [food.known for food in known.objects]


def delivered(known: KnownFood) -> list[bool]:
    return [food.delivered for food in known.objects]
