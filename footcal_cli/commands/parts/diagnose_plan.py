"""Only the next experiment: for a pair of effects, or for a diagnosis made before."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from footcal_cli.commands.diagnose import DiagnoseOptions
    from footcal_cli.core.diagnosis.rehearsal import Contender
    from footcal_cli.core.diagnosis.rig import Rig
    from footcal_cli.core.effects.contract import Effect
    from footcal_cli.records.diagnosis import DiagnosisRecord
    from footcal_cli.session.session import Outcome, Session


def planned(session: Session[DiagnoseOptions]) -> Outcome:
    """The menu for the rivals that were named, without any log."""
    from footcal_cli.core.diagnosis.menu import advice, menu_for
    from footcal_cli.records.diagnosis import NextExperimentRecord, PlanRecord
    from footcal_cli.records.results import VerdictRecord
    from footcal_cli.report import Report
    from footcal_cli.session.session import Outcome
    from footcal_cli.sheets.diagnosis.experiment import (
        experiment_record,
        experiment_words,
        menu_sheets,
        options_of,
        prospect_record,
    )
    from footcal_cli.sheets.diagnosis.words import together, words

    table = session.table
    rivals = _rivals(session)
    names = tuple(dict.fromkeys(r.signature.effect for r in rivals))
    with session.step("plan"):
        menu = menu_for(rivals, table, _rig(session, [table[n] for n in names]))
    chosen = experiment_record(menu)
    if chosen is None:
        said = advice([table[n] for n in names]) or "nothing in the table of effects"
        chosen = NextExperimentRecord(id="", kind="", words=said, between=names)
    asked = together(words(n) for n in names)
    return Outcome(
        report=Report(
            title=f"The next experiment: {asked}",
            verdict=VerdictRecord(
                level="good" if chosen.id else "warning",
                sentence=f"To tell {asked} apart, run: {experiment_words(chosen)}.",
                details=(f"Then: footcal diagnose … --experiment {options_of(chosen)}.",)
                if chosen.id
                else ("No experiment that footcal knows distinguishes them.",),
            ),
            lead_sheets=menu_sheets(menu),
        ),
        records={
            "plan.json": PlanRecord(
                between=names,
                next_experiment=chosen,
                menu=tuple(prospect_record(menu, p) for p in menu.prospects),
            )
        },
    )


def _rivals(session: Session[DiagnoseOptions]) -> tuple[Contender, ...]:
    """The effects to tell apart, with the sizes that a diagnosis gave them or their usual ones."""
    from footcal_cli.core.diagnosis.rehearsal import Contender
    from footcal_cli.core.inference.problem import Signature
    from footcal_cli.errors import UsageError
    from footcal_cli.records.effects import known_effect

    record = _diagnosis(session.request.logs)
    names = session.options.between
    if not names and record is not None and record.rivals:
        names = record.rivals[0]
    for name in names:
        known_effect(name, session.table, "--between")
    if len(names) < 2:
        raise UsageError(
            "--plan needs two effects to distinguish",
            remedy="give --between EFFECT twice, or a diagnosis.json whose verdict is ambiguous",
        )
    sizes: dict[str, dict[str, float]] = {}
    for row in record.effects if record is not None else ():
        if row.size:
            sizes[row.effect] = {row.parameter: row.size}
    for cause in record.causes if record is not None else ():
        sizes[cause.effect] = {cause.parameter: cause.size, **cause.shape}
    found = []
    for name in names:
        effect = session.table[name]
        values = {p.name: p.neutral for p in effect.shapes}
        values |= sizes.get(name, {effect.size.name: effect.size.neutral + effect.size.prior_sd})
        found.append(Contender(Signature(name, effect.size.name, "", effect.size.unit), values))
    return tuple(found)


def _diagnosis(logs: tuple[Path, ...]) -> DiagnosisRecord | None:
    from footcal_cli.records.diagnosis import DiagnosisRecord
    from footcal_cli.records.files import read_record

    return read_record(DiagnosisRecord, logs[0]) if logs else None


def _rig(session: Session[DiagnoseOptions], effects: list[Effect]) -> Rig:
    """The robot of the recipe; experiments on cells, or on legs where cells have no say."""
    from dataclasses import replace

    from footcal_cli.core.diagnosis.rig import Rig

    robot = session.recipe.robot
    cells = ("weights", "placements", "stand", "walk")
    legs = ("hang", "pose")
    on_cells = any(set(e.experiments) & set(cells) for e in effects)
    kinds = legs if (robot.legs and not robot.feet) or not on_cells else cells
    rig = Rig(kinds=kinds)
    feet = {
        name: {cell: (c.x_m, c.y_m) for cell, c in foot.cells.items()}
        for name, foot in robot.feet.items()
        if len(foot.cells) >= 3
    }
    biped = replace(rig.biped, feet=feet) if len(feet) == 2 else rig.biped
    if robot.mass_kg:
        biped = replace(biped, mass_kg=robot.mass_kg)
    return replace(rig, biped=biped, full_load_n=0.5 * biped.weight_n)
