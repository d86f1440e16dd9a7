"""``footcal check``: what is wrong with a log, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from footcal_cli.commands.options import (
    Logs,
    NoPictures,
    Out,
    Overwrite,
    Quiet,
    RecipeFile,
    StrictFindings,
    begin,
)
from footcal_cli.recipe import CommandOptions, Recipe

if TYPE_CHECKING:
    from footcal_cli.columns import TableType
    from footcal_cli.core.quality import Finding
    from footcal_cli.session import Outcome, Session
    from footcal_cli.tables import Table

_ORDER = {"alarm": 0, "warning": 1, "note": 2}


class CheckOptions(CommandOptions):
    """``[check]`` of a recipe."""

    intended_load_n: tuple[float, float] | None = None


def check(
    logs: Logs = None,
    recipe: RecipeFile = None,
    strict_findings: StrictFindings = None,
    out: Out = Path("out/check"),
    overwrite: Overwrite = False,
    no_pictures: NoPictures = False,
    quiet: Quiet = False,
) -> None:
    """Look for what is wrong with a log: units, gaps, stuck, saturated or copied channels."""
    session = begin(
        "check",
        CheckOptions,
        logs=logs,
        recipe=recipe,
        out=out,
        overwrite=overwrite,
        quiet=quiet,
        no_pictures=no_pictures,
        strict_findings=strict_findings,
    )
    raise typer.Exit(session.finish(_check(session)))


def _check(session: Session[CheckOptions]) -> Outcome:
    from footcal_cli.records.results import FindingRecord, VerdictRecord
    from footcal_cli.report import Report, Sheet
    from footcal_cli.session import Outcome

    findings: list[Finding] = []
    looked_at: list[tuple[str, str, str]] = []
    with session.step("read"):
        for kind in _table_types(session):
            for table in session.read(kind, kind.name):
                looked_at.append((table.path.name, kind.name, str(len(table))))
                findings += _findings(table, kind, session)
    if not looked_at:
        _refuse(session)
    findings += session.noted
    findings.sort(key=lambda finding: _ORDER[finding.severity])
    serious = [finding for finding in findings if finding.severity != "note"]
    rows = sum(int(n) for _, _, n in looked_at)
    verdict = VerdictRecord(
        level="good" if not serious else "bad" if serious[0].severity == "alarm" else "warning",
        sentence=f"{len(serious)} findings in {rows} rows."
        if serious
        else f"Nothing wrong found in {rows} rows.",
        details=(
            "Checked: units, stamps and gaps, lost samples, end codes, stuck channels, readings "
            "that channels share.",
        ),
    )
    return Outcome(
        report=Report(
            title="Check of the log",
            verdict=verdict,
            sheets=(Sheet("Logs", ("file", "read as", "rows"), looked_at),),
            findings=tuple(FindingRecord.of(finding) for finding in findings),
        ),
    )


def _table_types(session: Session[CheckOptions]) -> list[TableType]:
    """Kinds of log to try, as far as the recipe or the files' headers name their channels."""
    from footcal_cli import columns
    from footcal_cli.tables import column_names

    robot = session.recipe.robot
    headers = [column_names(path) for path in session.request.logs if path.is_file()]
    counted = [name.removesuffix("_counts") for h in headers for name in h if "_counts" in name]
    channels = robot.cell_names or tuple(dict.fromkeys(counted))
    feet = tuple(robot.feet) or ("left", "right")
    cells_of_a_foot = next((tuple(foot.cells) for foot in robot.feet.values() if foot.cells), ())
    kinds = [
        columns.weights_table(),
        columns.hang_table(),
        columns.poses_table(),
        columns.body_table(feet),
        columns.six_axis_feet_table(feet),
    ]
    if cells_of_a_foot:
        kinds.append(columns.placements_table(cells_of_a_foot))
    if channels:
        kinds.append(columns.cells_table(channels))
    return kinds


def _refuse(session: Session[CheckOptions]) -> None:
    from footcal_cli.columns import weights_table
    from footcal_cli.errors import DataError

    if session.request.logs:
        missing = next((path for path in session.request.logs if not path.is_file()), None)
        if missing is None:
            raise DataError(
                "the columns are those of no known kind of log", file=session.request.logs[0],
                remedy="map them in the recipe's [columns]",
            )  # fmt: skip
    session.read_required(weights_table())


def _findings(table: Table, kind: TableType, session: Session[CheckOptions]) -> list[Finding]:
    """The findings that make sense for a kind of log."""
    import numpy as np

    from footcal_cli.core.quality import check_clock, check_codes, check_stream

    if kind.name == "weights":
        return weights_findings([table], session.recipe, session.options.intended_load_n)
    names = [c.name for c in kind.columns if c.missing == "keep" and c.name in table]
    if kind.name in {"hang", "poses"}:
        group = "orientation" if kind.name == "hang" else "pose"
        findings = []
        for leg in dict.fromkeys(table.text("leg")):
            rows = table.text("leg") == leg
            readings = table.numbers(names)[rows]
            order = np.arange(readings.shape[0], dtype=float)
            labels = [f"{leg}.{name.rsplit('_', 1)[0]}" for name in names]
            findings += check_stream(order, readings, labels)
            if "time_s" in table:
                for part in dict.fromkeys(table.text(group)):
                    at = rows & (table.text(group) == part)
                    findings += check_clock(table.number("time_s")[at], f"{leg}, {part}")
        return findings
    readings = table.numbers(names)
    if "time_s" not in table:
        return []
    stream = f"{table.path.name}"
    found = check_clock(table.number("time_s"), stream)
    found += check_stream(table.number("time_s"), readings, names)
    for name in (n for n in names if n.endswith("_counts")):
        values = table.number(name)
        found += [
            f
            for f in check_codes(name, values[np.isfinite(values)], session.recipe.robot.adc.bits)
            if f.severity == "alarm" and f.code == "saturated_codes"
        ]
    return found


def weights_findings(
    tables: Sequence[Table], recipe: Recipe, intended_load_n: tuple[float, float] | None
) -> list[Finding]:
    """All findings on weights logs."""
    import numpy as np

    from footcal_cli.commands.parts.bench_logs import by_channel
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
    return sorted(findings, key=lambda finding: _ORDER[finding.severity])


def _merged(findings: Sequence[Finding], channels: int) -> list[Finding]:
    """One finding where every channel has the same one."""
    from dataclasses import replace

    kept: list[Finding] = []
    for code in dict.fromkeys(finding.code for finding in findings):
        alike = [finding for finding in findings if finding.code == code]
        same = len(alike) == channels > 1 and len({f.sentence for f in alike}) == 1
        kept += [replace(alike[0], where="all channels")] if same else alike
    return kept
