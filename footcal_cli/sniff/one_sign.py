"""Standing poses whose six axes have the sign that hanging shows.

Room: sniff; asked by several.
"""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.plan import LogPlan
from footcal_cli.tables.columns import AXIS_COLUMNS


def of_one_sign(parts: list[Part]) -> list[Part]:
    """Standing poses whose transducers read with the sign that hanging shows."""
    hung = [own.get("fx_n") for part in parts if part.plan.role == "hang"
            for own in (part.plan.entries, *part.plan.wide.values())]  # fmt: skip
    reacts = any(entry is not None and (entry.factor or 1.0) < 0 for entry in hung)
    return [
        replace(part, plan=_turned_round(part.plan))
        if reacts and part.plan.command == "pose-calib" else part for part in parts
    ]  # fmt: skip


def _turned_round(plan: LogPlan) -> LogPlan:
    """A plan whose six axes have the other sign."""
    entries, *wide = (
        {
            name: replace(entry, factor=-(entry.factor or 1.0)) if name in AXIS_COLUMNS else entry
            for name, entry in own.items()
        }
        for own in (plan.entries, *plan.wide.values())
    )  # fmt: skip
    warning = "the axes of the poses were turned round, as hanging shows their sign"
    return replace(
        plan, entries=entries, wide=dict(zip(plan.wide, wide, strict=True)),
        warnings=(*plan.warnings, warning),
    )  # fmt: skip
