"""A folder given to ``init``: the logs and notes in it.

Room: sniff; called by init.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from footcal_cli.errors import DataError, UsageError
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.guesses import FileGuess
from footcal_cli.sniff.notes import WRITTEN
from footcal_cli.tables.foreign import READERS
from footcal_cli.tables.workbooks import SUFFIXES

_LOGS = {
    ".csv", ".tsv", ".txt", ".dat", ".log", ".mot", ".sto", ".parquet", ".pq", *SUFFIXES
}  # fmt: skip
"""Endings of what lies in a folder and may be a log."""
_TEXTS = {"logs", "documents", "records", "webpages", "opensim"}
CONVERTED = {suffix for suffix, reader in READERS.items() if reader not in _TEXTS} - {".json"}
"""Endings of what is a log once it is converted; settings are JSON, too."""


def in_folders(paths: Sequence[Path]) -> list[Path]:
    """Files as they are named, and those in folders, in the order of their names.

    Raises
    ------
    UsageError
        A folder holds none.
    """
    found = list[Path]()
    for path in paths:
        if not path.is_dir():
            found.append(path)
            continue
        inside = [file for file in sorted(path.rglob("*")) if _may_be(file, path)]
        if not any(file.suffix.lower() in _LOGS | CONVERTED for file in inside):
            known = " ".join(sorted(_LOGS | CONVERTED))
            raise UsageError("holds no log", file=path, remedy=f"name a file, of {known}")
        found += inside
    return found


def guessed(tables: Sequence[Path], named: Sequence[Path]) -> tuple[list[FileGuess], list[Path]]:
    """What tables hold, and files of a folder that are none.

    Raises
    ------
    DataError
        A file that was named is no table of numbers, or none of a folder is.
    """
    files, none, first = list[FileGuess](), list[Path](), None
    for path in tables:
        try:
            files.append(guess_file(path))
        except DataError as error:
            if path in named:
                raise
            first = first or error
            none.append(path)
    if not files and first is not None:
        raise first
    return files, none


def _may_be(file: Path, folder: Path) -> bool:
    hidden = any(part.startswith(".") for part in file.relative_to(folder).parts)
    known = file.suffix.lower() in _LOGS | CONVERTED | WRITTEN
    return known and not hidden and file.is_file() and file.stat().st_size > 0
