"""PPO that learns to forage from the reward alone, without a teacher: one file, in the style of CleanRL.

    pip install 'khepera-forage[baselines,fast,plots]'
    python examples/ppo.py --seed 1 --out results/ppo

Trains in compiled worlds, where a decision holds for five rounds: with a decision in every round, chance delivers
almost no food, so that there would be nothing to learn from. Then forages in single environments on both backends.
Writes `ppo.pt` (the networks, which `load` reads), `learning_curve.csv` and `learning_curve.png`.

Measured with seed 1, as above: 500 of 500 food objects delivered on pymunk and 500 of 500 in compiled worlds, with 79
steps an episode. The training took 17 s of processor time, the whole command 29 s. The first run on a machine
also compiles the worlds, for less than a minute.
"""

import csv
from argparse import ArgumentDefaultsHelpFormatter
from collections import deque
from dataclasses import dataclass, field, fields
from pathlib import Path
from time import perf_counter, process_time
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
import torch
from gymnasium.vector import AutoresetMode
from matplotlib.figure import Figure
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.distributions import Categorical
from tqdm import tqdm

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.files import replacing
from khepera_forage.option_values import OneLineParser, given_path, whole_number
from khepera_forage.policies.features import BEHAVIOUR_FEATURES, behaviour_features
from khepera_forage.task.states import NUM_BEHAVIOURS
from khepera_forage.wrappers import ActionRepeat, VectorActionRepeat

ENVIRONMENT = "khepera_forage/Corridor-v1"
"""One food object in each episode."""
OUT = Path("results/ppo")


def option(default: Any, text: str) -> Any:
    """A field of `Arguments`, with its text for `--help`."""
    return field(default=default, metadata={"help": text})


@dataclass(frozen=True)
class Arguments:
    """The options of the command line."""

    rounds: int = option(1_000_000, "rounds of training, over all worlds")
    seed: int = option(1, "of networks, worlds and actions")
    out: Path = option(OUT, "folder for the network and the learning curve")  # noqa: RUF009 (a path never changes)
    evaluations: int = option(500, "episodes on each backend after training")
    num_envs: int = option(64, "worlds")
    hold: int = option(5, "rounds that a decision holds")
    num_steps: int = option(64, "decisions in each world between two updates")
    minibatch_size: int = option(512, "decisions")
    epochs: int = option(4, "passes over the decisions of an update")
    learning_rate: float = option(1e-3, "of Adam")
    gamma: float = option(0.98, "discount of a decision")
    gae_lambda: float = option(0.95, "of generalized advantage estimation")
    clip: float = option(0.2, "largest change of a probability ratio")
    entropy: float = option(0.01, "weight of the policy's entropy")
    value_weight: float = option(0.5, "weight of the error of values")
    max_grad_norm: float = option(0.5, "gradients are scaled down to this norm")


class CurvePoint(NamedTuple):
    """One line of the learning curve: the last hundred episodes before an update; nan before so many have ended."""

    rounds: int
    seconds: float
    food_delivered: float  # share of the food
    episode_return: float


class Evaluation(NamedTuple):
    """Single episodes of a trained agent."""

    backend: str
    episodes: int
    delivered: int  # food: one object in each episode
    score: float  # percent: agreement with the thesis's teacher, which PPO never saw
    steps: float


class Agent(nn.Module):
    """Two networks on the features of a state vector: the policy's logits, and the value."""

    def __init__(self) -> None:
        super().__init__()
        self.policy = network(NUM_BEHAVIOURS, last_gain=0.01)
        self.value = network(1, last_gain=1.0)

    def distribution(self, features: Tensor) -> Categorical:
        """Of the behaviours."""
        return Categorical(logits=self.policy(features))

    def values(self, features: Tensor) -> Tensor:
        """The expected return of each row."""
        values: Tensor = self.value(features).squeeze(-1)
        return values

    @torch.no_grad()
    def act(self, observation: Any) -> int:
        """A behaviour for one observation, drawn with its probability."""
        return int(self.distribution(features_of(observation)).sample().item())


def network(outputs: int, last_gain: float) -> nn.Sequential:
    """Two hidden layers of 64 units, with orthogonal first weights."""
    layers: list[nn.Module] = []
    for inputs, width, gain in ((BEHAVIOUR_FEATURES, 64, 2**0.5), (64, 64, 2**0.5), (64, outputs, last_gain)):
        layer = nn.Linear(inputs, width)
        nn.init.orthogonal_(layer.weight, gain)
        nn.init.zeros_(layer.bias)
        layers += [layer, nn.Tanh()]
    return nn.Sequential(*layers[:-1])


