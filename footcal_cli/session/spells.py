"""Samples of hanging legs while a wire had lost contact, left out of what is fitted.

Room: session; asked by its inspection of logs and where a fit takes them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footcal_cli.core.checks.intermittent import loose_axes, spells_of, steps_of_axes
from footcal_cli.core.parameters import BoolArray
from footcal_cli.core.quality import Finding
from footcal_cli.tables.columns import AXIS_COLUMNS
from footcal_cli.tables.table import Table


def hanging_spells(table: Table) -> BoolArray:
    """Samples of spells in each axis of a log of hanging legs, shape (n, 6).

    Several legs in attitudes without a name may be walking: none.
    """
    leg = table.text("leg")
    part = table.text("orientation") if "orientation" in table else np.full(len(table), "")
    found = np.zeros((len(table), len(AXIS_COLUMNS)), dtype=bool)
    if "orientation" not in table and len(set(leg)) > 1:
        return found
    held = [c for c in table.data.columns if c == "phase_rad" or c.startswith(("gravity", "body"))]
    wrench, turned = table.numbers(AXIS_COLUMNS), table.numbers(held)
    steps = {name: steps_of_axes(wrench[leg == name]) for name in dict.fromkeys(leg)}
    for name, which in dict.fromkeys(zip(leg, part, strict=True)):
        mine = (leg == name) & (part == which)
        found[mine] = spells_of(wrench[mine], turned[mine] if held else None, steps[name])
    return found


def without_spells(table: Table) -> tuple[Table, list[Finding]]:
    """A log of hanging legs without the samples (NaN) that a loose contact lost."""
    lost, leg = hanging_spells(table), table.text("leg")
    findings = []
    for name in dict.fromkeys(leg):
        mine = leg == name
        loose = loose_axes(table.numbers(AXIS_COLUMNS)[mine], lost[mine])
        lost[mine] &= loose
        if loose.any():
            left = int(lost[mine].any(axis=1).sum())
            findings.append(
                Finding(
                    "spells_left_out", "warning", name,
                    f"{left} of {mine.sum()} samples, in which a wire had no contact, are left out",
                    "mend the cable and record again where the calibration matters",
                )
            )  # fmt: skip
    if not findings:
        return table, []
    wrench = np.where(lost, np.nan, table.numbers(AXIS_COLUMNS))
    columns = dict(zip(AXIS_COLUMNS, wrench.T, strict=True))
    return replace(table, data=table.data.assign(**columns)), findings
