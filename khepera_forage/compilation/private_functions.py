"""Private functions: only an entrance has a name in its machine code, and not what it calls.

Numba numbers functions and record types in the order in which a process meets them, and names compiled functions by
these numbers. So two processes may keep machine code on disk in which one name means different functions, and a process
that loads both would call the wrong one.

The method replaced here is an internal of numba. Where it does not exist, numba compiles as usual.
"""

from typing import Any

from numba.core import codegen

_LIBRARY = getattr(codegen, "CPUCodeLibrary", None)
_NAME = "_finalize_final_module"


class PrivateFunctions:
    """Makes what an entrance calls private while it is switched on; used under numba's compiler lock."""

    def __init__(self) -> None:
        self._usual: Any = None

    def switch(self, on: bool) -> None:
        """Replace numba's method, or restore it."""
        if on and self._usual is None and hasattr(_LIBRARY, _NAME):
            usual = self._usual = getattr(_LIBRARY, _NAME)

            def finalize(library: Any) -> None:
                for function in library._final_module.functions:
                    # Numba gives this linkage to the functions of linked libraries.
                    if not function.is_declaration and function.linkage.name == "linkonce_odr":
                        function.linkage = "internal"
                usual(library)

            setattr(_LIBRARY, _NAME, finalize)
        elif not on and self._usual is not None:
            setattr(_LIBRARY, _NAME, self._usual)
            self._usual = None