def features_of(observations: Any) -> Tensor:
    """Observations of one environment or many as rows of numbers about -1..1."""
    return torch.as_tensor(behaviour_features(observations))


def train(arguments: Arguments) -> tuple[Agent, list[CurvePoint]]:
    """Collect decisions, update the networks, and repeat."""
    torch.manual_seed(arguments.seed)
    agent = Agent()
    optimizer = torch.optim.Adam(agent.parameters(), lr=arguments.learning_rate, eps=1e-5)
    # SAME_STEP: the step that ends an episode returns the first observation of the next one, and the last observation
    # of the old one in the info. Every stored decision is then a real one.
    envs = gym.make_vec(ENVIRONMENT, num_envs=arguments.num_envs, autoreset_mode=AutoresetMode.SAME_STEP)
    envs = VectorActionRepeat(envs, arguments.hold)
    size = arguments.num_steps, arguments.num_envs
    states = torch.zeros(*size, BEHAVIOUR_FEATURES)
    actions = torch.zeros(size, dtype=torch.long)
    log_probs, rewards, ends, values = (torch.zeros(size) for _ in range(4))

    shown, _ = envs.reset(seed=arguments.seed)
    # Networks this small are slower on two threads. Compiled worlds set the number of threads at their first reset.
    torch.set_num_threads(1)
    state = features_of(shown)
    returns = np.zeros(arguments.num_envs)
    recent: deque[tuple[float, float]] = deque(maxlen=100)  # food delivered and return of the last episodes
    curve: list[CurvePoint] = []
    began, rounds = perf_counter(), 0
    with tqdm(total=arguments.rounds, unit="round", unit_scale=True, disable=None) as progress:
        while rounds < arguments.rounds:
            for step in range(arguments.num_steps):
                with torch.no_grad():
                    distribution = agent.distribution(state)
                    action = distribution.sample()
                    states[step], actions[step] = state, action
                    log_probs[step], values[step] = distribution.log_prob(action), agent.values(state)
                shown, reward, terminated, truncated, info = envs.step(action.numpy())
                returns += reward
                ended = terminated | truncated
                for world in np.flatnonzero(ended):
                    recent.append((info["final_info"]["delivered"][world], returns[world]))
                returns[ended] = 0.0
                # A time limit is no failure: the reward that would have followed is estimated.
                reward = reward + arguments.gamma * final_values(agent, info, truncated & ~terminated)
                rewards[step], ends[step] = torch.as_tensor(reward), torch.as_tensor(ended)
                state = features_of(shown)
            with torch.no_grad():
                advantages = estimate(rewards, ends, values, agent.values(state), arguments)
            data = (states, actions, log_probs, advantages, advantages + values)
            update(agent, optimizer, [part.flatten(0, 1) for part in data], arguments)
            rounds += arguments.num_steps * arguments.num_envs * arguments.hold
            # Before a hundred episodes have ended, those that have are the short ones, which delivered.
            enough = len(recent) == recent.maxlen
            delivered, episode_return = np.mean(recent, axis=0).tolist() if enough else (np.nan, np.nan)
            curve.append(CurvePoint(rounds, perf_counter() - began, delivered, episode_return))
            progress.set_postfix_str(f"food {delivered:.0%}")
            progress.update(arguments.num_steps * arguments.num_envs * arguments.hold)
    envs.close()
    return agent, curve


