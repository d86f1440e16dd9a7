"""A calibration as a consumer needs it: cells, transducers, and what else there is."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footcal_cli.core.chain import Link, chain_of
from footcal_cli.core.effects import find_effect, having
from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.effects.contract import Trait
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.core.spatial import rotation_exp
from footcal_cli.errors import UsageError
from footcal_cli.records.effects import effect_of
from footcal_cli.records.results import ParametersRecord

MOUNTING = having(Trait.MOUNTING)
GAINS = having(Trait.AXIS_GAIN)
LINEAR = having(Trait.LINEAR)
"""Effects that are a matrix between true and shown wrench."""


@dataclass(frozen=True)
class Exported:
    """A file for a consumer.

    Parameters
    ----------
    text
        What stands in it; empty where `write` makes it.
    warnings
        What the calibration holds and the consumer cannot, a sentence each.
    content
        Variables of a binary file, None for a text.
    """

    text: str
    warnings: tuple[str, ...] = ()
    content: Mapping[str, object] | None = None


@dataclass(frozen=True)
class Pose:
    """Nominal place of a transducer in its parent body: position (3,) and rotation (3, 3)."""

    position_m: FloatArray
    rotation: FloatArray


@dataclass(frozen=True)
class HungWeight:
    """What hangs below a transducer: its weight, and its CoM (3,) in the transducer's frame.

    `swing_m` is how far the CoM moves with the leg's shaft about that mean.
    """

    weight_n: float
    com_m: FloatArray
    swing_m: float = 0.0


@dataclass(frozen=True)
class ToExport:
    """A calibration, and what the recipe adds to it.

    Parameters
    ----------
    record
        ``parameters.json``.
    source
        Its name, for comments.
    nominal, hung
        By transducer, from the recipe: nominal pose, and what hangs below where the calibration
        does not say.
    """

    record: ParametersRecord
    source: str
    nominal: Mapping[str, Pose]
    hung: Mapping[str, HungWeight]

    @property
    def cells(self) -> tuple[str, ...]:
        """Load cells with scale and bias."""
        return self._owners("scale", "bias")

    @property
    def transducers(self) -> tuple[str, ...]:
        """Six-axis transducers with six offsets."""
        return self._owners(*(f"offset_{axis}" for axis in AXES))

    def _owners(self, *parameters: str) -> tuple[str, ...]:
        names = self.record.parameters
        owners = dict.fromkeys(name.rpartition(".")[0] for name in names)
        return tuple(o for o in owners if all(f"{o}.{p}" in names for p in parameters))

    def values(self, owner: str, names: Sequence[str]) -> FloatArray:
        """Values of one owner's parameters, shape (n,)."""
        return np.array([self.record.value(f"{owner}.{name}") for name in names])

    def offset(self, name: str) -> FloatArray:
        """Offset of a transducer ``[fx fy fz tx ty tz]``: reading = applied wrench + offset."""
        return self.values(name, [f"offset_{axis}" for axis in AXES])

    def load(self, name: str) -> HungWeight:
        """What hangs below a transducer.

        Raises
        ------
        UsageError
            Neither the calibration nor the recipe says it.
        """
        names = self.record.parameters
        means = [f"com_{axis}_mean" for axis in "xyz"]
        if f"{name}.weight" in names and all(f"{name}.{mean}" in names for mean in means):
            swings = [f"com_{axis}_{part}" for part in ("sin", "cos") for axis in "xyz"]
            present = all(f"{name}.{swing}" in names for swing in swings)
            swing = self.values(name, swings).reshape(2, 3) if present else np.zeros((2, 3))
            return HungWeight(
                self.record.value(f"{name}.weight"),
                self.values(name, means),
                float(np.linalg.norm(swing, axis=1).max()),
            )
        if name in self.hung:
            return self.hung[name]
        raise UsageError(
            f"the weight below '{name}' and its CoM are not in the calibration", file=self.source,
            remedy="calibrate it with hang-calib, or give --recipe with weight_below_n and "
            f"com_below_m of [robot.feet.{name}]",
        )  # fmt: skip

    def mounted(self, name: str) -> bool:
        """Whether the mounting of a transducer was calibrated."""
        wanted = [f"{name}.mount_{kind}_{a}" for kind in ("rot", "pos") for a in "xyz"]
        return all(parameter in self.record.parameters for parameter in wanted)

    def turn(self, name: str) -> FloatArray:
        """Rotation (3, 3) from the transducer's real axes to its nominal ones."""
        if not self.mounted(name):
            return np.eye(3)
        return rotation_exp(self.values(name, [f"mount_rot_{axis}" for axis in "xyz"]))

    def shift_m(self, name: str) -> FloatArray:
        """Real origin of a transducer along its nominal axes, from the nominal one, shape (3,)."""
        if not self.mounted(name):
            return np.zeros(3)
        return self.values(name, [f"mount_pos_{axis}" for axis in "xyz"])

    def place(self, name: str) -> Pose:
        """Nominal pose of a transducer in its parent body.

        Raises
        ------
        UsageError
            No recipe says it.
        """
        if name not in self.nominal:
            raise UsageError(
                f"the nominal pose of '{name}' in its parent body is needed", file=self.source,
                remedy=f"give --recipe with position_m and rotation_rpy_rad of [robot.legs.{name}]",
            )  # fmt: skip
        return self.nominal[name]

    def matrix(self, name: str, effects: Collection[str]) -> FloatArray:
        """True wrench = matrix · (reading − offset) by some of `LINEAR`, shape (6, 6)."""
        links = [
            Link(effect_of(item), dict(item.owners))
            for item in self.record.effects
            if item.effect in effects
        ]
        here = {link.effect.name for link in links}
        if self.mounted(name):  # pose-calib keeps the mounting as parameters of its own
            links += [
                Link(find_effect(effect), {name: (name,)})
                for effect in sorted(MOUNTING)
                if effect in effects and effect not in here
            ]
        shown = Log(
            "pose", tuple(f"{name}.{axis}" for axis in AXES), np.arange(6.0), np.eye(6), {},
            np.zeros(6, dtype=np.int64),
        )  # fmt: skip
        values = self.record.values
        return chain_of(links).remove(shown, values)[0].readings.T

    def beyond(self, names: Sequence[str], held: Collection[str]) -> tuple[str, ...]:
        """What a consumer loses of the named sensors that holds only some effects."""
        lost = []
        for item in self.record.effects:
            members = {member for owner in item.owners.values() for member in owner}
            of = sorted({m.split(".")[0] for m in members} & set(names))
            if of and item.effect not in {*held, *having(Trait.CALIBRATION)}:
                lost.append(f"{item.effect} of {', '.join(of)} is not in this file")
        if not set(MOUNTING) <= set(held):
            mounted = [name for name in names if self.mounted(name)]
            if mounted:
                lost.append(f"the mounting of {', '.join(mounted)} is not in this file")
        return tuple(lost)


