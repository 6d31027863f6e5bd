"""Suites of tests for the contracts, run against every implementation."""

import pytest

pytest.register_assert_rewrite("tests.contracts.suites")
