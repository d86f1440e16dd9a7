"""Raw columns of long files, piece by piece, so that memory does not grow with the log."""

from __future__ import annotations

import ctypes
import gzip
import sys
import zlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.tables.delimited import LONGEST_HEADER, frame_of, has_plain_signs
from footcal_cli.tables.logfiles import is_parquet, of_arrow, of_series, parquet_file, raw_columns
from footcal_cli.tables.nested import flat_names, flattened
from footcal_cli.tables.rawcolumn import RawColumn
from footcal_cli.tables.reading import Layout
from footcal_cli.tables.textfiles import first_bytes, unreadable

LONG_BYTES = 8 * 2**20
"""Files from this size on are read in pieces."""
PIECE_ROWS = 2**17
PIECE_BYTES = 16 * 2**20


def is_long(path: Path) -> bool:
    """Whether a file is worth reading in pieces."""
    return path.is_file() and path.stat().st_size >= LONG_BYTES


def rows_about(path: Path) -> float | None:
    """About how many rows a file has; None where only reading it would tell."""
    if is_parquet(path):
        return float(parquet_file(path).metadata.num_rows)
    if path.suffix.lower() != ".csv":
        return None
    with path.open("rb") as stream:
        head = stream.read(2**16)
    lines = head.count(b"\n")
    return path.stat().st_size * lines / len(head) if lines else None


def give_back() -> None:
    """Return freed memory to the system between pieces of a long log.

    glibc keeps what lies between blocks in use: over hours that grows to several times what is
    held. Other systems need no such call.
    """
    if "pyarrow" in sys.modules:  # which keeps what it freed, too
        sys.modules["pyarrow"].default_memory_pool().release_unused()
    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)


def raw_pieces(
    path: Path, names: Sequence[str], texts: Collection[str]
) -> Iterator[Mapping[str, RawColumn]]:
    """As `footcal_cli.tables.logfiles.raw_columns`, some rows at a time.

    Raises
    ------
    DataError
        As there; rows are counted from the start of the piece.
    """
    return _of_parquet(path, names) if is_parquet(path) else _of_csv(path, names, texts)


def columns_of(
    path: Path, names: Sequence[str], texts: Collection[str], layout: Layout
) -> Mapping[str, RawColumn]:
    """As `footcal_cli.tables.logfiles.raw_columns`, of a long CSV in half the memory.

    It is read in pieces, as a whole only where a column is not of one kind in all of them, or where
    a fault in it has to be named by its line.
    """
    if layout.plain and not is_parquet(path) and is_long(path):
        with suppress(DataError):
            joined = _joined(path, names, texts)
            if joined is not None:
                return joined
    return raw_columns(path, names, texts, layout)


def _joined(
    path: Path, names: Sequence[str], texts: Collection[str]
) -> Mapping[str, RawColumn] | None:
    """Columns of the pieces of a CSV below each other; None where that would not be the whole."""
    if not has_plain_signs(first_bytes(path, LONGEST_HEADER)):
        return None
    pieces: dict[str, list[RawColumn]] = {name: [] for name in names}
    for piece in _of_csv(path, names, texts):
        for name, parts in pieces.items():
            # a view of the piece's columns would keep all of them until the last one is joined
            parts.append(replace(piece[name], values=piece[name].values.copy()))
    found: dict[str, RawColumn] = {}
    lines = np.arange(sum(part.empty.size for part in pieces[names[0]]), dtype=np.int64) + 2
    give_back()
    for name in names:
        parts = pieces.pop(name)
        kinds = {part.kind for part in parts}
        if len(kinds) != 1 or any(part.values.dtype == np.uint64 for part in parts):
            return None
        values = np.concatenate([part.values for part in parts])
        empty = np.concatenate([part.empty for part in parts])
        found[name] = RawColumn(kinds.pop(), values, empty, lines)
        del parts
        give_back()
    return found


def _of_parquet(path: Path, names: Sequence[str]) -> Iterator[Mapping[str, RawColumn]]:
    import pyarrow as pa

    file = parquet_file(path)
    whole = flat_names(file, path)
    wanted = list(dict.fromkeys(whole[name] for name in names))
    try:
        for batch in file.iter_batches(PIECE_ROWS, columns=wanted, use_threads=False):
            table = pa.Table.from_batches([batch])
            parts = dict(p for name in wanted for p in flattened(name, table.column(name), path))
            yield {name: of_arrow(parts[name], name, path) for name in names}
    except (pa.ArrowException, OSError) as error:
        raise unreadable(path, error) from None


def _of_csv(
    path: Path, names: Sequence[str], texts: Collection[str]
) -> Iterator[Mapping[str, RawColumn]]:
    """Blocks of whole lines, each read under the header; quoted texts may hold line ends."""
    opener = gzip.open if path.suffix.lower() == ".gz" else open
    try:
        with opener(path, "rb") as stream:
            header: bytes = stream.readline()
            block: bytes = stream.read(PIECE_BYTES)
            # names in quotes are no texts with line ends, unless the line ends within them
            quoted = header.count(b'"') % 2 == 1 or b'"' in block
            rest = b""
            while not quoted and (block or rest.strip()):
                whole = rest + block
                cut = whole.rfind(b"\n") + 1 if block else len(whole)
                lines, rest = whole[:cut], whole[cut:]
                if lines.strip():
                    frame = frame_of(header + lines, path, texts)
                    yield {name: of_series(frame[name]) for name in names}
                block = stream.read(PIECE_BYTES)
    except (EOFError, zlib.error, OSError) as error:
        raise unreadable(path, error) from None
    if quoted:
        yield raw_columns(path, names, texts)
