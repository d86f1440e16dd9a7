"""C3D files of motion laboratories, read by ezc3d: analog channels, markers, force plates.

Force plates by the user guide of the format (https://www.c3d.org/docs/C3D_User_Guide.pdf):
``force`` and ``moment`` about the plate's centre are in laboratory axes as the plate gives them,
mostly what the foot does to the plate or its reaction, as the laboratory set it up; the CoP lies on
the surface. What is computed is in N, Nm and m; channels and markers keep their unit, as suffix.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from footcal_cli.errors import DataError
from footcal_cli.formats.arrays import stream_of
from footcal_cli.formats.contract import Array, Arrays, ClockOf, Stream, library, with_unit

_TO_SI = {"N": 1.0, "kN": 1e3, "Nmm": 1e-3, "Nm": 1.0, "mm": 1e-3, "cm": 1e-2, "m": 1.0}


def streams(path: Path, _clock: ClockOf) -> tuple[Stream, ...]:
    """``analog``, ``points`` and ``plate_1 …``, each with ``time_s`` from the first frame on.

    Raises
    ------
    UsageError
        ezc3d is not installed.
    DataError
        Truncated, no C3D file, or a force plate in a unit that is not known.
    """
    ezc3d = library("ezc3d", "c3d", "a C3D file")
    try:
        content = ezc3d.c3d(str(path), extract_forceplat_data=True)
    except Exception as error:
        raise DataError(
            f"not a readable C3D file (truncated?): {(str(error) or repr(error)).splitlines()[0]}",
            file=path, remedy="copy or export it again",
        ) from None  # fmt: skip
    data, parameters = content["data"], content["parameters"]
    analogs, points = data["analogs"], data["points"]
    found: list[Stream] = []
    analog_hz = _rate(parameters, "ANALOG")
    if analogs.size:
        columns = _clocked(analogs.shape[2], analog_hz)
        names = _labels(parameters, "ANALOG", analogs.shape[1])
        units = _texts(parameters, "ANALOG", "UNITS")
        for i, name in enumerate(names):
            columns[with_unit(name, units[i] if i < len(units) else "")] = analogs[0, i]
        found.append(stream_of("analog", "C3D analog", columns))
    if points.size:
        columns = _clocked(points.shape[2], _rate(parameters, "POINT"))
        unit = (_texts(parameters, "POINT", "UNITS") or [""])[0]
        for i, name in enumerate(_labels(parameters, "POINT", points.shape[1])):
            for axis in range(3):
                columns[with_unit(f"{name}.{'xyz'[axis]}", unit)] = points[axis, i]
        found.append(stream_of("points", "C3D points", columns))
    for i, plate in enumerate(data.get("platform", ()), start=1):
        columns = _clocked(plate["force"].shape[1], analog_hz)
        columns |= _plate(plate, path)
        found.append(stream_of(f"plate_{i}", "C3D force plate", columns))
    return tuple(found)


def _plate(plate: dict[str, Any], path: Path) -> Arrays:
    """Force, moment about the plate's centre, and CoP of one force plate in SI units."""
    columns: Arrays = {}
    for key, name, suffix, unit in (
        ("force", "force", "n", plate["unit_force"]),
        ("moment", "moment", "nm", plate["unit_moment"]),
        ("center_of_pressure", "cop", "m", plate["unit_position"]),
    ):
        if unit not in _TO_SI:
            raise DataError(
                f"a force plate gives its {name} in an unknown unit", file=path, value=unit,
                remedy="convert the analog channels: --topic analog",
            )  # fmt: skip
        for axis in range(3):
            values = np.asarray(plate[key][axis], dtype=np.float64) * _TO_SI[unit]
            columns[f"{name}_{'xyz'[axis]}_{suffix}"] = values
    unloaded = columns["force_z_n"] == 0
    for name in ("cop_x_m", "cop_y_m", "cop_z_m"):
        # without force there is no CoP, whatever the division gives
        columns[name] = np.where(unloaded, np.nan, columns[name])
    return columns


def _clocked(rows: int, rate_hz: float) -> Arrays:
    columns: dict[str, Array] = {}
    if rate_hz > 0:
        columns["time_s"] = np.arange(rows) / rate_hz
    return columns


def _rate(parameters: Any, group: str) -> float:
    return float(parameters[group]["RATE"]["value"][0])


def _texts(parameters: Any, group: str, name: str) -> list[str]:
    return [str(text).strip() for text in parameters[group].get(name, {"value": []})["value"]]


def _labels(parameters: Any, group: str, count: int) -> list[str]:
    """A name for each channel: its label, made unique, or its number."""
    names: list[str] = []
    labels = _texts(parameters, group, "LABELS")
    for i in range(count):
        name = labels[i] if i < len(labels) and labels[i] else f"{group.lower()}_{i}"
        names.append(name if name not in names else f"{name}_{i}")
    return names
