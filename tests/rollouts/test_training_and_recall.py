"""Rollouts of training and recall: experience files, attempts and rows."""

import math
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any
from unittest.mock import MagicMock

import gymnasium as gym
import numpy as np
import pytest

from khepera_forage.envs import paired_corridors_v1
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience, ExperienceError, text_format
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.rollouts.raw_episodes import teacher_alone
from khepera_forage.rollouts.recall import WheelsRecall, recall, recall_wheels, recall_wheels_env
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, FoodType


def test_training_writes_the_experience_that_it_returns(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    env = TrainingEnv()
    experience, _ = train(env, np.random.SeedSequence(3), path=path)
    with ThreadPoolExecutor() as pool:  # in another thread, too
        again, _ = pool.submit(train, env, np.random.SeedSequence(3), path=tmp_path / "again.csv").result()
    assert Experience.load(path) == Experience.load(tmp_path / "again.csv") == experience == again
    with pytest.raises(FileExistsError, match=r"g1\.csv"):
        train(env, np.random.SeedSequence(3), path=path)


def test_attempt_whose_file_cannot_be_discarded_does_not_look_complete(tmp_path: Path) -> None:
    """As when the disk is unmounted for a moment, or the process is killed before the file is deleted."""
    folder, away = tmp_path / "experience", tmp_path / "away"
    folder.mkdir()

    def unmount(row: TrainingRow) -> None:
        assert row.reason == "out of time"
        folder.rename(away)

    with pytest.raises(FileNotFoundError, match=r"g1\.csv"):
        train(TrainingEnv(max_cycles=20), 1, path=folder / "g1.csv", on_attempt=unmount)
    with pytest.raises(ExperienceError, match="ends before its closing line: 20 complete rows"):
        Experience.load(away / "g1.csv")


def test_row_of_a_recall_is_what_happened_in_the_episode() -> None:
    """Every column, counted here step by step."""
    files = [train(TrainingEnv(), seed)[0] for seed in np.random.SeedSequence(2).spawn(3)]
    imitator = NearestNeighbourImitator(diagonal=177).fit(*arrays(files))
    kwargs: dict[str, Any] = {"food_types": {"PICKABLE": 2, "POISONOUS": 1}, "decisions": Decisions(patience=7)}
    env: Any = gym.make("khepera_forage/Rectangle-v1", foods=2, limit=600, **kwargs).unwrapped
    about: dict[str, Any] = {"learner": "mine", "noise": "usual", "replication": 2, "episodes": 3}
    about |= {"file_id": "g123", "experience_size": 9}
    rows = []
    for number, seed in enumerate((0, 2, 15, 24), 4):
        rows.append(recall(env, imitator, seed, number=number, **about))
        (observation, info), rng = env.reset(seed=seed), np.random.default_rng((seed, 1))
        (start,), foods, home = env.layout.starts, env.layout.foods, env.arena.home
        rounds, wrong, astray, ties, conflicts, rewards, over = [0] * 10, [0] * 10, 0, 0, 0, 0.0, False
        while not over:
            tied = sum(votes for _, votes in imitator.neighbours(observation).votes)
            ties, conflicts = ties + (tied > 1), conflicts + (len(imitator.confidence_levels(observation)) > 1)
            action, right = imitator.act(observation, rng), info["correct_behaviour"]
            rounds[info["state"]] += 1
            wrong[info["state"]] += action != right
            far = observation["robot_food_distance"][0] > Decisions().close_to_food
            astray += action == Behaviour.ORIENT_WITH_FOOD != right and far
            observation, reward, terminated, truncated, info = env.step(action)
            robot, rewards, over = env.view().robots[0], rewards + reward, terminated or truncated
            assert (robot.executed, robot.correct) == (action, right)
        at_home = [math.dist(place[:2], home) < env.arena.home_radius for place in env.world.food_places()]
        objects = env.forager.food.objects
        delivered = tuple(at and food.type == FoodType.PICKABLE for at, food in zip(at_home, objects, strict=True))
        wanted = sum(food.known != FoodType.POISONOUS for food in objects)
        assert rewards == pytest.approx(2 * sum(delivered) - sum(at_home) - sum(rounds) / 600)
        penalty = 0 if sum(delivered) == wanted else 5 if any(delivered) else 20
        assert asdict(rows[-1]) == about | {
            "arena": "rectangle",
            "recall": number,
            "seed": seed,
            "correct": sum(rounds) - sum(wrong),
            "steps": sum(rounds),
            "limit": 600,
            "penalty": penalty,
            "score": pytest.approx(100 - 100 * sum(wrong) / sum(rounds) - penalty),
            "delivered": sum(delivered),
            "foods": 2,
            "poison_home": sum(at_home) - sum(delivered),
            "food_x": tuple(round((food.x - home.x) / 5, 2) for food in foods),
            "food_y": tuple(round((food.y - home.y) / 5, 2) for food in foods),
            "food_delivered": delivered,
            "start_x": round((start.x - home.x) / 5, 2),
            "start_y": round((start.y - home.y) / 5, 2),
            "start_heading": round(math.degrees(start.heading), 1),
            "rounds_by_state": tuple(rounds),
            "wrong_by_state": tuple(wrong),
            "orient_without_food": astray,
            "ties": ties,
            "conflicts": conflicts,
            "decisions": "v1;patience=7",
        }
    assert {row.penalty for row in rows} == {0, 5, 20}
    assert all(sum(getattr(row, name) for row in rows) for name in ("poison_home", "orient_without_food", "conflicts"))


def test_rows_of_a_training_are_what_happened_in_its_attempts() -> None:
    """Every column and every vector, counted here round by round."""
    rough = Noise(placement_error=15.0, placement_heading_error=20.0, wheel_bias=0.1, wheel_slip=0.2)
    kwargs: dict[str, Any] = {"noise": rough, "decisions": Decisions(separation=7)}
    env = paired_corridors_v1.parallel_env(max_cycles=140, patience=5, **kwargs)
    rows: list[TrainingRow] = []
    for file in (4, 5):
        experience, more = train(env.unwrapped, file, noise="rough", replication=2, file=file)
        for attempt, row in enumerate(more, 1):
            (shown, infos), recorded, separated, rounds = env.reset(seed=row.seed), [], [False], 0
            while env.agents:
                said = 10 if shown["teacher_0"][6] else infos["teacher_0"]["correct_behaviour"]
                recorded += [(tuple(shown["learner_0"][:5]), said)] if said != 10 else []
                shown, _, ends, _, infos = env.step(dict.fromkeys(env.agents, said))
                separated.append(bool(shown["learner_0"][6]))
                rounds += 1
            complete = ends["learner_0"]
            assert row == TrainingRow(
                replication=2,
                file=file,
                attempt=attempt,
                seed=row.seed,
                noise="rough",
                complete=complete,
                rounds=rounds,
                vectors=len(recorded),
                separations=sum(later and not earlier for earlier, later in pairwise(separated)),
                reason="" if complete else "out of time" if rounds == 140 else "separated",
                decisions="v1;separation=7",
            )
        assert recorded == list(experience)
        rows += more
    assert {row.reason for row in rows} == {"", "separated", "out of time"}
    assert sum(row.separations for row in rows) > 1
    assert len({row.seed for row in rows}) == len(rows)


# ---------------------------------------------------------------- motors as actions


@pytest.mark.parametrize(("arena", "foods"), [("corridor", 1), ("rectangle", 2)])
def test_recall_with_the_teachers_motors_delivers_all_food(arena: str, foods: int) -> None:
    env, callback = recall_wheels_env(arena), MagicMock()
    _, alone = teacher_alone(env, 1)
    policy, steps = SimpleNamespace(act=MagicMock(side_effect=alone.actions)), len(alone.actions)
    row = recall_wheels(env, policy, 1, callback=callback)
    assert row == WheelsRecall(100.0, steps, foods, foods, 0, steps)
    assert callback.call_count == steps + 1 < env.limit


# ---------------------------------------------------------------- interrupts


def test_interrupt_while_the_file_is_opened_closes_and_deletes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[IO[Any]] = []

    def interrupted_open(*args: Any, **kwargs: Any) -> IO[Any]:
        file: IO[Any] = open(*args, **kwargs)  # noqa: SIM115 - the test checks that it is closed
        opened.append(file)
        signal.raise_signal(signal.SIGINT)
        return file

    monkeypatch.setattr(text_format, "open", interrupted_open, raising=False)
    with pytest.raises(KeyboardInterrupt):
        train(TrainingEnv(), np.random.SeedSequence(0), path=tmp_path / "g1.csv")
    assert [file.closed for file in opened] == [True]
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
