"""Which answers may still come, and what to ask so that none of them is taken for another.

A robot answers in order. Once a question is answered that was not asked before, nothing older can come.
"""

from khepera_forage.robots.serial.protocol import Request

_FENCES = tuple(Request(*f) for f in (("E",), ("B",), ("K",), ("I", (0,)), ("H",), ("O",), ("N",)))
"""Questions that change nothing, the shortest first; more than a robot is asked in vain before it is lost."""


class Unsettled:
    """Commands to which an answer may still come: the unanswered ones, and the last answered one, a second time."""

    def __init__(self) -> None:
        self._commands: set[str] = set()

    def sent(self, request: Request) -> None:
        """It was sent."""
        self._commands.add(request.command)

    def answered(self, request: Request) -> None:
        """It was answered, and nothing older can come. It must not have been unsettled when it was sent."""
        self._commands = {request.command}

    def clear(self) -> None:
        """The robot has started anew, and owes no answer."""
        self._commands.clear()

    def fence_for(self, request: Request) -> Request | None:
        """What is to be asked first, so that the answer to this request can be told from an older one; often nothing.

        With all fences unsettled the first is as good as any: it proves nothing, but shows whether there is a robot.
        """
        if request.command not in self._commands:
            return None
        return next((fence for fence in _FENCES if fence.command not in self._commands), _FENCES[0])
