"""The column contract of logs: which columns each kind of log has, and in which unit.

A canonical column carries its unit as suffix. `footcal_cli.tables.table` reads files into this
form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

Kind = Literal["number", "text"]
Missing = Literal["refuse", "keep"]

QUANTITIES: Sequence[Mapping[str, str]] = (
    {"n": "N", "mn": "mN", "kn": "kN", "kgf": "kgf", "lbf": "lbf"},
    {"kg": "kg", "g": "g"},
    {"nm": "N*m", "nmm": "N*mm"},
    {"nms": "N*m*s"},
    {"m": "m", "cm": "cm", "mm": "mm"},
    {"s": "s", "ms": "ms", "us": "us", "ns": "ns"},
    {"rad": "rad", "deg": "deg"},
    {"radps": "rad/s", "degps": "deg/s"},
    {"mps2": "m/s^2"},
    {"mps": "m/s"},
    {"degc": "degC", "degf": "degF", "degk": "K"},
    {"pa": "Pa", "kpa": "kPa", "bar": "bar"},
    {"counts": "count"},
)
"""Suffixes of column names -> unit, one quantity each; forces and masses come first."""
UNIT_SUFFIXES: Mapping[str, str] = {
    suffix: unit for quantity in QUANTITIES for suffix, unit in quantity.items()
}
"""Suffix of a column name -> unit."""


def converts(suffix: str, to: str) -> bool:
    """Whether values under one unit suffix can be given under another; a mass has a weight."""
    forces, masses = QUANTITIES[:2]
    return any(suffix in q and to in q for q in QUANTITIES) or (suffix in masses and to in forces)


@dataclass(frozen=True)
class Column:
    """One column of a table type.

    Parameters
    ----------
    name
        Canonical name, with its unit as suffix (``load_n``) where it has one.
    meaning
        One line for the documentation and for error messages.
    kind
        ``number`` or ``text``.
    optional
        Whether a log may come without it.
    missing
        Whether an empty cell is refused or kept as NaN (lost samples of a stream).
    flag
        A number that is 1 or 0; true and false are taken too.
    """

    name: str
    meaning: str
    kind: Kind = "number"
    optional: bool = False
    missing: Missing = "refuse"
    flag: bool = False

    @property
    def suffix(self) -> str | None:
        """The unit suffix of the name, None for a dimensionless or text column."""
        suffix = self.name.rsplit("_", 1)[-1]
        known = self.kind == "number" and "_" in self.name and suffix in UNIT_SUFFIXES
        return suffix if known else None

    @property
    def unit(self) -> str | None:
        """Unit of the canonical column."""
        return UNIT_SUFFIXES[self.suffix] if self.suffix else None


@dataclass(frozen=True)
class TableType:
    """The columns a kind of log has.

    Parameters
    ----------
    name, columns
        The kind and its columns.
    either
        Groups of optional columns of which one must be complete, several times over.
    whole
        Groups of optional columns of which all are there or none.
    """

    name: str
    columns: tuple[Column, ...]
    either: tuple[tuple[tuple[str, ...], ...], ...] = ()
    whole: tuple[tuple[str, ...], ...] = ()


QUATERNION = tuple(f"body_q{a}" for a in "xyzw")
RPY = tuple(f"body_{angle}_rad" for angle in ("roll", "pitch", "yaw"))
ROTVEC = tuple(f"body_rotvec_{a}_rad" for a in "xyz")
ZYZ = ("body_z1_rad", "body_y2_rad", "body_z3_rad")
XYZ = ("body_x1_rad", "body_y2_rad", "body_z3_rad")
AXIS_ANGLE = ("body_axis_x", "body_axis_y", "body_axis_z", "body_angle_rad")
NINE = tuple(f"{i}{j}" for i in "123" for j in "123")
MATRIX = tuple(f"body_r{n}" for n in NINE)
BODY_GRAVITY = tuple(f"body_gravity_{a}" for a in "xyz")
GRAVITY = tuple(f"gravity_{a}" for a in "xyz")
AXIS_COLUMNS = ("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm")


def weights_table() -> TableType:
    """Known weights on one channel at a time, long form."""
    return TableType(
        "weights",
        (
            Column("channel", "name of the load cell", kind="text"),
            Column("load_n", "the known load"),
            Column("counts", "the cell's raw reading"),
            Column("time_s", "time stamp", optional=True),
            Column("temperature_degc", "temperature at the cell", optional=True),
            Column("direction", "+1 loading, -1 unloading", optional=True),
            Column("pieces", "names of the weights in the stack: W1+W2", "text", optional=True),
            Column("repeat", "number of the repetition", optional=True),
            Column("session", "recording session", kind="text", optional=True),
        ),
    )


def weights_stream_table(channels: Sequence[str]) -> TableType:
    """A running recording while known weights are put on and taken off, one column per channel.

    Parameters
    ----------
    channels
        Names of the load cells.
    """
    return TableType(
        "weights_stream",
        (
            Column("time_s", "time stamp"),
            *(
                Column(f"{name}_counts", f"raw reading of cell {name}", missing="keep")
                for name in channels
            ),
            Column("load_n", "the known load at every sample", optional=True, missing="keep"),
            Column("temperature_degc", "temperature at the cells", optional=True),
            Column("session", "recording session", kind="text", optional=True),
        ),
    )


def weights_together_table(channels: Sequence[str], *, known_wrench: bool = False) -> TableType:
    """Known loads on several cells at once, or a known wrench on a sensor of several bridges.

    Parameters
    ----------
    channels
        Names of the cells or bridges.
    known_wrench
        The six components of a wrench are known, not a load per channel.
    """
    known = [f"known_{axis}" for axis in AXIS_COLUMNS]
    if not known_wrench:
        known = [f"{name}_load_n" for name in channels]
    return TableType(
        "weights_together",
        (
            *(Column(f"{name}_counts", f"raw reading of {name}") for name in channels),
            *(Column(name, "the known load") for name in known),
            Column("case", "name of the load case", kind="text", optional=True),
            Column("session", "recording session", kind="text", optional=True),
        ),
    )


def cop_points_table() -> TableType:
    """Points of known position and the centre of pressure an instrument gave for them."""
    return TableType(
        "cop_points",
        (
            Column("placement", "name of the point", kind="text"),
            Column("hole_x_m", "x of the point in the instrument's frame"),
            Column("hole_y_m", "y of the point in the instrument's frame"),
            Column("cop_x_m", "centre of pressure as reported"),
            Column("cop_y_m", "centre of pressure as reported"),
            Column("load_n", "total force", optional=True),
            Column("time_s", "time stamp", optional=True),
        ),
    )


def placements_table(cells: Sequence[str]) -> TableType:
    """A known weight put on known holes of one foot's top plate.

    Parameters
    ----------
    cells
        The cells of a foot (``fl fr rl rr``), in the recipe's order.
    """
    return TableType(
        "placements",
        (
            Column("foot", "which foot", kind="text"),
            Column("placement", "name of the placement", kind="text"),
            *(Column(f"hole_{a}_m", f"{a} of the hole on the foot", missing="keep") for a in "xy"),
            Column("load_n", "the known load"),
            *(Column(f"{cell}_counts", f"raw reading of cell {cell}") for cell in cells),
            Column("repeat", "number of the repetition", optional=True),
            Column("time_s", "time stamp", optional=True),
            Column("temperature_degc", "temperature at the cells", optional=True),
        ),
    )


def cells_table(channels: Sequence[str]) -> TableType:
    """A stream of load cells while standing or walking."""
    return TableType(
        "cells",
        (
            Column("time_s", "time stamp"),
            *(
                Column(f"{name}_counts", f"raw reading of cell {name}", missing="keep")
                for name in channels
            ),
            Column("temperature_degc", "temperature at the cells", optional=True, missing="keep"),
        ),
    )


def zeros_table(channels: Sequence[str]) -> TableType:
    """Readings of load cells that carry nothing: the robot in the air, in time or lift by lift."""
    columns = (
        Column(f"{name}_counts", f"raw reading of cell {name}", missing="keep") for name in channels
    )
    return TableType("zeros", tuple(columns))


def truth_table(channels: Sequence[str]) -> TableType:
    """True forces on the cells, where a simulation or a reference instrument knows them."""
    return TableType(
        "truth",
        (
            Column("time_s", "time stamp"),
            *(Column(f"{name}_n", f"true load on {name}", missing="keep") for name in channels),
        ),
    )


def six_axis_feet_table(feet: Sequence[str]) -> TableType:
    """A stream of six-axis transducers at the ankles while standing or walking."""
    return TableType(
        "six_axis_feet",
        (
            Column("time_s", "time stamp"),
            *(
                Column(f"{foot}_{axis}", f"reading of foot {foot}", missing="keep")
                for foot in feet
                for axis in AXIS_COLUMNS
            ),
        ),
    )


def body_table(feet: Sequence[str]) -> TableType:
    """The robot's own stream: centre of mass, its acceleration, poses of the feet."""

    def stream(name: str, meaning: str, optional: bool = False) -> Column:
        return Column(name, meaning, optional=optional, missing="keep")

    feet_columns: list[Column] = []
    for foot in feet:
        feet_columns += [stream(f"{foot}_foot_{a}_m", f"position of foot {foot}") for a in "xyz"]
        feet_columns += [
            stream(f"{foot}_foot_{angle}_rad", f"Rz(yaw) Ry(pitch) Rx(roll) of foot {foot}", True)
            for angle in ("yaw", "roll", "pitch")
        ]
        frame = (*(f"q{a}" for a in "xyzw"), *(f"r{n}" for n in NINE))
        feet_columns += [stream(f"{foot}_foot_{a}", f"frame of foot {foot}", True) for a in frame]
    vectors = (
        ("com_acc_{}_mps2", "xyz"),
        ("com_vel_{}_mps", "xyz"),
        ("angmom_rate_{}_nm", "xy"),
        ("angmom_{}_nms", "xy"),
        ("imu_acc_{}_mps2", "xyz"),
        ("imu_gyro_{}_radps", "xyz"),
    )
    known = (
        ("com_acc_{}_mps2", "its acceleration, gravity not included"),
        ("com_vel_{}_mps", "its velocity, where there is no acceleration"),
        ("angmom_rate_{}_nm", "angular momentum rate"),
        ("angmom_{}_nms", "angular momentum, where there is no rate"),
        ("imu_acc_{}_mps2", "specific force at the IMU"),
        ("imu_gyro_{}_radps", "angular rate at the IMU"),
    )
    both = (("q", "xyzw"), ("r", NINE))
    frames = [(f"{foot}_foot_{kind}{{}}", axes) for foot in feet for kind, axes in both]
    return TableType(
        "body",
        (
            Column("time_s", "time stamp"),
            *(stream(f"com_{a}_m", "centre of mass") for a in "xyz"),
            *(stream(name.format(a), meaning, True) for name, meaning in known for a in "xyz"),
            *feet_columns,
        ),
        whole=tuple(tuple(name.format(a) for a in axes) for name, axes in (*vectors, *frames)),
    )


