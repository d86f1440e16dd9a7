"""HDF5 files: every dataset by its path, groups as dotted names, units from attributes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import as_table, tables
from footcal_cli.formats.contract import Array, ClockOf, Stream, library, with_unit

_UNIT_ATTRIBUTES = ("unit", "units", "Unit", "Units", "UNIT", "UNITS")


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """Tables of an HDF5 file.

    Raises
    ------
    UsageError
        h5py is not installed.
    DataError
        Truncated, or no HDF5 file.
    """
    return tables(arrays_of(path, matlab=False), path.stem, "HDF5")


def arrays_of(path: Path, *, matlab: bool) -> dict[str, Array]:
    """Every dataset by dotted name.

    Parameters
    ----------
    matlab
        Written by MATLAB: axes reversed, texts as 16-bit codes, references in ``#refs#``.
    """
    h5py = library("h5py", "hdf5", "a MATLAB 7.3 file" if matlab else "an HDF5 file")
    arrays: dict[str, Array] = {}

    def collect(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith(("#refs#", "#subsystem#")):
            return
        dotted = name.replace("/", ".")
        if h5py.check_ref_dtype(item.dtype) is not None:
            arrays[dotted] = np.empty(0, dtype="V1")
            return
        values = np.asarray(item.asstr()[()] if h5py.check_string_dtype(item.dtype) else item[()])
        if matlab:
            kind = item.attrs.get("MATLAB_class", b"")
            if kind == b"char" or "MATLAB_empty" in item.attrs:
                values = np.empty(0, dtype="V1")
            values = values.T.squeeze()
        unit = next((item.attrs[key] for key in _UNIT_ATTRIBUTES if key in item.attrs), "")
        unit = unit.decode() if isinstance(unit, bytes) else str(unit)
        if values.dtype.names:
            arrays.update(as_table(values, dotted))
        else:
            arrays[with_unit(dotted, unit)] = values

    try:
        with h5py.File(path, "r") as file:
            file.visititems(collect)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise DataError(
            f"not a readable HDF5 file (truncated?): {str(error).splitlines()[0]}", file=path,
            remedy="copy it again",
        ) from None  # fmt: skip
    return arrays
