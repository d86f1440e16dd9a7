"""The process: signals are watched before anything heavy is imported, and until it ends."""

from __future__ import annotations

import signal
import sys


def run() -> None:
    """Run the command line of this process."""
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


if __name__ == "__main__":
    run()
