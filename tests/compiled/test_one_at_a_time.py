"""Processes that need the same machine code at the same time compile it once."""

import os
import subprocess
import sys
from pathlib import Path

CALL = """
from one_at_a_time_example import answer
answer(2)
print(sum(answer.stats.cache_misses.values()), sum(answer.stats.cache_hits.values()))
"""
EXAMPLE = """
from khepera_forage.compilation.decorators import entrance

@entrance
def answer(x):
    return x + 40
"""


def test_two_processes_compile_once(tmp_path: Path) -> None:
    (tmp_path / "one_at_a_time_example.py").write_text(EXAMPLE, encoding="utf-8")
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
    processes = [
        subprocess.Popen([sys.executable, "-c", CALL], env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    counts = [process.communicate(timeout=120)[0].split() for process in processes]
    assert sorted(counts) == [["0", "1"], ["0", "1"], ["1", "0"]]