def head(
    calibration: ToExport, names: Collection[str], lines: Sequence[str], warnings: Sequence[str]
) -> list[str]:
    """Comment lines that open a file: origin, conventions, what was not observed, losses."""
    record = calibration.record
    kept = [
        key for key, parameter in record.parameters.items()
        if parameter.status is Status.PRIOR_KEPT and key.rpartition(".")[0] in names
    ]  # fmt: skip
    origin = f"{record.robot}, {record.command} of {record.created}, from {calibration.source}"
    return [
        f"Written by footcal {record.footcal_version}: {origin}.",
        *lines,
        *(
            [f"Not observable by {record.command}, kept as known before: {', '.join(kept)}."]
            if kept
            else []
        ),
        *(f"WARNING: {warning}." for warning in warnings),
    ]


def only(names: Mapping[str, str], target: str) -> tuple[str, str]:
    """The one sensor that goes into a file, and what the consumer calls it.

    Raises
    ------
    UsageError
        Several were chosen.
    """
    if len(names) != 1:
        raise UsageError(
            f"a {target} file holds one transducer, the calibration has {', '.join(names)}",
            remedy="choose one with --sensor",
        )
    return next(iter(names.items()))


def number(value: float) -> str:
    """A number that reads back as the same double, always with a point.

    Without one (``1e-05``) it is a text to YAML 1.1, which rosparam and ROS 2's launch files read.
    """
    mantissa, letter, exponent = repr(float(value)).partition("e")
    return mantissa + ("" if "." in mantissa or not letter else ".0") + letter + exponent