def _attitude(missing: Missing) -> tuple[Column, ...]:
    """Attitude of the body, or of what a transducer is mounted on, in one of eight forms."""
    names = (
        *((name, "body to world quaternion") for name in QUATERNION),
        *((name, "body to world: Rz(yaw) Ry(pitch) Rx(roll)") for name in RPY),
        *((name, "body to world rotation vector, axis times angle") for name in ROTVEC),
        ("body_x1_rad", "body to world: Rx(x1) Ry(y2) Rz(z3)"),
        *((name, "body to world: Rz(z1) Ry(y2) Rz(z3)") for name in ZYZ),
        *((name, "body to world: an axis and the angle about it") for name in AXIS_ANGLE),
        *((name, "body to world rotation matrix, row by row") for name in MATRIX),
        *((name, "direction of gravity in the body, of any length") for name in BODY_GRAVITY),
    )
    return tuple(Column(n, meaning, optional=True, missing=missing) for n, meaning in names)


_ANY_ATTITUDE = (QUATERNION, RPY, ROTVEC, ZYZ, XYZ, AXIS_ANGLE, MATRIX, BODY_GRAVITY)


def hang_table() -> TableType:
    """A robot hanging, its legs turning slowly, long form (one row per leg and stamp)."""
    return TableType(
        "hang",
        (
            Column(
                "orientation",
                "axis along gravity (+x -x +z -z), or `names` that say it",
                kind="text",
                optional=True,
            ),
            Column("time_s", "time stamp"),
            Column("leg", "which leg", kind="text"),
            Column("phase_rad", "shaft angle; absent where nothing turns", optional=True),
            *(
                Column(name, "known direction of gravity in the transducer frame", optional=True)
                for name in GRAVITY
            ),
            *_attitude("keep"),
            *(Column(axis, "transducer reading", missing="keep") for axis in AXIS_COLUMNS),
            Column("temperature_degc", "temperature at the transducer", optional=True),
        ),
        either=((("orientation",), GRAVITY, *_ANY_ATTITUDE),),
    )


