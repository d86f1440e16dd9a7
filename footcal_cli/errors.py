"""One family of errors; `footcal_cli.app` turns each into one line and an exit code."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar


class FootcalError(Exception):
    """Something the user can mend, said in one line.

    Parameters
    ----------
    problem
        What is wrong.
    file, column, row, value, unit
        Where, as far as it is known. `row` is already in words (``line 8``).
    remedy
        What to do about it.
    """

    exit_code: ClassVar[int] = 2

    def __init__(
        self,
        problem: str,
        *,
        file: Path | str | None = None,
        column: str | None = None,
        row: str | None = None,
        value: object = None,
        unit: str | None = None,
        remedy: str | None = None,
    ) -> None:
        self.problem = problem
        self.file = file
        self.column = column
        self.row = row
        self.value = value
        self.unit = unit
        self.remedy = remedy
        super().__init__(self.line())

    def line(self) -> str:
        """The whole message on one line."""
        where = [str(self.file)] if self.file is not None else []
        if self.column is not None:
            where.append(f"column {self.column}")
        if self.row is not None:
            where.append(self.row)
        text = f"{', '.join(where)}: {self.problem}" if where else self.problem
        if self.value is not None:
            shown = repr(self.value) if isinstance(self.value, str) else str(self.value)
            text += f" (value {shown}{' ' + self.unit if self.unit else ''})"
        if self.remedy is not None:
            text += f". Remedy: {self.remedy}"
        return " ".join(text.split())


class UsageError(FootcalError):
    """The command line, a recipe or a parameters file cannot be followed."""

    exit_code = 2


class DataError(FootcalError):
    """A log holds nothing usable, or something that must not be guessed."""

    exit_code = 3


class FitError(FootcalError):
    """The data were read, but the fit asked for is not to be trusted."""

    exit_code = 3


def nearest(name: str, known: object) -> str:
    """`` (did you mean 'x'?)`` for the closest known name, else nothing."""
    from difflib import get_close_matches

    names = (
        [str(k) for k in known] if isinstance(known, (list, tuple, set, frozenset, dict)) else []
    )
    close = get_close_matches(name, names, n=1, cutoff=0.5)
    return f" (did you mean '{close[0]}'?)" if close else ""
