"""One family of errors; `footcal_cli.app` turns each into one line and an exit code."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import ClassVar


class FootcalError(Exception):
    """Something the user can mend, said in one line.

    Parameters
    ----------
    file, column, row, value, unit
        Where, as far as it is known. `row` is already in words (``line 8``).
    example
        Lines of what would be taken instead; they follow the message.
    foreign
        Whether `file` was refused for its columns or its layout, so that it may be another kind
        of log.
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
        example: tuple[str, ...] = (),
        foreign: bool = False,
    ) -> None:
        self.problem = problem
        self.file = file
        self.column = column
        self.row = row
        self.value = value
        self.unit = unit
        self.remedy = remedy
        self.example = example
        self.foreign = foreign
        self.suspicion = ""
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
        if self.suspicion:
            text += f". The log looks wrong before that: {self.suspicion}"
        elif self.remedy is not None:
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


class MachineError(FootcalError):
    """The machine failed: a full disk, a missing permission, no memory left."""

    exit_code = 74


_WRONG_PATHS = frozenset(
    {errno.ENOENT, errno.EISDIR, errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP, errno.EEXIST,
     errno.ENXIO, errno.EINVAL, errno.ESPIPE}
)  # fmt: skip
_REMEDIES = {
    errno.ENOSPC: "free space on the disk",
    errno.EDQUOT: "free space in your quota",
    errno.EFBIG: "raise the limit on file sizes",
    errno.EACCES: "ask for the permission, or name another place",
    errno.EPERM: "ask for the permission, or name another place",
    errno.EROFS: "name a place that can be written",
    errno.EMFILE: "raise the limit on open files",
    errno.ENFILE: "close other programs",
}


def lacks_memory(error: BaseException) -> bool:
    """Whether an error says that memory ran out; a library that finds none fails to be imported."""
    words = ("failed to map segment", "cannot allocate memory")
    imported = isinstance(error, ImportError) and any(w in str(error).lower() for w in words)
    return isinstance(error, MemoryError) or imported


def of_machine(error: BaseException) -> FootcalError:
    """What the operating system refused, as an error of the user or of the machine.

    Parameters
    ----------
    error
        An OSError, or one that `lacks_memory` knows.
    """
    if not isinstance(error, OSError):
        return MachineError(
            "not enough memory", remedy="close other programs, or give a shorter log"
        )
    file = error.filename if isinstance(error.filename, str | Path) else None
    problem = f"{(error.strerror or str(error) or type(error).__name__).lower()}"
    if error.errno in _WRONG_PATHS and file is not None:
        return UsageError(problem, file=file, remedy="check the path")
    return MachineError(problem, file=file, remedy=_REMEDIES.get(error.errno or 0, "try again"))


def missing_library(name: str, error: ImportError, problem: str, remedy: str) -> FootcalError:
    """An optional library that could not be imported: not installed, or no memory to load it."""
    from importlib.util import find_spec

    try:
        absent = find_spec(name.partition(".")[0]) is None or find_spec(name) is None
    except ImportError:  # a package that lies there, and cannot be loaded far enough to look
        absent = False
    if absent:
        return UsageError(problem, remedy=remedy)
    return MachineError(
        f"the package {name} is installed but cannot be loaded: {str(error).rsplit(': ', 1)[-1]}",
        remedy=f"close other programs if memory lacks, else install it again: {remedy}",
    )


def nearest(name: str, known: object) -> str:
    """`` (did you mean 'x'?)`` for the closest known name, else nothing."""
    from difflib import get_close_matches

    names = (
        [str(k) for k in known] if isinstance(known, (list, tuple, set, frozenset, dict)) else []
    )
    close = get_close_matches(name, names, n=1, cutoff=0.5)
    return f" (did you mean '{close[0]}'?)" if close else ""
