"""``docs/papers.md``: the systems row by row, then every table and figure."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.papers import deviations, hips, printed
from tests.papers.bench import Table2Row, Table3
from tests.papers.formats import picture, shown, table
from tests.papers.hips import AXES, LEGS, Hung, Stood
from tests.papers.systems import Found, systems
from tests.papers.walk_tables import open_points, sensitivity, walk_figures, walking_tables


def copy_pictures(folders: Mapping[str, Path], walks: Path, to: Path) -> None:
    """Figures of the run folders and of the walks, under the names that the page uses."""
    to.mkdir(parents=True, exist_ok=True)
    for name, source in (
        ("cop_holes", folders["bench"] / "figures/cop_errors_left.png"),
        ("total_force", folders["bench"] / "figures/total_force_left.png"),
        ("hanging_com", folders["joint"] / "figures/leg_com.png"),
        ("hanging_residuals", folders["joint"] / "figures/residuals.png"),
        ("balance", folders["pose"] / "figures/balance.png"),
        ("tripods", folders["walk"] / "figures/foot_wrenches_by_phase.png"),
    ):
        shutil.copyfile(source, to / f"{name}.png")
    for source in sorted(walks.glob("walk_*.png")):
        shutil.copyfile(source, to / source.name)


def page(found: Found) -> str:
    """The whole page."""
    parts = [
        _HEAD,
        "## The systems, row by row",
        table(("", "system", "printed", "footcal", "same data?", "deviation"), systems(found)),
        "## Foot sensors\n\n### Table 2: coefficients of the eight cells",
        "The paper's own readings; coefficients in its kilograms, and in newtons.",
        table(
            ("cell", "c printed (kg/count)", "c", "d printed (kg)", "d", "c (N/count)", "d (N)",
             "residual (kg)"),
            [_cell(row) for row in found.table_2],
        ),
        "Residuals of 8 to 26 g, 0.9 g in `left_fl`, with a smallest weight of 10 g: the printed "
        "readings do not lie on straight lines.",
        "### Table 3, Figs. 7 and 8: offline calibration",
        _offline(found.table_3),
        picture("cop_holes", "Fig. 7: from each hole to the CoP read there, before and after"),
        picture("total_force", "Fig. 8: total force against the known load"),
        "### Tables 4–6: walking",
        walking_tables(found.walks),
        *walk_figures(),
        "### Open points of the paper",
        open_points(found.walks),
        "### Sensitivity to the weights (section 3.3.2)",
        sensitivity(found.walks),
        *(["### Failure modes (section 5.1)", _MODES_HEAD,
           table(("mode", "in the log", "verdict", "sentence of `diagnose`"), found.modes),
           _MODES_FOOT]
          if found.modes else []),
        "### Equations that are not as printed",
        table(_EQUATIONS, deviations.FOOT),
        "## Transducers at the hips\n\n### Table II: offsets and leg weights",
        _hanging(found.hung),
        picture("hanging_com", "Figs. 4 and 7: leg CoM over the shaft angle; dots: medians over "
                 "ten cycles, dark: quartiles, light: 95 % of the cycles, dashed: the series"),
        picture("hanging_residuals", "Fig. 5: residuals of the hanging logs, without (grey) and "
                 "with tilt (blue)"),
        "### Which poses count (section I-B)",
        _still(found.stood),
        "### Figs. 2 and 6: sum of all foot wrenches",
        _balance(found.stood),
        picture("balance", "Figs. 2 and 6: ground wrenches of all feet minus the weight, floating "
                 "base, about the robot's CoM"),
        "### Table I: which mounting errors are there",
        _models(found.stood),
        "### Figs. 8 and 9: tripod walk",
        _tripods(found.walking),
        picture("tripods", "Figs. 8 and 9: foot wrenches of both tripods over the shaft angle"),
        "### Equations that are not as printed",
        table(_EQUATIONS, deviations.HIPS),
    ]  # fmt: skip
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _cell(row: Table2Row) -> list[str]:
    return [
        row.cell, f"{row.printed[0]:.8e}", f"{row.fitted[0]:.8e}", f"{row.printed[1]:.7f}",
        f"{row.fitted[1]:.7f}", f"{row.newtons[0]:.6e}", f"{row.newtons[1]:.4f}",
        f"{row.residual_kg:.4f}",
    ]  # fmt: skip


def _offline(found: Table3) -> str:
    cop, force = printed.TABLE_3["CoP"], printed.TABLE_3["vGRF"]
    rows = [
        (
            "CoP (mm)",
            shown(1e3 * cop[0]),
            shown(1e3 * cop[1]),
            *(shown(1e3 * x) for x in found.cop_m),
        ),
        ("vGRF (N)", shown(force[0]), shown(force[1]), *(shown(x) for x in found.vgrf_n)),
    ]
    main = table(
        ("RMSE", "printed, initial", "printed, after", "before", "after, fitted placements",
         "after, placements never used"),
        rows,
    )  # fmt: skip
    return (
        f"{main}\n\nA simulated foot (`sample_data/bench_foot`: crosstalk, misplaced cells, 18 "
        "holes, six repeats, 4.9 to 59 N). The paper's own correction, eqs. (3)–(5), leaves "
        f"{shown(1e3 * found.printed_model_cop_m)} mm at placements never used; the model that the "
        "evidence chooses is physical (cell positions, crosstalk and biases)."
    )


def _hanging(hung: Mapping[str, Hung]) -> str:
    offset, weight = hips.truth()
    joint = hung["joint"]
    rows = []
    for i, leg in enumerate(LEGS):
        force, torque, weight_sd = printed.TABLE_II_SD[leg]
        sd = (*force, *torque)
        rows.append(
            [
                leg.upper(),
                *(
                    f"{offset[i, a]:g} ± {sd[a]:g} / {joint.offset[i, a]:.4f} ± "
                    f"{joint.offset_sd[i, a]:.4f}"
                    for a in range(6)
                ),
                f"{weight[i]:g} ± {weight_sd:g} / {joint.weight[i]:.4f} ± {joint.weight_sd[i]:.4f}",
            ]
        )
    main = table(
        ("leg", *(f"{axis} ({'N' if axis[0] == 'f' else 'Nm'})" for axis in AXES), "m g (N)"), rows
    )
    errors = []
    for name, one in hung.items():
        wrong = one.offset - offset
        z = wrong / one.offset_sd
        known = np.isfinite(z)
        errors.append(
            (
                name,
                shown(1e3 * float(np.sqrt(np.mean(wrong[:, :3] ** 2))), 2),
                shown(1e3 * float(np.sqrt(np.mean(wrong[:, 3:] ** 2))), 2),
                shown(1e3 * float(np.sqrt(np.mean((one.weight - weight) ** 2))), 2),
                f"{shown(one.force_sd_n, 2)} N, {shown(1e3 * one.torque_sd_nm, 2)} mNm",
                f"{np.sqrt(np.mean(z[known] ** 2)):.2f}" if known.any() else "no intervals",
            )
        )
    compared = table(
        ("method", "force offsets (mN)", "torque offsets (mNm)", "leg weight (mN)",
         "residual, worst leg", "RMS of error / sd"),
        errors,
    )  # fmt: skip
    return (
        "Printed / footcal. The printed offsets and weights are in the simulated robot, so each is "
        f"the truth of its neighbour (`hang-calib`, joint fit).\n\n{main}\n\nErrors (RMS over legs "
        f"and axes) of the paper's methods on the same logs:\n\n{compared}\n\nThe paper's residual "
        f"after calibration is at most {printed.HANGING_SD_N} N sd."
    )


def _still(stood: Stood) -> str:
    counts = ", ".join(f"{count} × {reason}" for reason, count in stood.rejected.items())
    told = "; ".join(stood.left_out) or "no quiet stretch was left out"
    return (
        "The rule of the paper (force derivative below 1 N/s for more than 1.5 s, median of the "
        f"rest) cuts `sample_data/hexapod/still.parquet` into poses: {counts}. The report names "
        f"them: {told}. The paper kept 635 of 729 poses, and {printed.POSES} with all markers seen."
    )


def _balance(stood: Stood) -> str:
    rows = []
    for stage, label in (
        ("before", "tare in the air, nominal mounting"),
        ("offsets only", "offsets and leg weights from hanging, nominal mounting"),
        ("printed after", "alternating scheme, balance as printed"),
        ("after", "joint fit, exact balance"),
    ):
        rows.append(
            (label, shown(stood.rmse[stage, "sum of forces"], 2),
             shown(stood.rmse[stage, "sum of moments"], 2))
        )  # fmt: skip
    return (
        table(("stage", "force (N per axis)", "moment (Nm per axis)"), rows)
        + f"\n\nRMS over 543 poses. The paper: {printed.NAIVE_FORCE_SD_N:g} N sd of planar force "
        f"with a tare, and a moment bias of {printed.TORQUE_BIAS_NM} Nm that calibration removes; "
        "no table."
    )


def _models(stood: Stood) -> str:
    rows = []
    for row in stood.models.to_dict("records"):
        told = printed.TABLE_I.get(row["model"])
        rows.append(
            (
                row["model"].replace("_", " "), str(row["freedom"]),
                *(("–", "–") if told is None else (f"{told[1]:g}", f"{told[2]:g}")),
                shown(row["cv_error"]), f"{row['bic_paper']:.0f}", shown(row["cv_chi2"]),
            )
        )  # fmt: skip
    return (
        table(
            ("free", "DOF", "CV error printed", "BIC printed", "CV error", "BIC, same formula",
             "CV error in units of the noise (6 if all is explained)"),
            rows,
        )
        + "\n\n543 poses, five folds, the paper's norm. The models come in the paper's order, at "
        "another level: the simulated transducers have 0.02 to 0.05 N of noise and nothing but "
        "mounting errors, BigAnt's cases respond to strain by newtons. *Hip rotations* (about the "
        "transducer, not the body's origin) is not among the paper's."
    )  # fmt: skip


def _tripods(walking: Mapping[str, tuple[float, float]]) -> str:
    rows = [(name, shown(level, 2), shown(rise, 2)) for name, (level, rise) in walking.items()]
    return (
        table(("", "horizontal force (N)", "vertical force (N)"), rows)
        + "\n\nRMS error of the force of each foot on the ground, against the force in the physics "
        "engine (`sample_data/hexapod/walk.parquet`: a quasi-static walk that turns right). The "
        "paper has no second measurement."
    )


_MODES_HEAD = """
What violates the assumptions of the paper's model: effects that `simulate --effect` puts into a log
and `diagnose` looks for. One planned walk of a minute each, nameplate calibration.
"""

_MODES_FOOT = """
Low vertical force is no effect: below ε (`min_force_n`) every CoP is absent and nothing is learnt
from it. Slip alone hardly changes the balance of forces and moments: nothing to find, no harm.
Creep of 5 % is taken up by the biases within a minute. A tilted IMU, accelerometer bias, floor
slope and CoM offset look alike in a straight walk. What is missed: the load bypass, which touches
at 20 N, comes out low and with two names that cancel each other (a lag of all cells and a delay of
the same size) and are not in the log; impacts on a clipping IMU have no effect of their own and
are flagged without a name.
"""

_EQUATIONS = ("equation", "printed", "here", "why")

_HEAD = """
# The two source papers, table by table

Made by `make papers` (`tests/papers`): footcal's own functions on robots with the papers' settings.
The papers publish no logs except Table 2 of the foot paper, so most rows are on simulated robots:
compare orders and ratios, not levels. *NAO CoP self-calibration* is the foot paper, *Wu & Revzen*
the hip paper; both are in `CITATION.cff`.
"""
