"""How far a run has come."""

import sys
from collections.abc import Callable

Told = Callable[[str, int, int], object]
"""Called with what is going on, how much of it is done, and of how much: 0 where that is not known."""


def teller(progress: Told | bool | None) -> Told | None:
    """Chooses the listener: a line on standard error for True, none for False and None."""
    if progress is True:
        return _line
    return progress or None


def _line(stage: str, done: int, total: int) -> None:
    share = f" {done / total:4.0%}" if total else ""
    # A file is no place for a line that changes.
    if sys.stderr.isatty():
        end = "\n" if total and done >= total else ""
        sys.stderr.write(f"\r\033[K{stage}{share}{end}")
        sys.stderr.flush()
