"""One process that diagnoses what waits in a folder of logs; it is told of nothing else.

``python -m tests.blind.worker FOLDER``, as many as there are cores; each trial is claimed by the
first that comes.
"""

from __future__ import annotations

import argparse
import json
import shutil
import time
from pathlib import Path

from tests.blind.diagnosing import diagnosed, rules_digest

WAIT_S = 1.0


def work(root: Path, *, until_s: float = 0.0, keep_logs: bool = False) -> int:
    """Diagnose what has no verdict and no claim yet, in the order of the queue; how many.

    A queue that is still being filled is waited for.
    """
    digest = rules_digest()
    began, done = time.monotonic(), 0
    while True:
        queue = json.loads((root / "queue.json").read_text("utf-8"))
        for name in queue["names"]:
            if 0 < until_s < time.monotonic() - began:
                return done
            verdict = root / "verdicts" / f"{name}.json"
            if verdict.is_file() or not _claimed(root / "claims" / name):
                continue
            folder, run = root / "logs" / name, root / "runs" / name
            record = {**diagnosed(folder, run), "rules_sha256": digest}
            partial = verdict.with_name(f".{name}.part")
            partial.write_text(json.dumps(record), "utf-8")
            partial.rename(verdict)
            done += 1
            shutil.rmtree(run, ignore_errors=True)
            if not keep_logs:
                shutil.rmtree(folder, ignore_errors=True)
        if queue["complete"]:
            return done
        time.sleep(WAIT_S)


def _claimed(claim: Path) -> bool:
    try:
        claim.touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def run(arguments: list[str] | None = None) -> None:
    """Work until nothing waits or the time is over."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.worker", description=__doc__)
    parser.add_argument("root", type=Path)
    parser.add_argument("--seconds", type=float, default=0.0)
    given = parser.parse_args(arguments)
    work(given.root, until_s=given.seconds)


if __name__ == "__main__":
    run()
