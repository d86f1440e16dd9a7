"""What a log holds that fits no experiment, and what of an experiment it lacks.

Room: sniff; asked by init, once nothing else was found.
"""

from __future__ import annotations

from footcal_cli.sniff.guesses import ColumnGuess, FileGuess
from footcal_cli.sniff.loads import loads_and_cells
from footcal_cli.sniff.motion import without_motion
from footcal_cli.sniff.numbered import numbered

_POSES = ("quaternion", "angle", "matrix", "gravity", "hole", "foot_position", "com",
          "position")  # fmt: skip
_MOST = 8
"""So many columns are named in a refusal."""


def unfit(file: FileGuess) -> tuple[str, str]:
    """What is wrong with a log that fits no experiment, and what to do."""
    numbers = [c for c in file.columns if c.values is not None]
    if file.rows == 1:
        return (
            f"one row, with {len(numbers)} numbers: a calibration compares several readings",
            "write each reading in a row of its own, next to the load that lay on the sensor "
            "(load_kg,counts), one of them without a load; settings and results are no log",
        )
    loads, cells = loads_and_cells(file)
    loads = loads or [c for c in file.of("load", "force") if c.values is not None]
    if loads and not cells:
        return (
            f"a load ({_names(loads)}) and no reading next to it: nothing to compare it with",
            "log what the sensor itself gave, in counts or volts, in a column next to it; if "
            f"{loads[0].column} is what the sensor gave, add the known loads (load_kg)",
        )
    file = without_motion(numbered(file))
    posed = file.of(*_POSES)
    if posed and not file.of("reading", "force", "unknown"):
        return (
            f"positions and attitudes alone ({_names(posed)}), no force",
            "log what the sensor gave in the same rows: fx … tz of a transducer, or readings of "
            "cells; an attitude and forces together go to hang-calib",
        )
    return (
        f"its columns fit no experiment that footcal knows: {_names(file.columns)}",
        "name readings and known loads, feet or an attitude in the header",
    )


def _names(columns: list[ColumnGuess] | tuple[ColumnGuess, ...]) -> str:
    return ", ".join(c.column for c in columns[:_MOST])