def legs_table() -> TableType:
    """A stream of a robot with hip transducers, long form (one row per leg and stamp)."""
    return TableType(
        "legs",
        (
            Column("time_s", "time stamp"),
            Column("leg", "which leg", kind="text"),
            Column("phase_rad", "shaft angle"),
            *(Column(axis, "transducer reading", missing="keep") for axis in AXIS_COLUMNS),
            *_attitude("keep"),
            Column("contact", "1 where the leg touches the ground", optional=True, flag=True),
        ),
        either=(_ANY_ATTITUDE,),
    )


def poses_table() -> TableType:
    """A robot standing still in many poses, long form (one row per leg and pose)."""
    return TableType(
        "poses",
        (
            Column("pose", "name or number of the pose", kind="text"),
            Column("leg", "which leg", kind="text"),
            Column("phase_rad", "shaft angle"),
            *(Column(axis, "transducer reading", missing="keep") for axis in AXIS_COLUMNS),
            *_attitude("refuse"),
            Column("contact", "1 where the leg touches the ground", optional=True, flag=True),
        ),
        either=(_ANY_ATTITUDE,),
    )


def base_columns() -> tuple[Column, ...]:
    """Pose of a robot's base in the world, as logs of joint positions have it."""
    names = (
        *(f"base_{axis}_m" for axis in "xyz"), *(f"base_q{axis}" for axis in "xyzw"),
        *(f"base_{angle}_rad" for angle in ("roll", "pitch", "yaw")),
    )  # fmt: skip
    return tuple(
        Column(name, "pose of the base in the world", optional=True, missing="keep")
        for name in names
    )
