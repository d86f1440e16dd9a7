"""Logs of one robot together, and weights that were typed while a scale was recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.several import parts_of

CELLS = ("L_FSR_FL", "L_FSR_FR", "L_FSR_RL", "L_FSR_RR", "R_FSR_FL", "R_FSR_FR", "R_FSR_RL",
         "R_FSR_RR")  # fmt: skip


def scale_log(path: Path, typed: list[tuple[float, str]]) -> Path:
    """A hold of 8 s at 10 Hz per weight, which is typed 1.2 s after it was put on."""
    rng = np.random.default_rng(5)
    rows = ["HX711 kitchen scale, channel A gain 128, 10 SPS", "millis,raw,note"]
    for k, (mass_g, note) in enumerate(typed):
        for i in range(80):
            settling = 4000 * np.exp(-i / 2) * rng.standard_normal() if i < 8 else 0.0
            raw = 84512 + 421.7 * mass_g + 25 * rng.standard_normal() + settling
            rows.append(f"{1000 + 100 * (80 * k + i)},{raw:.0f},{note if i == 12 else ''}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def test_weights_that_were_typed_while_a_scale_was_recorded(tmp_path: Path) -> None:
    up = [(0.0, "empty"), (100.0, "100g"), (500.0, "500g"), (2000.0, "2 kg"), (5000.0, "5 kg")]
    plan = plan_of(guess_file(scale_log(tmp_path / "a.csv", [*up, *up[-2::-1], *up[1:]])))
    assert plan is not None
    assert plan.ready
    assert set(plan.entries) == {"time_s", "raw_counts"}
    assert plan.options[0].startswith(
        'plateaus.loads = "0, 0.1, 0.5, 2, 5, 2, 0.5, 0.1, 0, 0.1, 0.5, 2, 5 kg"'
    )


def test_a_hold_without_its_weight_is_asked_for(tmp_path: Path) -> None:
    steps = [(0.0, "empty"), (500.0, ""), (2000.0, "2 kg"), (5000.0, "a cup")]
    plan = plan_of(guess_file(scale_log(tmp_path / "a.csv", steps)))
    assert plan is not None
    assert not plan.ready


def test_weights_a_walk_and_the_body_in_three_files(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    rows = [f"{cell},{load},{8_300_000 - 300 * load + rng.integers(-50, 50)},{run}"
            for run in range(2) for cell in CELLS for load in (0, 100, 200, 500, 1000)]  # fmt: skip
    (tmp_path / "weights.csv").write_text("\n".join(["Sensor,Mass (g),ADC,Run", *rows]) + "\n")
    counts = 8_300_000 - np.abs(rng.normal(0, 1e5, (400, 8))).astype(int)
    rows = [",".join([f"{12.5 * i:.1f}", *map(str, row)]) for i, row in enumerate(counts)]
    (tmp_path / "feet.csv").write_text("\n".join([f"t (ms),{','.join(CELLS)}", *rows]) + "\n")
    names = "t (ms),CoMX (mm),CoMY (mm),CoMZ (mm),dLX (Nm),dLY (Nm),LeftFootX (mm),RightFootX (mm)"
    body = rng.normal(0, 1, (500, 7))
    body[:, 2] += 250
    body[:, 5:] += np.linspace(0, 400, 500)[:, None]  # both feet step on
    rows = [",".join([f"{10 * i}", *(f"{v:.4f}" for v in row)]) for i, row in enumerate(body)]
    (tmp_path / "body.csv").write_text("\n".join([names, *rows]) + "\n")
    files = [guess_file(tmp_path / f"{name}.csv") for name in ("weights", "feet", "body")]
    parts, others = parts_of(files)
    assert not others
    assert [part.plan.role for part in parts] == ["weights", "cells", "body"]
    weights, walk, stream = (part.plan for part in parts)
    assert set(weights.channels) == set(walk.channels) == {
        f"{foot}_{cell}" for foot in ("left", "right") for cell in ("fl", "fr", "rl", "rr")
    }  # fmt: skip
    assert weights.entries["channel"].names["L_FSR_RR"] == "left_rr"
    assert walk.command == "online-replay"
    assert {"angmom_rate_x_nm", "angmom_rate_y_nm", "left_foot_x_m"} <= set(stream.entries)


def test_the_angle_of_a_shaft_is_the_phase_of_a_leg(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    names = "Zeit [ms];Winkel [°];Fx [N];Fy [N];Fz [N];Mx [Nm];My [Nm];Mz [Nm]"
    for side in ("x_up", "x_down", "z_up", "z_down"):
        wrench = rng.normal(0, 1, (200, 6))
        rows = [";".join([f"{20 * i}", f"{7.2 * i % 360:.1f}", *(f"{v:.3f}" for v in row)])
                for i, row in enumerate(wrench)]  # fmt: skip
        (tmp_path / f"hip_{side}.csv").write_text("\n".join([names, *rows]) + "\n")
    parts, _ = parts_of([guess_file(path) for path in sorted(tmp_path.glob("*.csv"))])
    (part,) = parts
    assert part.plan.command == "hang-calib"
    phase = part.plan.entries["phase_rad"]
    assert phase.column is not None
    assert (phase.column.column, phase.unit) == ("Winkel [°]", "deg")


@pytest.mark.parametrize("first", ["left", "right"])
def test_numbered_transducers_are_of_the_feet_that_stand(tmp_path: Path, first: str) -> None:
    """FT1 is where the load falls when that foot steps; its z points down, by the CoM's motion."""
    rng, n = np.random.default_rng(2), 400
    t = np.arange(n) / 100
    acc = np.column_stack([0.8 * np.sin(7 * t), 0.6 * np.cos(5 * t), 0 * t])
    share = np.clip(0.5 + 0.9 * np.sin(2 * np.pi * t), 0, 1)
    load = {"left": share, "right": 1 - share}
    order = (first, "right" if first == "left" else "left")
    down = np.array([1, -1, -1, 1, -1, -1])
    wrench, names, body, called = [t], ["t"], [t], ["t"]
    for i, side in enumerate(order):
        force = 40 * load[side][:, None] * (acc + np.array([0, 0, 9.81]))
        force += rng.normal(0, 0.5, (n, 3))
        wrench += list((np.hstack([force, rng.normal(0, 0.1, (n, 3))]) * down).T)
        names += [f"FT{i + 1}_{a}" for a in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    for side in ("left", "right"):
        body += [np.cumsum(load[side] == 0) / 100, *np.tile([0.1, 0.0, 0.0], (n, 1)).T]
        called += [f"{side}_foot_{a}" for a in ("x", "y", "z", "yaw")]
    body += [*np.tile([0, 0, 0.8], (n, 1)).T, *acc.T]
    called += [*(f"com_{a}" for a in "xyz"), *(f"com_acc_{a}" for a in "xyz")]
    logs = [tmp_path / "ft.csv", tmp_path / "body.csv"]
    for log, head, columns in ((logs[0], names, wrench), (logs[1], called, body)):
        np.savetxt(log, np.column_stack(columns), "%.5f", ",", header=",".join(head), comments="")
    parts, others = parts_of([guess_file(log) for log in logs])
    plan = next(part.plan for part in parts if part.plan.role == "cells")
    assert not others
    taken = [plan.entries[f"{order[0]}_f{a}_n"].column for a in "xyz"]
    assert [c and c.column for c in taken] == ["FT1_Fx", "FT1_Fy", "FT1_Fz"]
    assert plan.mounting.startswith("transducer_rotation_rpy_rad = [-3.141593, 0, 0]")
    assert len(plan.feet) == 2
    assert not any("body = " in line for blank in plan.blanks for line in blank.lines)


def test_weights_of_a_foot_are_those_of_its_placements(tmp_path: Path) -> None:
    """Cells by their columns' names, a trial is a placement: places alone are asked for."""
    holes = [(x, y) for x in (-40, 0, 40) for y in (-20, 0, 20)]
    rows = [f"{k}.0,{20 * k + i},{x},{y},1000,{900 + 7 * k},{800 + 5 * k},{700 - 3 * k},{650 + k}"
            for k, (x, y) in enumerate(holes) for i in range(3)]  # fmt: skip
    (tmp_path / "holes.csv").write_text(
        "\n".join(["trial,t_s,x_mm,y_mm,mass_g,s0,s1,s2,s3", *rows]) + "\n"
    )
    rows = [f"s{i},{run},{load},{5000 + 4 * load + 11 * i + run}"
            for run in range(2) for i in range(4) for load in (0, 200, 500, 1000)]  # fmt: skip
    (tmp_path / "weights.csv").write_text("\n".join(["sensor,run,mass_g,raw", *rows]) + "\n")
    parts, others = parts_of([guess_file(tmp_path / n) for n in ("holes.csv", "weights.csv")])
    assert not others
    plans = {part.plan.role: part.plan for part in parts}
    placed, weighed = plans["placements"], plans["weights"]
    assert placed.channels == weighed.channels
    assert weighed.entries["channel"].names == dict(
        zip(("s0", "s1", "s2", "s3"), placed.channels, strict=True)
    )
    trial = placed.entries["placement"].column
    assert trial is not None
    assert trial.column == "trial"
    assert placed.entries["time_s"].unit == "s"
    assert [blank.why for blank in placed.blanks] == ["no log says where the cells sit"]
