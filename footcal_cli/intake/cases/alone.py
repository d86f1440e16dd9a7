"""What a fit of each cell by itself finds in weights that the diagnosis calls clean.

`offline-fit` judges every cell by its own rows; a diagnosis asks for evidence from many blocks.
What the one command surely finds the other must not deny.
"""

from __future__ import annotations

from footcal_cli.core.bench.ladder import promising
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.study import ChannelStudy, study_rows
from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.intake.cases.shared import CaseRead

_LEVEL, _WORTH = 0.001, 0.9


def found_alone(read: CaseRead, found: Investigation) -> list[ChannelStudy]:
    """Cells that surely need more than a scale and a bias where none was named."""
    case = read.case
    rows_of_cells = case.experiment.name == "weights" and not case.one_recording
    if found.verdict is not Verdict.NONE or not rows_of_cells or len(case.chain.links) > 1:
        return []
    # of weights only what needs stamps is untested
    records = (
        BenchRecord(
            log.channels[0], log.known["load_n"][:, 0], log.readings[:, 0], log.time_s, log.block,
            log.known.get("temperature_degc"), timed=not read.untested,
        )
        for log in case.logs
    )  # fmt: skip
    return [
        study for record in records
        if promising(record) and _surely(study := study_rows(record), len(case.logs))
    ]  # fmt: skip


def _surely(study: ChannelStudy, cells: int) -> bool:
    """Whether a cell's own model is beyond chance among all cells, and worth a tenth of its error.

    Of eight straight cells one in twelve needs more at the level of `offline-fit`.
    """
    if study.ladder is None:
        return False
    climbed = [row for row in study.ladder.rows if row.climbed and row.model != "affine"]
    before, after = study.ladder.rows[0].held_out_rmse_n, study.ladder.held_out.rmse
    sure = any(row.p_value < _LEVEL / cells for row in climbed)
    return sure and after < _WORTH * before
