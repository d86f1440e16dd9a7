"""The systems of both papers, row by row: printed, footcal, same data?, deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.papers import hips, printed
from tests.papers.bench import Table2Row, Table3
from tests.papers.formats import Rows, shown
from tests.papers.hips import Hung, Stood
from tests.papers.walk_tables import chosen, compared, error_of, milliseconds
from tests.papers.walks import BODIES, SPEEDS_MPS


@dataclass(frozen=True)
class Found:
    """Everything that the page tells.

    Parameters
    ----------
    walks
        One summary per walk (`tests.papers.walks.summary_of`).
    hung
        Hanging method -> its answer.
    walking
        Errors of the tripod walk (`tests.papers.hips.walking_error`).
    modes
        Rows of the table of failure modes.
    """

    table_2: Sequence[Table2Row]
    table_3: Table3
    walks: Sequence[Mapping[str, Any]]
    hung: Mapping[str, Hung]
    stood: Stood
    walking: Mapping[str, tuple[float, float]]
    modes: Rows = ()


def systems(found: Found) -> Rows:
    """One row per system."""
    walks, bench = found.walks, found.table_3
    joint, stepwise = found.hung["joint"], found.hung["stepwise"]
    stood, models = found.stood.rmse, found.stood.models.set_index("model")["cv_error"].to_dict()
    first = str(found.stood.models["model"].iloc[0])
    exact, off = (
        [compared(chosen(walks, body, speed), "window", "static", "cop_m") for speed in SPEEDS_MPS]
        for body in BODIES
    )
    memory = [compared(chosen(walks, body), "memory", "window", "cop_m") for body in BODIES]
    told = [printed.TABLES_4_TO_6[speed] for speed in SPEEDS_MPS]
    ours = [
        float(np.mean([error_of(w, "window", "baseline", "cop_m")
                       for w in chosen(walks, next(iter(BODIES)), speed)]))
        for speed in SPEEDS_MPS
    ]  # fmt: skip
    return [
        ("1", "Foot: counts to newtons, eqs. (1), (2)", "c and d of 8 cells", "same to 8 digits",
         "yes, Table 2", "none; in N besides kg"),
        ("2", "Foot: CoP over holes, eqs. (3)–(5)", "183.9 → 0.5 mm",
         f"{shown(1e3 * bench.cop_m[0])} → {shown(1e3 * bench.cop_m[2], 2)} mm, placements never "
         "used", "no, simulated foot", "a physical model where the evidence asks for it"),
        ("3", "Foot: total force, Fig. 8", "5.30 → 0.08 N",
         f"{shown(bench.vgrf_n[0])} → {shown(bench.vgrf_n[2], 2)} N", "no, simulated foot", "none"),
        ("4", "Foot: model of motion, eqs. (6)–(11)", "equations", "equations", "–",
         "none; tested against an engine's forces"),
        ("5", "Foot: static start, eqs. (12), (13)", "no numbers", "rank and weakest directions",
         "no", "maximum a posteriori, means per stance ([static-init](howto/static-init.md))"),
        ("6", "Foot: window, eq. (14), CoP at 0.02, 0.04, 0.1 m/s",
         _list([1e3 * row["window"][0] for row in told]) + " mm",
         _list([1e3 * x for x in ours]) + " mm", "no, an engine's walks",
         "unknowns centred, in prior sd"),
        ("7", "Foot: window / static assumption, CoP",
         _list([row["window"][0] / row["static"][0] for row in told]),
         f"{_list([x.ratio for x in exact])}; body model 2 mm off: "
         f"{_list([x.ratio for x in off])}", "no, an engine's walks", "each at its own ω_S"),
        ("8", "Foot: streams and validity (80 and 100 Hz, 20 ms, 10 Hz, 5 N)", "settings",
         "the same, as defaults", "–", "below ε the CoP is absent, not held"),
        ("9", "Foot: weights × 0.2 … 5; time per update", "smooth; 2.5 ms",
         f"tables below; {shown(milliseconds(walks, 'numpy'), 2)} ms in NumPy", "no", "none"),
        ("10", "Foot: convergence, drift, repeatability, significance", "left open",
         f"tables below; CoP of memory / window {memory[0].ratio:.2f}, body model 2 mm off "
         f"{memory[1].ratio:.2f}", "no", "an estimator with memory is added"),
        ("11", "Hips: hanging, eqs. (4)–(7), Table II", "residual ≤ 0.2 N sd",
         f"{shown(joint.force_sd_n, 2)} N; force offsets err by {_offset_mn(joint)} mN (stepwise "
         f"{_offset_mn(stepwise)})", "no, its offsets in a simulated robot",
         "joint likelihood by default; stepwise kept"),
        ("12", "Hips: naive taring, Fig. 2", "5 N sd in the plane, −5 to 20 N",
         f"{shown(stood['before', 'sum of forces'], 2)} N RMS per axis", "no, simulated robot",
         "none"),
        ("13", "Hips: mounting from poses, eqs. (8), (9), Fig. 6", "2.5 Nm of bias removed",
         f"{shown(stood['before', 'sum of moments'], 2)} → "
         f"{shown(stood['after', 'sum of moments'], 2)} Nm RMS", "no, simulated robot",
         "balance of the chassis; as printed with `--balance printed`"),
        ("14", "Hips: model selection, Table I", "full model; CV 105 → 12",
         f"{first} model; CV {shown(models['single'], 2)} → {shown(models['full'], 2)}",
         "no, simulated robot", "a fifth model; BIC in both countings"),
        ("15", "Hips: tripod walk, Figs. 8, 9; offsets again", "figures",
         f"vertical force of each foot to {shown(found.walking['calibrated'][1], 2)} N (tared "
         f"{shown(found.walking['tared'][1], 2)} N)", "no, an engine's walk",
         "offsets again need lifted legs ([pose-calib](howto/pose-calib.md))"),
    ]  # fmt: skip


def _list(values: Sequence[float]) -> str:
    return ", ".join(shown(x, 2) for x in values)


def _offset_mn(one: Hung) -> str:
    """RMS error of the force offsets."""
    wrong = (one.offset - hips.truth()[0])[:, :3]
    return shown(1e3 * float(np.sqrt(np.mean(wrong**2))), 2)
