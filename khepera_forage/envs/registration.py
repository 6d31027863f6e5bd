"""The environments' names. Gymnasium loads no entry points: importing the package registers them."""

import gymnasium as gym


def register_all() -> None:
    """Register the recall environments; a second call does nothing."""
    for name, foods, limit in (("Corridor", 1, 500), ("Rectangle", 2, 700)):
        for suffix, kind in (("", "behaviours"), ("Wheels", "wheels")):
            env_id = f"khepera_forage/{name}{suffix}-v0"
            if env_id not in gym.registry:
                kwargs = {"foods": foods, "limit": limit, "arena": name.lower()}
                gym.register(
                    env_id,
                    entry_point=f"khepera_forage.envs.backends:{kind}",
                    vector_entry_point=f"khepera_forage.envs.backends:{kind}_vector",
                    kwargs=kwargs,
                )
