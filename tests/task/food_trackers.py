"""What tests read from a food tracker."""

from khepera_forage.task.food_tracking import FoodTracker, is_candidate


def linked_food(tracker: FoodTracker, label: int) -> int | None:
    """Number of the food object that a track shows; None without a link."""
    foods = [link.food for link in tracker.links if link.label == label]
    assert len(foods) <= 1, "a track shows one food object"
    return foods[0] if foods else None


def labels_of_no_candidates(tracker: FoodTracker) -> set[int]:
    """Labels of the tracks that show delivered food or known poison."""
    return {
        link.label
        for link in tracker.links
        if link.label >= 0 and not is_candidate(tracker.foods[link.food], link.food == tracker.held)
    }


def known_types(tracker: FoodTracker) -> list[int]:
    return [food.known for food in tracker.foods]


def delivered(tracker: FoodTracker) -> list[bool]:
    return [food.delivered for food in tracker.foods]
