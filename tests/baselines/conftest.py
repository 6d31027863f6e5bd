"""Modules of benchmarks are imported as their scripts import them."""

import sys

from tests.benchmarks.running import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))
