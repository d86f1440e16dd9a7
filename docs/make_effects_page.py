"""Generate `docs/effects.md` and its figures from the table of effects: `make effects-page`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from footcal_cli.core.chain import Chain
from footcal_cli.core.effects import TABLE
from footcal_cli.core.effects.contract import Effect, EffectParameter, Stage, units_of
from footcal_cli.core.log import Log
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.simulation.bench_logs import (
    PlacementsPlan,
    WeightsPlan,
    placements_log,
    weights_logs,
)
from footcal_cli.core.simulation.biped_logs import Course, Streams, biped_logs
from footcal_cli.core.simulation.gait import WalkPlan, walking
from footcal_cli.core.simulation.hexapod_logs import (
    HangPlan,
    PosePlan,
    simulated_hang_log,
    simulated_pose_log,
)
from footcal_cli.core.simulation.noise import QUIET
from footcal_cli.core.simulation.robots import Biped, Hexapod
from footcal_cli.plots.style import AFTER, BEFORE, REFERENCE, new_figure, tidy

HERE = Path(__file__).resolve().parent
#: The experiment in which an effect shows best, where that is not the first of its list.
SHOWN_IN = {
    "crosstalk": "walk", "hysteresis": "weights", "creep": "weights", "mass": "walk",
    "com_offset": "walk", "cell_position": "walk", "slip": "walk", "load_bypass": "walk",
    "leg_weight": "hang", "scale_matrix": "pose", "cross_coupling": "pose",
    "mount_rotation": "pose", "channel_swap": "walk", "channel_duplicate": "walk",
    "channel_stuck": "walk", "bias_jump": "walk", "sign_flip": "walk",
}  # fmt: skip
SHAPES = {
    "jump_time": 4.0, "change_time": 300.0, "slip_time": 4.0, "stuck_time": 5.0, "unit_block": 1.0,
    "label": 10.0, "creep_slow_time": 300.0,
}  # fmt: skip
STAGES = {
    Stage.BENCH: "Bench: what was written down",
    Stage.BODY: "Body: masses, CoM, inertial unit",
    Stage.FOOT: "Foot: between the ground and the cells",
    Stage.SIX_AXIS: "Six-axis transducers",
    Stage.CELL: "Load cells",
    Stage.CALIBRATION: "Calibration",
    Stage.DIGITAL: "Digital: channels mixed up or dead",
    Stage.TRANSPORT: "Transport: clocks and telemetry",
}
LARGER = 3.0
"""How many usual sizes are drawn, so that the eye sees them."""
UNITS = {
    "load_n": "N", "hole_m": "m", "com_m": "m", "com_acc_mps2": "m/s²", "angmom_rate_nm": "Nm",
    "mass_kg": "kg", "cell_pos_m": "m", "leg_weight_n": "N", "leg_com_m": "m", "gravity_dir": "-",
    "robot_weight_n": "N", "rot_wb": "-", "foot_yaw_rad": "rad",
}  # fmt: skip


@dataclass(frozen=True)
class Signature:
    """What an effect changes most in a recording.

    Parameters
    ----------
    quantity, unit
        What is drawn.
    time_s, clean, distorted
        Shape (n,).
    sizes
        The values it was drawn with, in words.
    """

    quantity: str
    unit: str
    time_s: FloatArray
    clean: FloatArray
    distorted: FloatArray
    sizes: str


def drawn_sizes(effect: Effect, shapes: dict[str, float]) -> dict[str, float]:
    """Three usual sizes of the first parameter (a whole fault whole), the given shapes."""
    size = effect.size
    whole = (size.lower, size.neutral, size.upper) == (0.0, 0.0, 1.0)
    large = 1.0 if whole else size.neutral + LARGER * size.prior_sd
    values = {size.name: float(np.clip(large, 0.9 * size.lower, 0.9 * size.upper + 0.1 * whole))}
    return values | {p.name: shapes.get(p.name, p.neutral) for p in effect.shapes}


def signature(effect: Effect, clean: Log, values: dict[str, float]) -> Signature:
    """Apply an effect and find the quantity that it changes most, relative to its range."""
    units = len(units_of(effect.scope, clean.channels))
    theta = {p.name: np.full(units, values.get(p.name, p.neutral)) for p in effect.parameters}
    distorted, _ = effect.apply(clean, theta, None)
    columns: list[tuple[float, str, str, FloatArray, FloatArray]] = []
    for i, channel in enumerate(clean.channels):
        unit = "Nm" if ".t" in channel else "N"
        columns.append(_column(channel, unit, clean.readings[:, i], distorted.readings[:, i]))
    for name, unit in UNITS.items():
        if name in clean.known:
            before = clean.known[name].reshape(len(clean), -1)
            after = distorted.known[name].reshape(len(clean), -1)
            for k in range(before.shape[1]):
                columns.append(_column(name, unit, before[:, k], after[:, k]))
    _, quantity, unit, before, after = max(columns, key=lambda column: column[0])
    said = ", ".join(
        f"{name} = {value:g} {next(p.unit for p in effect.parameters if p.name == name)}"
        for name, value in values.items()
    )
    return Signature(quantity, unit, clean.time_s, before, after, said.replace(" -", ""))


def _column(
    name: str, unit: str, before: FloatArray, after: FloatArray
) -> tuple[float, str, str, FloatArray, FloatArray]:
    change = float(np.sqrt(np.mean((after - before) ** 2)))
    spread = max(float(np.std(before)), 1e-3 * float(np.abs(before).max()))
    return change / (spread or 1.0), name, unit, before, after


def plot_signature(found: Signature) -> Figure:
    """Clean and distorted over time; their difference against the clean value."""
    figure = new_figure(2.3)
    left, right = figure.subplots(1, 2, width_ratios=[1.7, 1.0])
    dots = len(found.time_s) < 150
    style = {"marker": "o", "linestyle": "", "markersize": 3} if dots else {"linewidth": 1.1}
    left.plot(found.time_s, found.clean, color=BEFORE, label="clean", **style)
    left.plot(found.time_s, found.distorted, color=AFTER, label="distorted", **style)
    tidy(left, "", "time (s)", f"{found.quantity} ({found.unit})")
    left.legend(fontsize=8, frameon=False, loc="upper right")
    difference = found.distorted - found.clean
    right.axhline(0.0, color=REFERENCE, linewidth=0.7)
    right.plot(found.clean, difference, ".", color=AFTER, markersize=2.5)
    tidy(right, "", f"clean {found.quantity} ({found.unit})", "distorted − clean")
    return figure


def clean_logs() -> dict[str, Log]:
    """One short recording of each experiment, without noise or effects."""
    biped, hexapod, nothing = Biped(), Hexapod(), Chain(())
    quiet = Streams(cell_noise=QUIET)
    walk = WalkPlan(duration_s=9.0, speed_mps=0.08, stand_s=1.5)
    stairs = WeightsPlan(sessions=2, noise=QUIET)
    walked = biped_logs(
        Course("walk", biped, lambda t: walking(biped, walk, t), walk.duration_s), nothing, {},
        seed=1, streams=quiet, to_counts=False,
    )  # fmt: skip
    holes = PlacementsPlan(loads_n=(20.0,), repeats=3, noise=QUIET)
    hang = HangPlan(cycles=2, rate_hz=5.0, force_noise=QUIET, torque_noise=QUIET)
    pose = PosePlan(poses=100, force_noise=QUIET, torque_noise=QUIET)
    weighed = weights_logs(biped, stairs, nothing, {}, seed=1, to_counts=False)
    placed = placements_log(biped, "left", holes, nothing, {}, seed=1, to_counts=False)
    return {
        "walk": walked.cells.truth,
        "weights": weighed["left_fl"].truth,
        "placements": placed.truth,
        "hang": simulated_hang_log(hexapod, "ml", hang, nothing, {}, seed=1).truth,
        "pose": simulated_pose_log(hexapod, pose, nothing, {}, seed=1).truth,
    }


def usual(p: EffectParameter) -> str:
    """Usual size of a parameter, or the values at which a shape is tried."""
    return f"shape: {p.tried}" if p.shape else f"{p.prior_sd:g}"


def section(effect: Effect, experiment: str, sizes: str, quantity: str) -> str:
    """One effect's part of the page."""
    rows = "\n".join(
        f"| `{p.name}` | {p.unit} | {p.neutral:g} | {p.lower:g} … {p.upper:g} | "
        + (f"shape, tried at {p.tried}" if p.shape else f"{p.prior_sd:g}")
        + " |"
        for p in effect.parameters
    )
    inverse = (
        f"exact to {effect.tolerance:g} (relative)" if effect.invertible
        else "none exists; removing it is a best guess"
    )  # fmt: skip
    return f"""### {effect.name}

{effect.formula}

![{effect.name}](figures/effects/{effect.name}.png)

*{quantity} in a simulated {experiment} log, {sizes}.*

| parameter | unit | neutral | bounds | usual size |
|---|---|---|---|---|
{rows}

- One value per {effect.scope.value}; seen by {", ".join(effect.experiments)}.
- Looks like {", ".join(f"[{name}](#{name})" for name in effect.mimics)}; distinguished by
  {effect.separates}.
- What to do: {effect.remedy}.
- Inverse: {inverse}. Source: {effect.source}.
"""


