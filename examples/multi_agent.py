"""Multi-agent PPO: both robots of the paired corridors learn to forage from their own rewards.

    pip install 'khepera-forage[baselines,fast,plots]'
    python examples/multi_agent.py --seed 1

Uses PettingZoo's `parallel_env`, in which both agents act at once, and the networks and updates of `ppo.py` beside this
file. The agents share their networks and learn independently: each decides by its own state vector and gets its own
reward. What they do is still coupled: the environment bends the course of `learner_0` to that of `teacher_0` (4.5.2),
and an episode ends when both have delivered their food and left home.

Measured with seed 1, as above, in 50 episodes before and after 300,000 rounds of training. Behaviours by chance deliver
much here, but slowly, because every episode begins on the marks of figure 5.1.

               food teacher_0    food learner_0    complete    rounds an episode
    before           41                22             15              545
    after            50                50             50               72

Takes two and a half minutes of one core.
"""

from argparse import ArgumentDefaultsHelpFormatter
from time import perf_counter, process_time
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import torch
from pettingzoo.utils.env import ParallelEnv
from ppo import Agent, Arguments, estimate, update
from torch import Tensor
from tqdm import tqdm

from khepera_forage.envs import paired_corridors_v1
from khepera_forage.option_values import OneLineParser, whole_number
from khepera_forage.policies.features import BEHAVIOUR_FEATURES, state_vector_features

Env: TypeAlias = ParallelEnv[str, Any, Any]
AGENTS = ("teacher_0", "learner_0")
LIMIT = 600
"""Rounds after which an episode is cut short."""
SETTINGS = Arguments(num_envs=8, minibatch_size=256)
"""Those of `ppo.py`, but fewer worlds, because pymunk simulates them one after the other."""


class Result(NamedTuple):
    """Episodes of both agents together."""

    delivered: dict[str, int]  # food: one object for each agent in each episode
    complete: int  # episodes in which both delivered and left home
    rounds: float  # mean of an episode


def paired_corridors() -> Env:
    """One pair. A separation does not end its episodes, because here no robot teaches the other."""
    return paired_corridors_v1.parallel_env(max_cycles=LIMIT, patience=LIMIT)


def features_of(observations: dict[str, Any]) -> Tensor:
    """The state vectors of both agents, one row each."""
    return torch.as_tensor(state_vector_features(np.array([observations[agent][:5] for agent in AGENTS])))


def decide(env: Env, actions: Tensor) -> tuple[Tensor, Tensor, bool, dict[str, Any]]:
    """Hold one decision of each agent for some rounds.

    Returns:
        Features after the last round, rewards added up, whether the episode was cut short, and infos.
    """
    behaviours = dict(zip(AGENTS, actions.tolist(), strict=True))
    total = torch.zeros(len(AGENTS))
    for _ in range(SETTINGS.hold):
        observations, rewards, _, truncated, infos = env.step(behaviours)
        total += torch.tensor([rewards[agent] for agent in AGENTS])
        if not env.agents:
            break
    return features_of(observations), total, any(truncated.values()), infos


def train(agent: Agent, rounds: int, seed: int) -> None:
    """Collect decisions of all agents in all pairs, update the networks, and repeat."""
    optimizer = torch.optim.Adam(agent.parameters(), lr=SETTINGS.learning_rate, eps=1e-5)
    envs = [paired_corridors() for _ in range(SETTINGS.num_envs)]
    width = len(AGENTS)
    size = SETTINGS.num_steps, SETTINGS.num_envs * width
    states = torch.zeros(*size, BEHAVIOUR_FEATURES)
    actions = torch.zeros(size, dtype=torch.long)
    log_probs, rewards, ends, values = (torch.zeros(size) for _ in range(4))
    state = torch.cat([features_of(env.reset(seed=seed + i)[0]) for i, env in enumerate(envs)])
    per_update = SETTINGS.num_steps * SETTINGS.num_envs * SETTINGS.hold
    for _ in tqdm(range(-(-rounds // per_update)), unit="update", disable=None):
        for step in range(SETTINGS.num_steps):
            with torch.no_grad():
                distribution = agent.distribution(state)
                states[step], actions[step] = state, distribution.sample()
                log_probs[step], values[step] = distribution.log_prob(actions[step]), agent.values(state)
            state = torch.empty_like(state)
            for i, env in enumerate(envs):
                pair = slice(i * width, (i + 1) * width)
                shown, reward, cut, _ = decide(env, actions[step, pair])
                if cut:  # a time limit is no failure: the reward that would have followed is estimated
                    reward += SETTINGS.gamma * agent.values(shown).detach()
                over = not env.agents
                state[pair] = features_of(env.reset()[0]) if over else shown
                rewards[step, pair], ends[step, pair] = reward, float(over)
        with torch.no_grad():
            advantages = estimate(rewards, ends, values, agent.values(state), SETTINGS)
        data = (states, actions, log_probs, advantages, advantages + values)
        update(agent, optimizer, [part.flatten(0, 1) for part in data], SETTINGS)


def measure(agent: Agent, episodes: int, seed: int) -> Result:
    """Forage together, with other seeds than in training."""
    torch.manual_seed(seed)
    env = paired_corridors()
    last = []
    for episode in range(episodes):
        observations, infos = env.reset(seed=1_000_000 * (seed + 1) + episode)
        shown = features_of(observations)
        while env.agents:
            with torch.no_grad():
                actions = agent.distribution(shown).sample()
            shown, _, _, infos = decide(env, actions)
        last.append(infos)
    delivered = {agent: sum(infos[agent]["delivered"] for infos in last) for agent in AGENTS}
    first = [infos[AGENTS[0]] for infos in last]
    complete = sum(info["complete"] for info in first)
    return Result(delivered, complete, float(np.mean([info["steps"] for info in first])))


def main(given: list[str] | None = None) -> tuple[Result, Result]:
    """Measure, learn, measure again, and print both."""
    parser = OneLineParser(description=__doc__, formatter_class=ArgumentDefaultsHelpFormatter)
    parser.add_argument("--rounds", type=whole_number(1), default=300_000, help="of training, over all pairs")
    parser.add_argument("--evaluations", type=whole_number(1), default=50, help="episodes before and after")
    parser.add_argument("--seed", type=whole_number(0), default=1, help="of networks, worlds and actions")
    arguments = parser.parse_args(given)
    torch.set_num_threads(1)  # networks this small are slower on two
    torch.manual_seed(arguments.seed)
    agent = Agent()
    results = [measure(agent, arguments.evaluations, arguments.seed)]
    began, used = perf_counter(), process_time()
    train(agent, arguments.rounds, arguments.seed)
    wall, cpu = perf_counter() - began, process_time() - used
    print(f"trained for {arguments.rounds:,} rounds: {wall:.0f} s, {cpu:.0f} s of processor time")
    results.append(measure(agent, arguments.evaluations, arguments.seed))
    for when, (delivered, complete, rounds) in zip(("before", "after"), results, strict=True):
        food = ", ".join(f"{agent} {count}" for agent, count in delivered.items())
        print(f"{when:6} {arguments.evaluations} episodes: food {food}; {complete} complete, {rounds:.0f} rounds")
    return results[0], results[1]


if __name__ == "__main__":
    main()
