"""Episodes of the recall environments (4.6, 5.4)."""

import pytest

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies import Teacher
from khepera_forage.task.episode import score
from khepera_forage.task.states import Behaviour


def forage(env: BehavioursEnv, seed: int, swap: dict[int, int] | None = None) -> dict[str, float]:
    """An episode under the teacher, with some of its behaviours swapped."""
    teacher = Teacher(env.home_radius)
    observation, info = env.reset(seed=seed)
    over = False
    total = 0.0
    while not over:
        action = int(teacher.act(observation))
        observation, reward, terminated, truncated, info = env.step((swap or {}).get(action, action))
        total += float(reward)
        over = terminated or truncated
    return {**info, "terminated": terminated, "return": total}


@pytest.mark.parametrize(("arena", "foods", "limit"), [("corridor", 1, 500), ("rectangle", 2, 700)])
@pytest.mark.parametrize("food_type", ["PICKABLE", "PUSHABLE", "POISONOUS"])
def test_teacher_delivers_food_and_leaves_poison(arena: str, foods: int, limit: int, food_type: str) -> None:
    env = BehavioursEnv(arena=arena, foods=foods, limit=limit, food_types=food_type)
    results = [forage(env, seed) for seed in range(15)]
    delivered = sum(info["delivered"] for info in results)
    assert sum(info["poison_home"] for info in results) == 0
    if food_type == "POISONOUS":
        assert delivered == 0
        assert sum(info["terminated"] for info in results) >= 14
    else:
        assert delivered >= 0.9 * 15 * foods
    assert all(info["score"] >= 100 - 20 for info in results)


def test_teacher_without_orienting_delivers_nothing() -> None:
    env = BehavioursEnv()
    swap = {int(Behaviour.ORIENT_WITH_FOOD): int(Behaviour.SEARCH_FOR_FOOD)}
    assert [forage(env, seed, swap)["delivered"] for seed in range(10)] == [0] * 10


def test_reward_and_score_add_up() -> None:
    env = BehavioursEnv(limit=500)
    info = forage(env, 3)
    assert info["return"] == pytest.approx(info["delivered"] - info["steps"] / 500)
    assert info["score"] == score(int(info["correct"]), int(info["steps"]), info["penalty"]) == 100.0


def test_policy_that_only_explores_scores_its_correct_share_minus_the_penalty() -> None:
    env = BehavioursEnv(limit=50)
    env.reset(seed=0)
    truncated = False
    correct = 0
    while not truncated:
        correct += env.forager.correct_behaviour == Behaviour.EXPLORE_FOOD
        _, _, terminated, truncated, info = env.step(int(Behaviour.EXPLORE_FOOD))
        assert not terminated
    assert info["steps"] == 50
    assert info["correct"] == correct
    assert info["score"] == pytest.approx(100 * correct / 50 - 20)
