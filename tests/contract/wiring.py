"""What the commands look for before they diagnose: cells or axes exchanged or turned."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.effects.calibration import AXES
from footcal_cli.core.experiments import walk
from footcal_cli.core.hang.joint import HangOptions, fit_hang
from footcal_cli.core.inference.case import Case
from footcal_cli.core.log import Log
from footcal_cli.core.pose.data import pose_data
from footcal_cli.core.pose.problem import PoseOptions
from footcal_cli.core.pose.turned import turned_when_hanging, turned_when_standing
from footcal_cli.core.quality import Finding
from footcal_cli.core.simulation.noise import FORCE_NOISE
from footcal_cli.core.wiring import check_exchanged_cells, check_exchanged_walking
from tests.contract.worlds import HEXAPOD
from tests.core.pose_cases import known_offsets


def wiring(case: Case) -> list[Finding]:
    """Findings on the wiring of a case."""
    kind, log = case.experiment.name, case.logs[0]
    if kind == "placements":
        found = []
        for log in case.logs:
            known = log.known
            found += check_exchanged_cells(
                log.readings, log.channels, known["cell_pos_m"][0], known["hole_m"], known["load_n"]
            )
        return found
    if kind in ("walk", "stand"):
        reference = walk.reference_of(log)
        rows = np.flatnonzero((np.nan_to_num(log.known["contact"]) != 0.0).any(axis=1))
        rows = rows[:: 8 if kind == "walk" else 1]
        arms = log.known["cell_pos_m"] - reference.cop_m[:, None]
        forces = case.chain.remove(log, case.values)[0].readings
        return check_exchanged_walking(
            forces[rows], log.channels, arms[rows], reference.fz_n[rows]
        )  # fmt: skip
    if kind == "hang":
        fits = [([log], HangOptions(), fit_hang([log])) for log in case.logs]
        turned = [turned_when_hanging(*fit) for fit in fits]
        return [each.finding() for each in turned if each is not None]
    if kind == "pose":
        return _turned_when_standing(log, case.values)
    return []


def _turned_when_standing(log: Log, values: Mapping[str, float]) -> list[Finding]:
    offset_sd, sd = (np.array([s] * 3 + [0.1 * s] * 3) for s in (1e-2, FORCE_NOISE.white))
    legs = tuple(
        known_offsets(
            np.array([values[f"{leg}.offset_{axis}"] for axis in AXES]), offset_sd,
            spec.weight_n, 1e-2,
        )
        for leg, spec in HEXAPOD.legs.items()
    )  # fmt: skip
    options = PoseOptions(com_sd_m=0.05, translation_sd_m=0.005)
    turned = turned_when_standing(pose_data(log), legs, np.tile(sd, (len(legs), 1)), options)
    return [turned.finding()] if turned else []
