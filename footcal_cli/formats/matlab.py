"""MATLAB files: up to version 7 by SciPy, version 7.3 (an HDF5 file) by h5py."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import tables
from footcal_cli.formats.contract import Array, ClockOf, Stream
from footcal_cli.formats.hdf5 import arrays_of

_HDF5 = b"\x89HDF\r\n\x1a\n"
_USER_BLOCK = 512


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """Arrays of all variables; structs by dotted names.

    Raises
    ------
    DataError
        Truncated, or no MATLAB file.
    """
    with path.open("rb") as stream:
        start = stream.read(_USER_BLOCK + len(_HDF5))
    if start.endswith(_HDF5) or start.startswith(_HDF5):
        return tables(arrays_of(path, matlab=True), path.stem, "MATLAB 7.3")
    from scipy.io import loadmat

    try:
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    except Exception as error:
        raise DataError(
            f"not a readable MATLAB file (truncated?): {str(error).splitlines()[0] or error!r}"
            if str(error) else "not a readable MATLAB file (truncated?)",
            file=path, remedy="copy it again, or save it again in MATLAB",
        ) from None  # fmt: skip
    arrays: dict[str, Array] = {}
    for name, value in content.items():
        if not name.startswith("__"):
            _collect(name, value, arrays)
    return tables(arrays, path.stem, "MATLAB")


def _collect(name: str, value: Any, arrays: dict[str, Array]) -> None:
    """Numbers and texts of a variable; fields of structs by dotted name."""
    fields = getattr(value, "_fieldnames", None)
    if fields is not None and {"values", "label"} <= set(fields) and (own := _signals(value)):
        arrays |= {f"{name}.{label}": values for label, values in own.items()}
        return
    if fields is not None:
        for field in fields:
            _collect(f"{name}.{field}", getattr(value, field), arrays)
        return
    array = np.asarray(value)
    if array.dtype.kind == "O" and array.ndim == 1 and array.size and _is_struct(array[0]):
        joined = _trials(array)
        if joined:
            arrays |= {f"{name}.{field}": values for field, values in joined.items()}
            return
        for i, element in enumerate(array):
            _collect(f"{name}_{i}", element, arrays)
        return
    if array.dtype.kind == "O" and not all(isinstance(item, str) for item in array.ravel()):
        array = np.empty(0, dtype="V1")  # a cell array: no column
    arrays[name] = array


def _signals(struct: Any) -> dict[str, Array]:
    """Signals of Simulink's To Workspace by their label (``load, raw``); empty where it names none.

    A label names as many signals as `values` has columns.
    """
    values = np.asarray(struct.values)
    labels = [word.strip() for word in re.split(r"[,;]", str(struct.label))]
    columns = list(np.atleast_2d(values.T)) if values.ndim in (1, 2) else []
    if len(set(labels)) != len(columns) or not all(labels):
        return {}
    return dict(zip(labels, columns, strict=True))


def _trials(elements: Array) -> dict[str, Array]:
    """A struct array of trials below each other: vectors joined, each scalar repeated beside them.

    Empty where the elements are no such trials.
    """
    parts: dict[str, list[Array]] = {}
    for element in elements:
        fields = {f: np.asarray(getattr(element, f)) for f in element._fieldnames}
        lengths = {a.size for a in fields.values() if a.ndim == 1 and a.dtype.kind in "biuf"}
        scalars = [a for a in fields.values() if a.ndim == 0 and a.dtype.kind in "biufU"]
        if len(lengths) != 1 or not scalars:
            return {}
        rows = lengths.pop()
        for field, values in fields.items():
            if values.ndim == 0 and values.dtype.kind in "biufU":
                parts.setdefault(field, []).append(np.full(rows, values))
            elif values.ndim == 1 and values.size == rows:
                parts.setdefault(field, []).append(values)
    whole = {f: own for f, own in parts.items() if len(own) == elements.size}
    return {field: np.concatenate(own) for field, own in whole.items()}


def _is_struct(value: object) -> bool:
    return hasattr(value, "_fieldnames")
