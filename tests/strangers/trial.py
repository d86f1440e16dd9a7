"""One log of a stranger: `footcal init`, then the one command that it names."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.conftest import Run
from tests.strangers.rigs import Made, Write


@dataclass(frozen=True)
class Trial:
    """How a log fared.

    Parameters
    ----------
    outcome
        ``calibration``, ``next step``, or why it is neither; ``WRONG: …`` where a calibration
        that was accepted is not the truth.
    made
        The log and its truth.
    """

    outcome: str
    made: Made

    @property
    def good(self) -> bool:
        """Whether the outcome is one of the two that were promised."""
        return self.outcome in ("calibration", "next step")

    @property
    def wrong(self) -> bool:
        """Whether a wrong calibration was called good."""
        return self.outcome.startswith("WRONG")


def trial(shape: Write, folder: Path, run: Run, seed: int = 0) -> Trial:
    """Make a log, run `init` on it and the command it names, compare with the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    made = shape(folder, np.random.default_rng(seed))
    recipe = folder / "guess.toml"
    answer = run("init", *made.paths, "-o", recipe)
    if answer.exit_code != 0 and "footcal convert" in answer.err:
        # a file that is no text: what the remedy says, then the same again
        converted = folder / "converted"
        done = run("convert", *made.paths, "--out", converted, "--quiet")
        if done.exit_code == 0:
            answer = run("init", *sorted(converted.glob("*.parquet")), "-o", recipe)
    if answer.exit_code != 0:
        said = made.says and made.says in answer.err and "Remedy" in answer.err
        return Trial("next step" if said else f"init: {answer.err.strip()}", made)
    line = next(x for x in answer.out.splitlines() if x.startswith("next: "))
    command = re.search(r"footcal ([a-z-]+) ", line)
    assert command is not None, line
    done = run(command[1], "--recipe", recipe, "--out", folder / "out", "--quiet")
    if made.says:
        # a fit that is not to be trusted ends with 3 too, and has a report that says why
        reported = (folder / "out" / "report.html").is_file()
        told = made.says in line and done.exit_code in (2, 3) and (
            "Remedy" in done.err or reported
        )  # fmt: skip
        if not told:
            wrong = "WRONG: " if done.exit_code == 0 else ""
            return Trial(f"{wrong}{line} | {done.exit_code} {done.err}", made)
        if made.fill is None:
            return Trial("next step", made)
        recipe.write_text(made.fill(recipe.read_text(encoding="utf-8")), encoding="utf-8")
        done = run(command[1], "--recipe", recipe, "--out", folder / "filled", "--quiet")
        error = compared(made, folder / "filled", command[1], done.exit_code, done.err)
        return Trial(error or "next step", made)
    error = compared(made, folder / "out", command[1], done.exit_code, done.err)
    return Trial(error or "calibration", made)


def compared(made: Made, out: Path, command: str, exit_code: int, err: str) -> str:
    """What is not as it was made; empty where all is."""
    if exit_code != 0:
        return f"{command} ended with {exit_code}: {err.strip()}"
    if made.cop_within_m:
        rows = json.loads((out / "rmse.json").read_text())["rows"]
        left = [r["rmse"] for r in rows if r["split"] == "held_out" and r["stage"] == "after"]
        good = len(left) == 1 and left[0] < made.cop_within_m
        return "" if good else f"WRONG: CoP errors {left}"
    record = json.loads((out / "parameters.json").read_text())["parameters"]
    for end, value in made.truth.values.items():
        found = [p["value"] for name, p in record.items() if name.endswith(end)]
        if len(found) != 1 or abs(found[0] - value) > made.truth.within[end]:
            return f"WRONG: {end}: {found} for {value:.6g} ± {made.truth.within[end]:.2g}"
    return ""
