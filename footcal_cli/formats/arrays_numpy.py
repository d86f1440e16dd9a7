"""NumPy's own files: the arrays of a `.npz`, the one of a `.npy`."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import as_table, tables
from footcal_cli.formats.contract import Array, ClockOf, Stream


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """Tables of a file of arrays; fields of structured arrays by dotted names.

    Raises
    ------
    DataError
        Truncated, no file of arrays, or one of pickled objects.
    """
    try:
        content = np.load(path, allow_pickle=False)
        if isinstance(content, np.ndarray):
            found: dict[str, Array] = {path.stem: content}
        else:
            with content:
                found = {name: content[name] for name in content.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise DataError(
            f"not a readable file of NumPy arrays: {str(error).splitlines()[0]}", file=path,
            remedy="copy it again, or save plain arrays with numpy.savez (no objects)",
        ) from None  # fmt: skip
    arrays: dict[str, Array] = {}
    for name, values in found.items():
        arrays |= as_table(values, name) if values.dtype.names else {name: values}
    return tables(arrays, path.stem, "NumPy")
