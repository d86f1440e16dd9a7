"""Ctrl-C and SIGTERM: one exception, whatever library was at work when the signal came.

Readers written in C turn an interruption into an error of their own ("truncated?"); the mark kept
here tells `footcal_cli.app` what really happened. Imported by `footcal_cli.app` and
`footcal_cli.__main__`.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

EXIT_INTERRUPTED = 130
EXIT_TERMINATED = 143


class Interrupted(BaseException):
    """A signal came.

    No KeyboardInterrupt: Python ends a process by the signal, whatever was caught, once that one
    has passed through ``exec`` of a text, as half of the imports do.
    """


@dataclass
class Interruption:
    """Which signal came, None for none."""

    signal: int | None = None

    @property
    def exit_code(self) -> int:
        """130 after Ctrl-C, 143 after SIGTERM, as shells count signals."""
        return EXIT_TERMINATED if self.signal == signal.SIGTERM else EXIT_INTERRUPTED


@contextmanager
def watched(*, until_exit: bool = False) -> Iterator[Interruption]:
    """Turn SIGINT and SIGTERM into `Interrupted` and remember that they came.

    Parameters
    ----------
    until_exit
        Leave the handlers to the caller; else the earlier ones come back at the end.
    """
    seen = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield seen  # only the main thread may handle signals
        return

    def handle(number: int, _frame: FrameType | None) -> None:
        seen.signal = number
        raise Interrupted

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield seen
    finally:
        for number, handler in before.items():
            if not until_exit:
                signal.signal(number, handler)
