"""What a calibration already says of a log, so that no finding does; of the room of the session."""

from __future__ import annotations

from footcal_cli.core.quality import Finding
from footcal_cli.records.results import ParametersRecord


def unless_calibrated(found: list[Finding], known: ParametersRecord | None) -> list[Finding]:
    """Findings without cells whose readings fall under load as their calibration says they do."""
    if known is None:
        return found
    scales = {cell: scale for cell, (scale, _) in known.calibrated_cells.items()}

    def turns(name: str) -> bool:
        foot = name.rpartition("_")[0]
        mates = [v for key, v in scales.items() if key != name and key.rpartition("_")[0] == foot]
        return name in scales and bool(mates) and all(v * scales[name] < 0.0 for v in mates)

    return [f for f in found if not (f.code == "turned_sign" and turns(f.where))]
