"""The environments' names. Gymnasium and PettingZoo load no entry points: importing the package registers them.

Versions differ in their default decisions: v0 has those of version 0.1 of this package, v1 the defaults of `Decisions`.
Only the thesis's arenas are as old as v0.
"""

from typing import Any

import gymnasium as gym
import pettingzoo

from khepera_forage.envs.arena_settings import environment_name, settings_of
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS

VERSIONS = {"v0": "", "v1": "_v1"}
"""The versions, with the ends of the names of their entry points."""
_ENVS = "khepera_forage.envs"
_LEVELS = {"difficulty": "medium", "split": "train", "num_levels": 200, "start_level": 0}


def register_all() -> None:
    """Register the recall environments with Gymnasium, and training with PettingZoo; a second call does nothing."""
    for arena in THESIS_ARENAS:
        for version in VERSIONS:
            _register_recall(environment_name(arena), version, settings_of(arena))
    for arena in FAMILY:
        _register_recall(environment_name(arena), "v1", settings_of(arena))
    _register_recall("Procedural", "v1", _LEVELS)

    for version in VERSIONS:
        _register_training("PairedCorridors", version, f"paired_corridors_{version}", {})
    _register_training("PairedCorridorsWheels", "v1", "paired_corridors_wheels_v1", {})
    for arena in FAMILY:
        _register_training(f"Paired{environment_name(arena)}", "v1", "paired_arenas_v1", {"arena": arena})
    _register_training("PairedProcedural", "v1", "paired_procedural_v1", _LEVELS)


def _register_recall(name: str, version: str, kwargs: dict[str, Any]) -> None:
    """Register environments of behaviours and of wheels, one world and many."""
    for suffix, kind in (("", "behaviours"), ("Wheels", "wheels")):
        env_id = f"khepera_forage/{name}{suffix}-{version}"
        if env_id not in gym.registry:
            gym.register(
                env_id,
                entry_point=f"{_ENVS}.backends:{kind}{VERSIONS[version]}",
                vector_entry_point=f"{_ENVS}.backends:{kind}_vector{VERSIONS[version]}",
                kwargs=dict(kwargs),
            )


def _register_training(name: str, version: str, module: str, kwargs: dict[str, Any]) -> None:
    """Register an environment of the training phase in both forms of PettingZoo."""
    env_id = f"khepera_forage/{name}-{version}"
    if env_id not in pettingzoo.aec_registry:
        pettingzoo.register("aec", env_id, f"{_ENVS}.{module}:env", kwargs=dict(kwargs))
    if env_id not in pettingzoo.parallel_registry:
        pettingzoo.register("parallel", env_id, f"{_ENVS}.{module}:parallel_env", kwargs=dict(kwargs))
