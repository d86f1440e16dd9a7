"""What changed since an earlier calibration, in units of its own uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from footcal_cli.core.parameters import Estimates


@dataclass(frozen=True)
class ParameterChange:
    """One parameter then and now.

    Parameters
    ----------
    name, unit
        Of the parameter.
    in_earlier_sd
        now − before over the sd of the earlier estimate.
    in_joint_sd
        The same over its own sd, ``sqrt(sd_before² + sd_now²)``.
    p_value
        Two-sided chance of such a shift where nothing changed, corrected for the number of
        parameters compared (Holm).
    """

    name: str
    unit: str
    before: float
    now: float
    in_earlier_sd: float
    in_joint_sd: float
    p_value: float

    def sentence(self, since: str) -> str:
        """The change in the words of a log book: ``left_rr scale −3.1 sd since 12 May``."""
        owner, _, parameter = self.name.partition(".")
        sd = f"{self.in_earlier_sd:+.1f}".replace("-", "−")
        return f"{owner} {parameter} {sd} sd since {since}"


def find_parameter_changes(now: Estimates, before: Estimates) -> tuple[ParameterChange, ...]:
    """Compare the parameters that both calibrations have, largest joint shift first.

    Parameters
    ----------
    before
        The earlier ones; one in another unit, or without an sd, is another parameter.
    """
    there = {name: i for i, name in enumerate(before.names) if before.sd[i] > 0.0}
    common = [
        (i, name)
        for i, name in enumerate(now.names)
        if name in there and before.units[there[name]] == now.units[i]
    ]
    at = [there[name] for _, name in common]
    believed, earlier = before.values[at], before.sd[at]
    shifts = now.values[[i for i, _ in common]] - believed
    joint = np.hypot(earlier, now.sd[[i for i, _ in common]])
    with np.errstate(divide="ignore", invalid="ignore"):
        in_earlier, in_joint = shifts / earlier, shifts / joint
    p = 2.0 * special.ndtr(-np.abs(in_joint))
    order = np.argsort(-np.abs(in_joint), kind="stable")
    held = np.empty(len(common))
    # Holm: the smallest p counts k times, the next k − 1 times ..., never smaller than the last
    factors = np.arange(len(common), 0, -1)
    held[order] = np.minimum(np.maximum.accumulate(p[order] * factors), 1.0)
    changes = [
        ParameterChange(
            name=name,
            unit=now.units[i],
            before=float(believed[k]),
            now=float(now.values[i]),
            in_earlier_sd=float(in_earlier[k]),
            in_joint_sd=float(in_joint[k]),
            p_value=float(held[k]),
        )
        for k, (i, name) in enumerate(common)
    ]
    return tuple(changes[k] for k in order)
