"""Standing poses whose six axes have the sign, and whose legs the names, that hanging shows.

Room: sniff; asked by several.
"""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.sniff.file_names import Part
from footcal_cli.sniff.names import name_guess
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


def under_hung_names(parts: list[Part]) -> list[Part]:
    """Standing poses whose legs are called as where they hang: ``lf`` in words, not ``fl``."""
    hung = dict.fromkeys(leg for p in parts if p.plan.role == "hang" for leg in _legs(p.plan))
    called = {name_guess(leg).address or leg: leg for leg in hung}
    return [
        replace(part, plan=_renamed(part.plan, called))
        if part.plan.command == "pose-calib" and len(called) == len(hung) > 1 else part
        for part in parts
    ]  # fmt: skip


def _legs(plan: LogPlan) -> list[str]:
    leg = plan.entries.get("leg")
    if plan.wide or leg is None or leg.column is None:
        return list(plan.wide)
    return [leg.names.get(word, word) for word in leg.column.words]


def _renamed(plan: LogPlan, called: dict[str, str]) -> LogPlan:
    """A plan with the legs of its wide tables under other names; as it is where one has none."""
    given = {leg: called.get(name_guess(leg).address or leg, "") for leg in plan.wide}
    if not all(given.values()) or len({*given.values()}) < len(given):
        return plan
    tables = {f"[robot.legs.{leg}]": f"[robot.legs.{name}]" for leg, name in given.items()}
    heads = [table.partition("\n") for table in plan.robot]
    return replace(
        plan, wide={given[leg]: own for leg, own in plan.wide.items()},
        robot=tuple(f"{tables.get(head, head)}{line}{rest}" for head, line, rest in heads),
    )  # fmt: skip


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
