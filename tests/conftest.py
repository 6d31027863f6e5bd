"""Settings of all tests."""

import signal
from importlib.util import find_spec

import pytest
from hypothesis import settings

# The same examples on every machine and in every run: a failure in the gate is one that can be seen at home.
settings.register_profile("khepera_forage", derandomize=True, deadline=None)
settings.load_profile("khepera_forage")

# What needs torch is run by `make test-baselines`, which installs it.
collect_ignore = [] if find_spec("stable_baselines3") else ["baselines"]

# A suite that was started in the background may have been told to ignore what its tests send to robots' programs, and
# programs inherit that.
for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, usual)


@pytest.hookimpl(tryfirst=True)  # before xdist looks for the marks
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Make groups of tests, each of which runs in one process: a file, or all tests of a benchmark script.

    A file's tests share fixtures, and a script's tests share a run, for which they would otherwise wait in several
    processes.
    """
    for item in items:
        file = item.nodeid.partition("::")[0]
        call = getattr(item, "callspec", None)  # that of a parametrized test
        script = call.params.get("script") if call else None
        item.add_marker(pytest.mark.xdist_group(f"tests/benchmarks/test_{script}.py" if script else file))
