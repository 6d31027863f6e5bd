"""The wrappers of the paired corridors, for all their versions: the order of calls and simultaneous actions."""

from collections.abc import Mapping
from typing import Any

from gymnasium.error import ResetNeeded
from pettingzoo.utils import BaseParallelWrapper, OrderEnforcingWrapper
from pettingzoo.utils.conversions import aec_to_parallel
from pettingzoo.utils.env import AECEnv, ParallelEnv

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.task.states import Behaviour, behaviour_number


class CheckedActions(BaseParallelWrapper[str, Any, Any]):
    """Checks the actions of all agents before any of them acts, so that an error leaves the environment as it was."""

    def step(self, actions: Mapping[str, Any]) -> Any:
        """A round of all agents.

        Args:
            actions: A behaviour for every agent.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An agent has no action or is unknown, or an action is not one of the eleven.
        """
        agents = getattr(
            self.env, "agents", []
        )  # PettingZoo's own conversion has none before the first reset
        if not agents:
            raise ResetNeeded("no episode is under way; call reset() to start one")
        if set(actions) != set(agents):
            raise ValueError(f"actions are of {list(actions)}; allowed: one each of {', '.join(agents)}")
        checked = {agent: behaviour_number(actions[agent], len(Behaviour), agent) for agent in agents}
        return super().step(checked)


def wrapped(raw: TrainingEnv) -> AECEnv[str, Any, Any]:
    """An environment that checks the order of calls; it checks actions itself."""
    return OrderEnforcingWrapper(raw)


def wrapped_parallel(raw: TrainingEnv) -> ParallelEnv[str, Any, Any]:
    """The same with simultaneous actions. What a learner hears is then what the teacher did a round ago."""
    return CheckedActions(aec_to_parallel(wrapped(raw)))
