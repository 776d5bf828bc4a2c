"""The one exception of the library."""

from __future__ import annotations

from ._core import ErrorCode


class Error(RuntimeError):
    """Misuse or failure. The message says what is wrong, where, and what to do. A lost object is no error."""

    code: ErrorCode  #: What kind of thing is wrong.

    def __init__(self, message: str, code: ErrorCode) -> None:
        super().__init__(message)
        self.code = code

    def __reduce__(self) -> tuple:
        return type(self), (str(self), self.code)
