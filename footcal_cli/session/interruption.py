"""Ctrl-C and SIGTERM: one exception, whatever library was at work when the signal came.

Readers written in C turn an interruption into an error of their own ("truncated?"); the mark kept
here tells `footcal_cli.app` what really happened. Imported by `footcal_cli.app` and
`footcal_cli.__main__`.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

EXIT_INTERRUPTED = 130
EXIT_TERMINATED = 143
_AGAIN_AFTER_S = 0.02


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

    Python drops what a finalizer or the callback of a weak reference raises; a signal that came
    just there is raised again a moment later.

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

    dropped = sys.unraisablehook
    main = threading.get_ident()
    pending: list[threading.Timer] = []

    def again(raised: sys.UnraisableHookArgs) -> None:
        if raised.exc_type is not Interrupted:
            dropped(raised)
            return
        # a signal proper: it wakes the main thread from a sleep or a read
        number = seen.signal or signal.SIGINT
        timer = threading.Timer(_AGAIN_AFTER_S, signal.pthread_kill, (main, number))
        timer.daemon = True
        pending.append(timer)
        timer.start()

    sys.unraisablehook = again
    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield seen
    finally:
        if not until_exit:
            sys.unraisablehook = dropped
            for timer in pending:
                timer.cancel()
            for number, handler in before.items():
                signal.signal(number, handler)
