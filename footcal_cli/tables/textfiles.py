"""Files that people name: they must be files, of a size that can be meant, and text where due."""

from __future__ import annotations

import gzip
import stat
import zlib
from pathlib import Path

from footcal_cli.errors import DataError, UsageError
from footcal_cli.tables.workbooks import is_workbook, sheet_text


def called_as(path: Path, expression: str) -> str:
    """What an expression for names is compared with: the name, behind its folder's if it has a /.

    >>> called_as(Path("/data/500g/log.csv"), "*/log.csv")
    '500g/log.csv'
    """
    return f"{path.absolute().parent.name}/{path.name}" if "/" in expression else path.name


def regular_file(path: Path, *, at_most: int | None = None) -> None:
    """Refuse what is no file: a folder, a pipe, a device, or more bytes than can be meant.

    Parameters
    ----------
    path
        The file.
    at_most
        Bytes; None for no limit.

    Raises
    ------
    UsageError
        Says what it is instead.
    """
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        raise UsageError("no such file", file=path, remedy="check the path") from None
    except ValueError:  # a NUL byte in the name
        raise UsageError("not the name of a file", remedy="check the path", value=str(path)) from (
            None
        )
    if stat.S_ISDIR(found.st_mode):
        raise UsageError("is a folder, not a file", file=path, remedy="name a file in it")
    if not stat.S_ISREG(found.st_mode):
        raise UsageError(
            "is a pipe or a device, not a file", file=path, remedy="write it to a file first"
        )
    if at_most is not None and found.st_size > at_most:
        raise UsageError(
            f"{found.st_size / 1e6:.1f} MB, more than the {at_most / 1e6:.0f} MB that such a file "
            "may have", file=path, remedy="check that it is the right file",
        )  # fmt: skip


def read_text(path: Path, *, at_most: int) -> str:
    """The text of a UTF-8 file, without its byte order mark.

    Raises
    ------
    UsageError
        No such file, too large, or not UTF-8.
    """
    regular_file(path, at_most=at_most)
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UsageError(
            f"not UTF-8 text: byte {error.start + 1} is 0x{error.object[error.start]:02x}",
            file=path, remedy="save it as UTF-8",
        ) from None  # fmt: skip


def short(text: str, at_most: int = 60) -> str:
    """A text of the file that can stand in one line."""
    return text if len(text) <= at_most else text[: at_most - 1] + "…"


def first_bytes(path: Path, most: int) -> bytes:
    """The first bytes of a text, unpacked; fewer where it is shorter. Of a workbook, its sheet's.

    Raises
    ------
    UsageError
        A workbook, without the library that reads it.
    DataError
        Truncated or damaged.
    """
    if is_workbook(path):
        return sheet_text(path)[:most]
    opener = gzip.open if path.suffix.lower() == ".gz" else open
    try:
        with opener(path, "rb") as stream:
            content: bytes = stream.read(most)
    except (OSError, EOFError, zlib.error) as error:
        raise unreadable(path, error) from None
    return content


def unreadable(path: Path, error: Exception) -> Exception:
    """What to raise for an error of a reader; what the system refuses stays as it is."""
    if isinstance(error, OSError) and error.errno is not None:
        return error
    first = str(error).splitlines()[0] if str(error) else type(error).__name__
    return DataError(
        f"cannot be read to its end (truncated?): {short(first, 120)}", file=path,
        remedy="copy it again",
    )  # fmt: skip


def shown(path: Path) -> str:
    """A path as people know it: relative to the working folder where it lies below it."""
    resolved = path.resolve()
    here = Path.cwd()
    return resolved.relative_to(here).as_posix() if resolved.is_relative_to(here) else str(path)
