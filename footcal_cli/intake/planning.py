"""What the next experiment is planned for: the rivals and the robot at hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from footcal_cli.core.diagnosis.rehearsal import Contender, usual
from footcal_cli.core.diagnosis.rig import Rig
from footcal_cli.core.effects.contract import Effect
from footcal_cli.errors import UsageError
from footcal_cli.recipe import Robot
from footcal_cli.recipe.options import DiagnoseOptions
from footcal_cli.records.diagnosis import DiagnosisRecord
from footcal_cli.records.effects import known_effect
from footcal_cli.records.files import read_record

if TYPE_CHECKING:
    from footcal_cli.session.session import Session


def rivals_of(session: Session[DiagnoseOptions]) -> tuple[Contender, ...]:
    """The effects to tell apart, with the sizes that a diagnosis gave them or their usual ones."""
    logs = session.request.logs
    record = read_record(DiagnosisRecord, logs[0]) if logs else None
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
        signature = usual(effect)
        values = sizes.get(name, {effect.size.name: effect.size.neutral + effect.size.prior_sd})
        found.append(Contender(signature, {**dict(signature.shape), **values}))
    return tuple(found)


def rig_of(robot: Robot, effects: Sequence[Effect]) -> Rig:
    """The robot of the recipe; experiments on cells, or on legs where cells have no say."""
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
