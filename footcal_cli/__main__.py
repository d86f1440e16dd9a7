"""The process: signals are watched before anything heavy is imported, and until it ends."""

from __future__ import annotations

import gc
import os
import signal
import sys

from footcal_cli import NEW_OBJECTS


def _leave(number: int, _frame: object) -> None:
    """End at once while the first imports are under way: nothing has begun."""
    sys.stderr.write("footcal: interrupted, nothing half-written\n")
    sys.stderr.flush()
    os._exit(128 + number)


def run() -> None:
    """Run the command line of this process."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)
    gc.set_threshold(NEW_OBJECTS)
    # no plugin has a say in tables of options: to look for one reads what is installed
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    from footcal_cli.session.interruption import Interrupted, watched

    with watched(until_exit=True) as interruption:
        try:
            from footcal_cli.app import main

            main()
        except Interrupted:
            sys.stderr.write("footcal: interrupted, nothing half-written\n")
            raise SystemExit(interruption.exit_code) from None
        finally:
            # the result stands: a signal from now on must not change the exit code
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)
            # the process ends: to search all modules for garbage would take a tenth of a second
            gc.freeze()


if __name__ == "__main__":
    run()
