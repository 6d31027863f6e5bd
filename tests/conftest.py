"""Settings of all tests."""

from importlib.util import find_spec

from hypothesis import settings

# The same examples on every machine and in every run: a failure in the gate is one that can be seen at home.
settings.register_profile("khepera_forage", derandomize=True, deadline=None)
settings.load_profile("khepera_forage")

# What needs torch is run by `make test-baselines`, which installs it.
collect_ignore = [] if find_spec("stable_baselines3") else ["baselines"]
