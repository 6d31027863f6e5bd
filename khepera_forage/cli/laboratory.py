"""`--lab`: the same commands on real robots, or in the virtual laboratory."""

import argparse
from typing import Any

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.rollouts import recall as recalling
from khepera_forage.sim.arena import ARENAS
from khepera_forage.sim.world import World

VIRTUAL = "virtual"


def add_lab_argument(parser: argparse.ArgumentParser) -> None:
    """Where the robots are."""
    parser.add_argument(
        "--lab",
        metavar="FILE",
        help="real robots and a real camera as this lab.toml says; 'virtual': simulated ones behind real drivers",
    )


def training_env(arguments: argparse.Namespace, **kwargs: Any) -> TrainingEnv:
    """The paired corridors, simulated or with `--lab` in a laboratory, which says what it is.

    Args:
        arguments: With `lab`, `num_learners`, `food_type`.
        **kwargs: Others of the environment.
    """
    learners, kwargs = arguments.num_learners, {"food_types": arguments.food_type, **kwargs}
    if arguments.lab is None:
        return TrainingEnv(num_learners=learners, **kwargs)
    world = _laboratory(arguments.lab, "corridor", learners + 1)
    try:
        return TrainingEnv(num_learners=len(world.markers) - 1, noise=Noise.none(), world=world, **kwargs)
    except BaseException:
        world.close()
        raise


def recall_env(arguments: argparse.Namespace, **kwargs: Any) -> BehavioursEnv:
    """A recall environment, simulated or with `--lab` in a laboratory, which says what it is.

    Args:
        arguments: With `lab`, `arena`, `food_type`.
        **kwargs: Others of the environment.
    """
    kwargs = {"food_types": arguments.food_type, **kwargs}
    if arguments.lab is None:
        return recalling.recall_env(arguments.arena, **kwargs)
    world = _laboratory(arguments.lab, arguments.arena, 1)
    try:
        arena = world.arenas[0]
        if arena.name in ARENAS:
            return recalling.recall_env(arena.name, world=world, **kwargs)
        return BehavioursEnv(foods=len(arena.foods), world=world, **kwargs)
    except BaseException:
        world.close()
        raise


def report(env: TrainingEnv | BehavioursEnv) -> None:
    """Say how a laboratory kept its beat, if it was one that keeps it."""
    beat = getattr(env.world, "beat", None)
    if beat is not None and beat.rounds:
        worst = f", the worst by {1000 * beat.worst:.0f} ms" if beat.overruns else ""
        print(f"{beat.rounds} rounds, {beat.overruns} over their time{worst}")


def _laboratory(lab: str, arena: str, robots: int) -> World:
    """The laboratory asked for; with one robot, the one that forages in a recall.

    Raises:
        ValueError: A mistake in the file.
        OSError: The file, a port or the camera cannot be opened, or a robot does not answer.
    """
    if lab == VIRTUAL:
        from khepera_forage.lab.virtual_laboratory import VirtualLaboratory

        virtual = VirtualLaboratory.of(arena, robots)
        print(f"virtual laboratory: robots at {', '.join(virtual.urls)}, a tracker on rendered frames")
        return virtual
    from khepera_forage.lab.laboratory import Laboratory
    from khepera_forage.lab.settings_file import load

    settings = load(lab)
    if robots == 1:
        settings = settings.alone()
    elif len(settings.robots) < 2:
        raise ValueError(f"{lab}: robots has one entry; allowed: a teacher and at least one learner")
    for robot in settings.robots:
        print(f"robot {robot.name} at {robot.port}, {robot.baud} baud")
    print(f"camera {settings.camera.source}; arena {settings.arena.name}")
    return Laboratory(settings)
