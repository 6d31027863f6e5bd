"""One suite a contract, to be run against every class that makes it: subclass and give a fixture."""

import pytest

pytest.register_assert_rewrite("contracts.suites")
