"""Delayed interrupts, and interrupts while an experience file is opened."""

import signal
import threading
from pathlib import Path
from typing import IO, Any

import numpy as np
import pytest

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import text_format
from khepera_forage.rollouts.training import delayed_interrupts, train


def test_interrupt_while_the_file_is_opened_closes_and_deletes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[IO[Any]] = []

    def interrupted_open(*args: Any, **kwargs: Any) -> IO[Any]:
        file: IO[Any] = open(*args, **kwargs)  # noqa: SIM115 - the test checks that it is closed
        opened.append(file)
        signal.raise_signal(signal.SIGINT)
        return file

    monkeypatch.setattr(text_format, "open", interrupted_open, raising=False)
    with pytest.raises(KeyboardInterrupt):
        train(TrainingEnv(), np.random.SeedSequence(0), path=tmp_path / "g1.csv")
    assert [file.closed for file in opened] == [True]
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_delayed_interrupts_change_nothing_in_other_threads() -> None:
    handlers: list[object] = []

    def in_thread() -> None:
        with delayed_interrupts():
            handlers.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=in_thread)
    thread.start()
    thread.join()
    assert handlers == [signal.default_int_handler]
