"""The environments that commands run: simulated, or with `--lab` in a laboratory."""

import argparse
from typing import Any

from khepera_forage.cli.arguments import VIRTUAL_LAB, arena_of, decisions_of, noise_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.paired_arenas_v1 import raw_env
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.extras import require
from khepera_forage.noise import Noise
from khepera_forage.robots.model import KHEPERA, MODELS, TOIO
from khepera_forage.rollouts import recall as recall_rollouts
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import Decisions


def training_env(arguments: argparse.Namespace, **kwargs: Any) -> TrainingEnv:
    """Teacher and learners in copies of an arena. In a laboratory, print its robots and its camera.

    Args:
        arguments: With `lab`, `arena`, `num_learners`, `food_type` and `decision`.
        **kwargs: Further arguments of the environment.
    """
    decisions, learners, arena = decisions_of(arguments), arguments.num_learners or 1, arena_of(arguments)
    kwargs = {"food_types": arguments.food_type, "decisions": decisions, **kwargs}
    if arguments.lab is None:
        return raw_env(arena, num_learners=learners, **kwargs)
    world = _laboratory(arguments.lab, arena, learners + 1, decisions)
    try:
        return raw_env(
            _known(world.arenas[0]),
            num_learners=len(world.markers) - 1,
            noise=Noise.none(),
            world=world,
            **kwargs,
        )
    except BaseException:
        world.close()
        raise


def recall_env(arguments: argparse.Namespace, **kwargs: Any) -> BehavioursEnv:
    """A recall environment. In a laboratory, print its robot and its camera.

    Args:
        arguments: With `lab`, `arena`, `food_type`, `foods`, `noise` and `decision`.
        **kwargs: Further arguments of the environment.
    """
    decisions, arena = decisions_of(arguments), arena_of(arguments)
    kwargs = {"decisions": decisions, **kwargs}
    if arguments.food_type is not None:
        kwargs["food_types"] = arguments.food_type
    if arguments.foods is not None:
        kwargs["foods"] = arguments.foods
    if arguments.lab is None:
        return recall_rollouts.recall_env(arena, noise_of(arguments.noise), **kwargs)
    world = _laboratory(arguments.lab, arena, 1, decisions)
    try:
        return recall_rollouts.recall_env(_known(world.arenas[0]), world=world, **kwargs)
    except BaseException:
        world.close()
        raise


def _known(arena: Arena) -> str | Arena:
    """The name of an arena of a laboratory, whose settings then apply; or an arena of the user's own."""
    return arena.name if arena.name in ARENAS else arena


def print_late_rounds(env: TrainingEnv | BehavioursEnv) -> None:
    """Print how many rounds of a laboratory took longer than a control step; print nothing for a simulation."""
    clock = getattr(env.world, "clock", None)
    if clock is not None and clock.rounds:
        worst = f", the worst by {1000 * clock.worst_overrun:.0f} ms" if clock.overruns else ""
        print(f"{clock.rounds} rounds, {clock.overruns} over their time{worst}")


def _laboratory(lab: str, arena: str | Arena, robots: int, decisions: Decisions) -> World:
    """Open the laboratory that `--lab` names; one robot means the one that forages in a recall.

    The decisions say how long rounds last and where start, food and home are, where the file leaves this open.

    Raises:
        ValueError: The file has a mistake.
        OSError: The file, a port or the camera cannot be opened, or a robot does not answer.
        ImportError: An extra is not installed.
    """
    require("--lab", "robots", "camera")
    name, _, kind = lab.partition(":")
    if name == VIRTUAL_LAB:
        from khepera_forage.envs.laboratories import virtual_cubes, virtual_laboratory

        kind = kind or KHEPERA.name
        if kind not in MODELS:
            raise ValueError(
                f"--lab {lab}; allowed: {', '.join(f'{VIRTUAL_LAB}:{model}' for model in MODELS)}"
            )
        if kind == TOIO.name:
            cubes = virtual_cubes(arena, robots, decisions)
            print(f"virtual laboratory: cubes {', '.join(cubes.port_urls)}, on a mat")
            return cubes
        virtual = virtual_laboratory(arena, robots, decisions, robot=kind)
        print(f"virtual laboratory: robots at {', '.join(virtual.port_urls)}, a tracker on rendered frames")
        return virtual
    from khepera_forage.envs.laboratories import load_settings
    from khepera_forage.lab.laboratory import Laboratory

    settings = load_settings(lab, decisions)
    if robots == 1:
        settings = settings.for_recall()
    elif len(settings.robots) < 2:
        raise ValueError(f"{lab}: robots has one entry; allowed: a teacher and at least one learner")
    for robot in settings.robots:
        print(f"robot {robot.name} at {robot.port}" + (f", {robot.baud} baud" if robot.baud else ""))
    seen = "a mat" if settings.has_mat else f"camera {settings.camera.source}"
    print(f"{seen}; arena {settings.arena.name}")
    return Laboratory(settings)