def final_values(agent: Agent, info: dict[str, Any], cut: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The value of the last observation of every episode that a time limit has cut short, 0 elsewhere."""
    found = np.zeros(len(cut))
    if cut.any():
        rows = np.concatenate([behaviour_features(last) for last in info["final_obs"][cut]])
        with torch.no_grad():
            found[cut] = agent.values(torch.as_tensor(rows)).numpy()
    return found


def estimate(rewards: Tensor, ends: Tensor, values: Tensor, next_value: Tensor, arguments: Arguments) -> Tensor:
    """Generalized advantage estimation (Schulman et al. 2016), backwards in time."""
    advantages = torch.zeros_like(rewards)
    advantage = torch.zeros_like(next_value)
    for step in reversed(range(len(rewards))):
        goes_on = 1.0 - ends[step]
        error = rewards[step] + arguments.gamma * next_value * goes_on - values[step]
        advantage = error + arguments.gamma * arguments.gae_lambda * goes_on * advantage
        advantages[step], next_value = advantage, values[step]
    return advantages


def update(agent: Agent, optimizer: torch.optim.Optimizer, data: list[Tensor], arguments: Arguments) -> None:
    """Improve both networks on the decisions collected, with the clipped objective (Schulman et al. 2017)."""
    for _ in range(arguments.epochs):
        for batch in torch.randperm(len(data[0])).split(arguments.minibatch_size):
            states, actions, log_probs, advantages, targets = (part[batch] for part in data)
            advantages = (advantages - advantages.mean()) / (advantages.std(correction=0) + 1e-8)
            distribution = agent.distribution(states)
            ratio = torch.exp(distribution.log_prob(actions) - log_probs)
            clipped = ratio.clamp(1 - arguments.clip, 1 + arguments.clip)
            policy_loss = -torch.min(advantages * ratio, advantages * clipped).mean()
            value_loss = (agent.values(states) - targets).square().mean()
            entropy = distribution.entropy().mean()
            loss = policy_loss + arguments.value_weight * value_loss - arguments.entropy * entropy
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(agent.parameters(), arguments.max_grad_norm)
            optimizer.step()


def evaluate(agent: Agent, arguments: Arguments, backend: str) -> Evaluation:
    """Forage in a single environment, with other seeds than in training."""
    torch.manual_seed(arguments.seed)
    env = ActionRepeat(gym.make(ENVIRONMENT, backend=backend), arguments.hold)
    last = []
    for episode in tqdm(range(arguments.evaluations), unit="episode", desc=backend, disable=None):
        shown, info = env.reset(seed=1_000_000 * (arguments.seed + 1) + episode)
        over = False
        while not over:
            shown, _, terminated, truncated, info = env.step(agent.act(shown))
            over = terminated or truncated
        last.append(info)
    env.close()
    score, steps = (float(np.mean([info[name] for info in last])) for name in ("score", "steps"))
    return Evaluation(backend, len(last), sum(info["delivered"] for info in last), score, steps)


def save(agent: Agent, curve: list[CurvePoint], out: Path) -> None:
    """Write the network, the learning curve, and its picture."""
    out.mkdir(parents=True, exist_ok=True)
    with replacing(out / "ppo.pt") as partial:
        torch.save(agent.state_dict(), partial)
    with replacing(out / "learning_curve.csv") as partial, partial.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerows([CurvePoint._fields, *curve])
    figure = Figure(figsize=(6, 3.5), layout="constrained")
    axes = figure.subplots()
    axes.plot([point.rounds / 1000 for point in curve], [100 * point.food_delivered for point in curve])
    axes.set(xlabel="thousand rounds, over all worlds", ylabel="food delivered (%), last 100 episodes")
    axes.set_xlim(0)
    axes.set_ylim(0, 102)
    figure.savefig(out / "learning_curve.png", dpi=150)


def load(path: Path) -> Agent:
    """A trained agent."""
    agent = Agent()
    agent.load_state_dict(torch.load(path, weights_only=True))
    return agent


def parse(given: list[str] | None = None) -> Arguments:
    """Read the command line: one option for each field of `Arguments`."""
    parser = OneLineParser(description=__doc__, formatter_class=ArgumentDefaultsHelpFormatter)
    readers: dict[str, Any] = {"seed": whole_number(0), "out": given_path}
    for one in fields(Arguments):
        reader = readers.get(one.name, whole_number(1) if isinstance(one.default, int) else float)
        name = f"--{one.name.replace('_', '-')}"
        parser.add_argument(name, type=reader, default=one.default, help=one.metadata["help"])
    return Arguments(**vars(parser.parse_args(given)))


def main(given: list[str] | None = None) -> list[Evaluation]:
    """Train, save, evaluate, and print what was measured."""
    arguments = parse(given)
    began, used = perf_counter(), process_time()
    agent, curve = train(arguments)
    wall, cpu = perf_counter() - began, process_time() - used
    save(agent, curve, arguments.out)
    print(f"trained for {curve[-1].rounds:,} rounds: {wall:.0f} s, {cpu:.0f} s of processor time")
    found = [evaluate(agent, arguments, backend) for backend in ("compiled", "pymunk")]
    for backend, episodes, delivered, score, steps in found:
        print(
            f"{backend:8} {episodes} episodes: {delivered} of {episodes} food delivered "
            f"({delivered / episodes:.1%}), score {score:.1f} %, {steps:.0f} steps"
        )
    return found


if __name__ == "__main__":
    main()
