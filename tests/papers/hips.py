"""The hip paper on the samples' hexapod: offsets of Table II, 543 poses, a slow tripod walk.

``sample_data/hexapod`` comes from a physics engine; hanging, standing and walking are calibrated
by the commands, each method of the paper beside footcal's own.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from footcal_cli.core.simulation.robots import TABLE_II_LEG_WEIGHTS_N, TABLE_II_OFFSETS
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord, RmseRecord, RunRecord
from tests.papers.commands import run

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[2]
RECIPE = ROOT / "recipes" / "hexapod.toml"
SAMPLES = ROOT / "sample_data" / "hexapod"
LEGS = ("hl", "ml", "fl", "hr", "mr", "fr")
AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
HANGING = ("joint", "stepwise", "naive")


@dataclass(frozen=True)
class Hung:
    """One method's answer to the hanging logs.

    Parameters
    ----------
    offset, offset_sd
        Shape (6 legs, 6), N and Nm; sd NaN where the method gives none.
    weight, weight_sd
        Shape (6,), N.
    force_sd_n, torque_sd_nm
        Residual per axis, of the worst leg.
    """

    offset: Array
    offset_sd: Array
    weight: Array
    weight_sd: Array
    force_sd_n: float
    torque_sd_nm: float


def truth() -> tuple[Array, Array]:
    """Offsets (6, 6) and leg weights (6,) that are in the samples: Table II."""
    return (
        np.array([TABLE_II_OFFSETS[leg] for leg in LEGS]),
        np.array([TABLE_II_LEG_WEIGHTS_N[leg] for leg in LEGS]),
    )


def hung(out: Path, method: str) -> tuple[Hung, Path]:
    """`hang-calib` by one of the methods."""
    folder = run("hang-calib", "--recipe", RECIPE, "--method", method, out=out / f"hang_{method}")
    path = folder / "parameters.json"
    path = path if path.exists() else folder / "parameters_rejected.json"
    known = read_record(ParametersRecord, path).parameters

    def value(name: str) -> tuple[float, float]:
        one = known[name]
        return one.value, float("nan") if one.sd is None else one.sd

    offset = np.array([[value(f"{leg}.offset_{axis}") for axis in AXES] for leg in LEGS])
    weight = np.array([value(f"{leg}.weight") for leg in LEGS])
    rows = [r for r in read_record(RmseRecord, folder / "rmse.json").rows if r.stage == "after"]
    worst = [max(r.rmse for r in rows if r.quantity.endswith(kind)) for kind in ("force", "torque")]
    return Hung(offset[..., 0], offset[..., 1], weight[:, 0], weight[:, 1], *worst), folder


@dataclass(frozen=True)
class Stood:
    """Standing poses: balance by stage, and the candidate models.

    Parameters
    ----------
    rmse
        (stage, quantity) -> RMSE on all poses, N and Nm.
    models
        Rows of ``models.parquet``.
    rejected
        Reason -> count of the still log that was cut into poses.
    left_out
        What the command says about the stretches it left out.
    """

    rmse: dict[tuple[str, str], float]
    models: pd.DataFrame
    rejected: dict[str, int]
    left_out: tuple[str, ...]


def stood(out: Path, hanging: Path) -> tuple[Stood, dict[str, Path]]:
    """`pose-calib` on 543 poses, on a log to cut poses from, and as printed; `apply` to a walk."""
    start = ("--recipe", RECIPE, "--parameters", hanging / "parameters.json")
    folders = {
        "pose": run("pose-calib", *start, out=out / "pose"),
        "printed": run("pose-calib", *start, "--method", "alternating", "--balance", "printed",
                       out=out / "pose_printed"),
        "still": run("pose-calib", SAMPLES / "still.parquet", *start, out=out / "pose_still"),
    }  # fmt: skip
    calibrated = folders["pose"] / "parameters.json"
    folders["walk"] = run("apply", SAMPLES / "walk.parquet", "--recipe", RECIPE, "--parameters",
                          calibrated, out=out / "tripod_walk")  # fmt: skip
    folders["offsets"] = run("pose-calib", SAMPLES / "tripod.parquet", "--recipe", RECIPE,
                             "--parameters", calibrated, "--fit", "offsets",
                             out=out / "pose_offsets")  # fmt: skip
    rmse = {}
    for name in ("pose", "printed"):
        for row in read_record(RmseRecord, folders[name] / "rmse.json").rows:
            if row.split == "all":
                stage = row.stage if name == "pose" else f"printed {row.stage}"
                rmse[stage, row.quantity] = row.rmse
    still = read_record(RunRecord, folders["still"] / "run.json")
    told = tuple(f.sentence for f in still.findings if f.code == "poses_left_out")
    rejected = read_record(RmseRecord, folders["still"] / "rmse.json").rejected
    models = pd.read_parquet(folders["pose"] / "models.parquet")
    return Stood(rmse, models, dict(rejected), told), folders


def walking_error(folder: Path) -> dict[str, tuple[float, float]]:
    """RMS error of the foot wrenches of the tripod walk against the engine's own, feet down.

    The frames differ by the heading: the size of the horizontal force and the vertical force are
    what both share.

    Returns
    -------
    ``tared`` and ``calibrated`` -> RMS error of both, N.
    """
    found = pd.read_parquet(folder / "calibrated.parquet").sort_values(["time_s", "leg"])
    engine = pd.read_parquet(SAMPLES / "walk.parquet").sort_values(["time_s", "leg"])
    down = engine["contact"].to_numpy() == 1
    errors: dict[str, tuple[float, float]] = {}
    for name, prefix in (("tared", "tared_"), ("calibrated", "")):
        ours = found[[f"{prefix}{a}_w_n" for a in ("fx", "fy", "fz")]].to_numpy(dtype=float)
        true = engine[[f"ground_{a}_w_n" for a in ("fx", "fy", "fz")]].to_numpy(dtype=float)
        size = np.linalg.norm(ours[:, :2], axis=1) - np.linalg.norm(true[:, :2], axis=1)
        rise = ours[:, 2] - true[:, 2]
        level, upright = (float(np.sqrt(np.mean(e[down] ** 2))) for e in (size, rise))
        errors[name] = (level, upright)
    return errors
