"""The environments' names. Gymnasium and PettingZoo load no entry points: importing the package registers them.

Versions differ in their default decisions: v0 has those of version 0.1 of this package, v1 the defaults of `Decisions`.
"""

import gymnasium as gym
import pettingzoo

VERSIONS = {"v0": "", "v1": "_v1"}
"""The versions, with the ends of the names of their entry points."""


def register_all() -> None:
    """Register the recall environments with Gymnasium, and training with PettingZoo; a second call does nothing."""
    for name, foods, limit in (("Corridor", 1, 500), ("Rectangle", 2, 700)):
        for suffix, kind in (("", "behaviours"), ("Wheels", "wheels")):
            for version, end in VERSIONS.items():
                env_id = f"khepera_forage/{name}{suffix}-{version}"
                if env_id not in gym.registry:
                    gym.register(
                        env_id,
                        entry_point=f"khepera_forage.envs.backends:{kind}{end}",
                        vector_entry_point=f"khepera_forage.envs.backends:{kind}_vector{end}",
                        kwargs={"foods": foods, "limit": limit, "arena": name.lower()},
                    )
    for version in VERSIONS:
        env_id = f"khepera_forage/PairedCorridors-{version}"
        module = f"khepera_forage.envs.paired_corridors_{version}"
        if env_id not in pettingzoo.aec_registry:
            pettingzoo.register("aec", env_id, f"{module}:env")
        if env_id not in pettingzoo.parallel_registry:
            pettingzoo.register("parallel", env_id, f"{module}:parallel_env")
