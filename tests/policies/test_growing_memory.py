"""Nodes grow from experience, frequent stimuli are remembered, rare ones forgotten (section 2.3)."""

import math
import pickle
from typing import Any

import numpy as np
import pytest

from khepera_forage.policies import GrowingMemory

HERE, THERE = [0, 90, 0, 215, 60], [0, 30, 0, 215, 18]


def test_node_grows_at_a_new_stimulus() -> None:
    memory = GrowingMemory(reach=0.02)
    memory.fit([HERE, [0, 91, 0, 215, 61], THERE, HERE], [0, 0, 2, 0])  # 2 of 138 is within reach
    assert len(memory.nodes_) == 2
    assert memory.votes_.tolist() == [[3, 0], [0, 1]]
    assert memory.predict([HERE, THERE]).tolist() == [0, 2]
    assert len(GrowingMemory(reach=0.01).fit([HERE, [0, 91, 0, 215, 61]], [0, 0]).nodes_) == 2


def test_habituation_falls_with_perception_and_recovers_without() -> None:
    memory = GrowingMemory(habituation=0.3, recovery=0.01).fit([HERE], [0])
    assert memory.habituation_.tolist() == pytest.approx([0.7])
    memory.partial_fit([HERE], [0])
    assert memory.habituation_.tolist() == pytest.approx([(0.7 + 0.01 * 0.3) * 0.7])
    before = memory.habituation_[0]
    memory.partial_fit([THERE], [2])
    assert memory.habituation_[0] == pytest.approx(before + 0.01 * (1 - before))


def test_rare_node_is_forgotten_in_time_and_frequent_node_later() -> None:
    settings: dict[str, Any] = {"habituation": 0.3, "recovery": 0.01, "forgetting": 0.95}
    lasts = math.ceil(math.log(0.3 / 0.05) / -math.log(1 - 0.01))
    rare = GrowingMemory(**settings).fit([HERE] + [THERE] * (lasts - 1), [0] + [2] * (lasts - 1))
    assert rare.predict([HERE]).tolist() == [0]
    rare.partial_fit([THERE], [2])
    assert len(rare.nodes_) == 1
    assert rare.predict([HERE]).tolist() == [2], "the remaining node is nearest"
    frequent = GrowingMemory(**settings).fit(
        [HERE] * 20 + [THERE] * (lasts + 20), [0] * 20 + [2] * (lasts + 20)
    )
    assert frequent.predict([HERE]).tolist() == [0]


def test_partial_fit_equals_fit() -> None:
    rng = np.random.default_rng(0)
    rows = np.column_stack(
        [np.zeros(300), rng.integers(0, 40, 300), np.zeros(300), np.full(300, 215), np.zeros(300)]
    )
    heard = rng.integers(0, 4, 300)
    whole = GrowingMemory(recovery=0.05).fit(rows, heard)
    parts = GrowingMemory(recovery=0.05).partial_fit(rows[:10], heard[:10])
    pickle.loads(pickle.dumps(parts)).partial_fit(rows[10:], heard[10:])  # a copy learns independently
    parts.partial_fit(rows[10:], heard[10:])
    np.testing.assert_array_equal(whole.nodes_, parts.nodes_)
    np.testing.assert_array_equal(whole.predict_proba(rows), parts.predict_proba(rows))
    assert len(whole.nodes_) < 40
