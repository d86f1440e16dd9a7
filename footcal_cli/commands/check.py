"""``footcal check``: what is wrong with a log, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from footcal_cli.commands.options import (
    Logs,
    Out,
    Overwrite,
    Quiet,
    RecipeFile,
    StrictFindings,
    begin,
)
from footcal_cli.recipe import CommandOptions, Recipe

if TYPE_CHECKING:
    from footcal_cli.core.quality import Finding
    from footcal_cli.session import Outcome, Session
    from footcal_cli.tables import Table


class CheckOptions(CommandOptions):
    """``[check]`` of a recipe."""

    strict_findings: bool = False
    intended_load_n: tuple[float, float] | None = None


def check(
    logs: Logs = None,
    recipe: RecipeFile = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/check"),
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Look for what is wrong with a log: units, stuck, saturated, repeated or swapped channels."""
    session = begin(
        "check",
        CheckOptions,
        logs=logs,
        recipe=recipe,
        out=out,
        overwrite=overwrite,
        quiet=quiet,
        strict_findings=strict_findings,
    )
    raise typer.Exit(session.finish(_check(session)))


def weights_findings(
    tables: Sequence[Table], recipe: Recipe, intended_load_n: tuple[float, float] | None
) -> list[Finding]:
    """All findings on weights logs."""
    import numpy as np

    from footcal_cli.commands.offline_fit import by_channel
    from footcal_cli.core.quality import (
        check_codes,
        check_load_unit,
        check_repeats_across_channels,
    )

    channels = by_channel(tables)
    loads = {name: load_n for name, load_n, _ in channels}
    counts = {name: values for name, _, values in channels}
    findings = [
        f for name in counts for f in check_codes(name, counts[name], recipe.robot.adc.bits)
    ]
    findings = _merged(findings, len(channels))
    findings += check_load_unit(
        np.concatenate(list(loads.values())), intended_load_n, recipe.robot.weight_n
    )
    findings += check_repeats_across_channels(counts, loads)
    order = {"alarm": 0, "warning": 1, "note": 2}
    return sorted(findings, key=lambda finding: order[finding.severity])


def _merged(findings: Sequence[Finding], channels: int) -> list[Finding]:
    """One finding where every channel has the same one."""
    from dataclasses import replace

    kept: list[Finding] = []
    for code in dict.fromkeys(finding.code for finding in findings):
        alike = [finding for finding in findings if finding.code == code]
        same = len(alike) == channels > 1 and len({f.sentence for f in alike}) == 1
        kept += [replace(alike[0], where="all channels")] if same else alike
    return kept


def _check(session: Session[CheckOptions]) -> Outcome:
    from footcal_cli.columns import weights_table
    from footcal_cli.records import FindingRecord, VerdictRecord
    from footcal_cli.report import Report
    from footcal_cli.session import Outcome

    with session.step("read"):
        tables = session.read_required(weights_table())
    findings = weights_findings(tables, session.recipe, session.options.intended_load_n)
    serious = [finding for finding in findings if finding.severity != "note"]
    alarms = [finding for finding in findings if finding.severity == "alarm"]
    rows = sum(len(table) for table in tables)
    verdict = VerdictRecord(
        level="bad" if alarms else "warning" if serious else "good",
        sentence=f"{len(serious)} findings in {rows} rows."
        if serious
        else f"Nothing wrong found in {rows} rows.",
        details=("Checked: units, end codes, stuck channels, readings shared by channels.",),
    )
    gates = [f.code for f in serious] if session.options.strict_findings else []
    return Outcome(
        report=Report(
            title="Check of the log",
            verdict=verdict,
            findings=tuple(FindingRecord.of(finding) for finding in findings),
        ),
        gates_missed=(f"strict findings: {', '.join(gates)}",) if gates else (),
    )
