"""Commands run as a user would run them; what is there is not run again."""

from __future__ import annotations

from pathlib import Path

from footcal_cli.app import main as footcal


def run(command: str, *arguments: str | Path, out: Path) -> Path:
    """Run a command into a folder and return it; exit code 1 (a gate) leaves its results too.

    Raises
    ------
    RuntimeError
        Any other end.
    """
    if (out / "run.json").exists():
        return out
    try:
        footcal([command, *map(str, arguments), "--out", str(out), "--overwrite", "--quiet"])
    except SystemExit as end:
        if end.code not in (0, 1, None):
            raise RuntimeError(f"footcal {command} ended with {end.code}") from end
    return out
