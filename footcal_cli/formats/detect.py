"""Which reader a file needs, by its name and, for folders, by what lies in them."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from footcal_cli.errors import DataError, UsageError
from footcal_cli.formats.contract import ClockOf, Stream
from footcal_cli.tables.foreign import (
    READERS,
    SEGMENTS,
    is_of_cards,
    is_of_documents,
    kind_of_records,
)


def open_source(path: Path, clock: ClockOf) -> tuple[Stream, ...]:
    """The streams of a foreign file or folder.

    Raises
    ------
    UsageError
        No such file, a suffix that no reader knows, or a missing library.
    DataError
        The file is empty or damaged.
    """
    if not path.exists():
        raise UsageError("no such file", file=path, remedy="check the path")
    suffix = Path(path.name.removesuffix(".gz")).suffix.lower()
    if path.is_dir():
        if not (path / "metadata.yaml").is_file():
            raise UsageError(
                "a folder without metadata.yaml is no ROS 2 bag", file=path,
                remedy="name the files in it, or run ros2 bag reindex",
            )  # fmt: skip
        suffix = ".db3"
    elif suffix not in READERS:
        raise UsageError(
            f"no reader for '{suffix or path.name}'", file=path,
            remedy=f"one of {' '.join(sorted(READERS))}, or the folder of a ROS 2 bag",
        )  # fmt: skip
    elif path.stat().st_size == 0:
        raise DataError("the file is empty", file=path, remedy="record or export it again")
    reader = READERS[suffix]
    if reader in ("logs", "documents") and suffix not in (".parquet", ".pq"):
        reader = _of_texts(path)
    found: tuple[Stream, ...] = import_module(f"footcal_cli.formats.{reader}").streams(path, clock)
    return found


def _of_texts(path: Path) -> str:
    """The reader of a text: printed messages, records, or a table."""
    if path.suffix == ".gz":
        return "logs"
    with path.open("rb") as stream:
        text = stream.read(2**16).decode("utf-8", errors="replace")
        if text.lstrip().startswith(("{", "[")):  # one document, to be seen whole
            text += stream.read(2**26).decode("utf-8", errors="replace")
    if is_of_documents(text):
        return "documents"
    kinds = {
        "": "logs", "HTML": "webpages", "JSON": "lines", "Python": "lines", SEGMENTS: "lvm"
    }  # fmt: skip
    reader = kinds.get(kind_of_records(text), "records")
    return "records" if reader == "logs" and is_of_cards(text) else reader
