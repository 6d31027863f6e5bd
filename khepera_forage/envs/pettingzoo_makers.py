"""What the modules of all paired environments share: wrappers, and the functions that PettingZoo calls."""

from collections.abc import Callable, Mapping
from typing import Any

from gymnasium.error import ResetNeeded
from pettingzoo.utils import BaseParallelWrapper, OrderEnforcingWrapper
from pettingzoo.utils.conversions import aec_to_parallel
from pettingzoo.utils.env import AECEnv, ParallelEnv

from khepera_forage.envs.training import TrainingEnv


class CheckedActions(BaseParallelWrapper[str, Any, Any]):
    """Checks the actions of all agents before any of them acts, so that an error leaves the environment as it was."""

    def step(self, actions: Mapping[str, Any]) -> Any:
        """A round of all agents.

        Args:
            actions: One for every agent.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An agent has no action or is unknown, or an action is not in its action space.
        """
        agents = getattr(
            self.env, "agents", []
        )  # PettingZoo's own conversion has none before the first reset
        if not agents:
            raise ResetNeeded("no episode is under way; call reset() to start one")
        if set(actions) != set(agents):
            raise ValueError(f"actions are of {list(actions)}; allowed: one each of {', '.join(agents)}")
        check = self.env.unwrapped.checked_action
        checked = {agent: check(actions[agent], agent) for agent in agents}
        return super().step(checked)


AecMaker = Callable[..., AECEnv[str, Any, Any]]
ParallelMaker = Callable[..., ParallelEnv[str, Any, Any]]


def makers(raw_env: Callable[..., TrainingEnv]) -> tuple[AecMaker, ParallelMaker]:
    """The functions `env` and `parallel_env` of a module.

    Args:
        raw_env: Makes the environment without wrappers; the functions have its arguments.

    Returns:
        `env`, which checks the order of calls (actions are checked by the environment itself), and `parallel_env` with
        simultaneous actions. What a learner hears is in the latter what the teacher did a round ago.
    """

    def env(**kwargs: Any) -> AECEnv[str, Any, Any]:
        """The environment with PettingZoo's usual wrappers; the arguments are those of `raw_env`."""
        return OrderEnforcingWrapper(raw_env(**kwargs))

    def parallel_env(**kwargs: Any) -> ParallelEnv[str, Any, Any]:
        """The same with simultaneous actions. What a learner hears is then what the teacher did a round ago."""
        return CheckedActions(aec_to_parallel(env(**kwargs)))

    return env, parallel_env