def main() -> None:
    """Write the page and its figures."""
    figures = HERE / "figures" / "effects"
    figures.mkdir(parents=True, exist_ok=True)
    logs = clean_logs()
    parts = [
        "# Effects\n",
        "The effects that footcal knows: how a sensor, a mount, a clock, an inertial unit or a "
        "foot distorts a log, in the order in which the truth passes through them. `simulate` puts "
        "them in, the calibrations fit some of them, `diagnose` looks for the others. Figures show "
        "three times the usual size of the first parameter.\n",
        "This page is generated by `make effects-page` from `footcal_cli/core/effects`.\n",
    ]
    stage = None
    for effect in TABLE.values():
        if effect.stage is not stage:
            stage = effect.stage
            parts.append(f"## {STAGES[stage]}\n")
        experiment = SHOWN_IN.get(effect.name, effect.experiments[0])
        log = logs["walk" if experiment == "stand" else experiment]
        if effect.name == "scale_bias":
            values = {"scale": 1.1, "bias": 0.5}
        elif effect.name == "temperature_bias":
            log = log.with_known(temperature_degc=25.0 + 10.0 * (1 - np.exp(-log.time_s / 300.0)))
            values = drawn_sizes(effect, SHAPES)
        else:
            values = drawn_sizes(effect, SHAPES)
        found = signature(effect, log, values)
        plot_signature(found).savefig(
            figures / f"{effect.name}.png", dpi=80, metadata={"Software": None}
        )
        parts.append(section(effect, experiment, found.sizes, found.quantity))
    (HERE / "effects.md").write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
