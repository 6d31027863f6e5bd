"""What a user reads during a training: warnings and errors."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

_PACKAGE = "khepera_forage"


class _Collector(logging.Handler):
    def __init__(self, notices: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._notices = notices

    def emit(self, record: logging.LogRecord) -> None:
        self._notices.append(record.getMessage())


@contextmanager
def collected(notices: list[str]) -> Iterator[None]:
    """Append all warnings of the package to a list instead of printing them."""
    logger = logging.getLogger(_PACKAGE)
    handler, propagated = _Collector(notices), logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagated


def names(notice: str, device: str, cause: str) -> bool:
    """Whether a notice names a device or file, and the cause.

    Args:
        notice: One message.
        device: Port, camera or file.
        cause: Alternatives separated by `|`; empty for any.
    """
    return device in notice and any(part in notice for part in cause.split("|"))
