"""Settings of all tests."""

from hypothesis import settings

# The same examples on every machine and in every run: a failure in the gate is one that can be seen at home.
settings.register_profile("khepera_forage", derandomize=True, deadline=None)
settings.load_profile("khepera_forage")
