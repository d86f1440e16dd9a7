"""What a refused log looks like, in one sentence, and three lines of what would be taken."""

from __future__ import annotations

from pathlib import Path

from footcal_cli.errors import FootcalError

_EXAMPLES = {
    "weights": ("channel,load_kg,counts", "left_fl,0,8300000", "left_fl,0.5,8155800"),
    "weights_stream": ("time_s,load_kg,cell_counts", "0.0,0,8300000", "0.1,0,8300012"),
    "weights_together": (
        "fl_counts,fr_counts,fl_load_n,fr_load_n", "8300000,8310000,0,0", "8200000,8311000,3.4,0",
    ),
    "cells": (
        "time_s,left_fl_counts,left_fr_counts,…", "0.00,8300000,8310000,…",
        "0.01,8300021,8310007,…",
    ),
    "body": (
        "time_s,com_x_m,com_y_m,com_z_m,…", "0.00,0.001,0.002,0.26,…", "0.01,0.001,0.002,0.26,…",
    ),
    "feet": (
        "time_s,left_fx_n,left_fy_n,left_fz_n,left_tx_nm,…", "0.00,1.2,-0.3,251.0,0.5,…",
        "0.01,1.1,-0.4,250.2,0.5,…",
    ),
    "hang": (
        "time_s,leg,orientation,fx_n,fy_n,fz_n,tx_nm,ty_nm,tz_nm",
        "0.00,wrist,+x,9.8,0.1,0.0,0.0,0.0,0.0", "0.01,wrist,+x,9.8,0.1,0.0,0.0,0.0,0.0",
    ),
    "placements": (
        "foot,placement,hole_x_mm,hole_y_mm,load_kg,fl_counts,fr_counts,…",
        "left,A1,20,10,5,8300000,8310000,…", "left,A2,40,10,5,8290000,8311000,…",
    ),
    "cop_points": ("placement,hole_x_m,hole_y_m,cop_x_m,cop_y_m", "P1,0.1,0.2,0.101,0.199",
                   "P2,0.1,0.3,0.102,0.301"),
}  # fmt: skip


def accepted(role: str) -> tuple[str, ...]:
    """Three lines of a log that is taken as it is."""
    return _EXAMPLES.get(role, _EXAMPLES["weights"])


def hint(path: Path) -> tuple[str, tuple[str, ...]] | None:
    """A sentence on what a log looks like, and what of that kind would be taken; None if nothing.

    Parameters
    ----------
    path
        The log that was refused.
    """
    from footcal_cli.sniff.columns import guess_file
    from footcal_cli.sniff.several import parts_of

    try:
        parts, _ = parts_of([guess_file(path)])
    except (FootcalError, OSError, ValueError):
        return None
    if not parts:
        return None
    plan = parts[0].plan
    said = f"this looks like {plan.kind}; run `footcal init {path}`"
    return said, accepted("feet" if plan.feet else plan.role)
