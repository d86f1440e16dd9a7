r"""Zeros of the cells from a log of the robot in the air, in the place of a calibration's.

Room: intake; asked by recordings, long_walks, cases and offline_fit. A cell that carries nothing
reads :math:`r_0`: with its scale :math:`c` (N/count) its bias is :math:`d = -c r_0` (N), whatever
it was on a bench, where no sole or plate hung on it. Scales stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.parameters import Estimates, FloatArray, Status
from footcal_cli.core.quality import Finding
from footcal_cli.records.results import CovarianceBlock, ParametersRecord
from footcal_cli.tables.columns import zeros_table
from footcal_cli.tables.logfiles import digest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from footcal_cli.session.session import Session

_PIECES = 10
"""Rows of a log are not independent: means of so many pieces are compared."""


@dataclass(frozen=True)
class Zeros:
    """What cells read that carry nothing.

    Parameters
    ----------
    counts
        Mean reading, shape (c,).
    spread_counts
        Standard deviation from lift to lift, or from piece to piece of a log, shape (c,).
    lifts
        How many lifts or pieces.
    """

    counts: FloatArray
    spread_counts: FloatArray
    lifts: int

    def sd_n(self, scale: FloatArray) -> float | None:
        r"""How far a zero may be from the mean: ``σ √(1 + 1/n)`` in N, σ that of all cells.

        The zero under a stand is one more draw: what moves it from lift to lift moves it again.
        None where one lift alone says nothing of that.
        """
        if self.lifts < 2:
            return None
        return float(
            np.sqrt(np.mean((scale * self.spread_counts) ** 2) * (1 + 1 / self.lifts))
        )  # fmt: skip


def use_zeros(session: Session[Any], channels: Sequence[str]) -> Zeros | None:
    """The zeros that ``[data] zeros`` says, put into the session's calibration; None without.

    A calibration that was made with the same log keeps its own: it knows more by now.
    """
    paths = session.recipe.data_paths("zeros")
    record = session.parameters
    known = () if record is None else record.inputs.values()
    if not paths or {digest(path) for path in paths} & set(known):
        return None
    zeros = _read(session, channels)
    if record is not None:
        session.parameters = _with_biases(record, channels, zeros)
        session.note([_said(record, session.parameters, channels, paths[0].name)])
    return zeros


def at_zeros(
    session: Session[Any], estimates: Sequence[Estimates], channels: Sequence[str]
) -> list[Estimates]:
    """Estimates of a bench with the zeros of the placements' empty plate; as they are without.

    A plate that is screwed to cells loads them: it moves their zeros from where the bench had them.
    The empty plate is a log of its own (``[data] zeros``), or the placements' rows without a load.
    Without a bench the calibration of ``--parameters`` gets them.
    """
    from footcal_cli.intake.empty_plate import empty_plate
    from footcal_cli.intake.placed_weights import placed

    paths = session.recipe.data_paths("zeros")
    tables = placed(session)
    if not tables:
        return list(estimates)
    if not estimates:
        if paths and session.parameters is not None:
            use_zeros(session, channels)
        return []
    if paths:
        zeros, where = _read(session, channels), paths[0].name
    else:
        scales = {
            name.removesuffix(".scale"): own[name]
            for own in estimates for name in own.names if name.endswith(".scale")
        }  # fmt: skip
        read = empty_plate(tables, session.recipe.robot, scales)
        if not read:
            return list(estimates)
        each = [_zeros_of(session, [rows], own) for own, rows in read.items()]
        channels = [channel for own in read for channel in own]
        zeros = Zeros(
            np.concatenate([z.counts for z in each]),
            np.concatenate([z.spread_counts for z in each]), min(z.lifts for z in each),
        )  # fmt: skip
        where = f"{tables[0].path.name}, rows without a load"
    made, moved = [], dict[str, float]()
    for own in estimates:
        turn, apart, values = np.eye(len(own.names)), np.zeros(len(own.names)), own.values.copy()
        for channel, zero in zip(channels, zeros.counts, strict=True):
            if f"{channel}.bias" not in own.names:
                continue
            at, scale = (own.names.index(f"{channel}.{name}") for name in ("bias", "scale"))
            values[at] = -values[scale] * zero
            moved[channel] = float(values[at] - own.values[at])
            turn[at], apart[at] = 0.0, (zeros.sd_n(values[[scale]]) or 0.0) ** 2
            turn[at, scale] = -zero
        made.append(replace(
            own, values=values, covariance=turn @ own.covariance @ turn.T + np.diag(apart)
        ))  # fmt: skip
    if moved:
        session.note([_moved(moved, where)])
    return made


def _read(session: Session[Any], channels: Sequence[str]) -> Zeros:
    names = [f"{channel}_counts" for channel in channels]
    logs = [table.numbers(names) for table in session.read_beside(zeros_table(channels), "zeros")]
    return _zeros_of(session, logs, channels)


def _zeros_of(session: Session[Any], logs: Sequence[FloatArray], channels: Sequence[str]) -> Zeros:
    """Zeros by readings (n, c) of one or more logs, those that go one way being said."""
    from footcal_cli.core.checks.streams import check_zeros_in_order

    each = -(-_PIECES // len(logs))
    # a row that stands for many is one reading
    new = [log[np.any(np.diff(log, axis=0, prepend=np.nan) != 0.0, axis=1)] for log in logs]
    pieces = [piece for log in new for piece in np.array_split(log, min(each, len(log)))]
    means = np.array([np.nanmean(piece, axis=0) for piece in pieces])
    session.note(check_zeros_in_order(means, channels))
    spread = means.std(axis=0, ddof=1) if len(means) > 1 else np.zeros(len(channels))
    return Zeros(np.nanmean(np.concatenate(logs), axis=0), spread, len(means))


def _with_biases(
    record: ParametersRecord, channels: Sequence[str], zeros: Zeros
) -> ParametersRecord:
    """A calibration whose biases are ``d = −c r₀``, correlated with their scales as that says."""
    names = tuple(record.parameters)
    turn, own = np.eye(len(names)), np.zeros(len(names))
    scale = np.array([record.value(f"{channel}.scale") for channel in channels])
    sd = zeros.sd_n(scale) or 0.0
    parameters = dict(record.parameters)
    for channel, c, zero in zip(channels, scale, zeros.counts, strict=True):
        record.value(f"{channel}.bias")
        at = names.index(f"{channel}.bias")
        turn[at] = 0.0
        turn[at, names.index(f"{channel}.scale")] = -zero
        own[at] = sd**2
        parameters[names[at]] = parameters[names[at]].model_copy(
            update={"value": float(-c * zero), "status": Status.ESTIMATED}
        )
    covariance = turn @ record.covariance_of(names) @ turn.T + np.diag(own)
    for i, name in enumerate(names):
        if name.endswith(".bias") and name.removesuffix(".bias") in channels:
            parameters[name] = parameters[name].model_copy(
                update={"sd": float(np.sqrt(covariance[i, i]))}
            )
    block = CovarianceBlock(names=names, matrix=tuple(map(tuple, covariance.tolist())))
    return record.model_copy(update={"parameters": parameters, "covariance": (block,)})


def _said(
    before: ParametersRecord, after: ParametersRecord, channels: Sequence[str], log: str
) -> Finding:
    return _moved(
        {c: after.value(f"{c}.bias") - before.value(f"{c}.bias") for c in channels}, log
    )  # fmt: skip


def _moved(moved: Mapping[str, float], log: str) -> Finding:
    """Biases that zeros have changed, by channel in N."""
    most = max(moved, key=lambda channel: abs(moved[channel]))
    return Finding(
        "zeros", "note", log,
        f"the zeros of {len(moved)} cells are those of this log, not the calibration's: the "
        f"bias of {most} moves most, by {moved[most]:.3g} N",
        "take these readings out of the logs to keep the zeros of the calibration",
    )  # fmt: skip
