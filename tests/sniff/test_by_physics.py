"""``init`` of logs in words that no table of it has: what columns are is seen in their numbers."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from footcal_cli.core.bench.shared_loads import common_scale
from footcal_cli.sniff.said_scales import scale_in
from footcal_cli.tables.drawn import with_whole_remarks
from tests.conftest import Run

CELLS_M = np.array([[0.12, -0.06], [0.12, 0.06], [-0.12, 0.06], [-0.12, -0.06]])
SCALE = np.array([0.0009, 0.00088, 0.00091, 0.0009])
WEIGHT_N = 9.81 * np.repeat([20.0, 10.0], 35)
PLATE = """Four cells in mm: k1 (120, -60) k2 (120, 60) k3 (-120, 60) k4 (-120, -60), x forward.
The cells give about 1120 counts per newton, +-3 %, and were not tared by us before.
"""


def plate(seed: int) -> tuple[np.ndarray[Any, Any], ...]:
    """Counts (n, 4), the zeros before them, places (n, 2) and how far off them the weight lay."""
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.linspace(-0.1, 0.1, 7), np.linspace(-0.05, 0.05, 5)), -1)
    hole = np.tile(grid.reshape(-1, 2), (2, 1))
    off = 0.002 * rng.standard_normal(hole.shape)
    x, y = (hole + off).T
    share = np.stack([(1 + sx * x / 0.12) * (1 + sy * y / 0.06) / 4 for sx, sy in
                      np.sign(CELLS_M)], axis=1)  # fmt: skip
    zero = 8.3e6 + 400.0 * np.arange(4) + np.cumsum(3 * rng.standard_normal((70, 4)), axis=0)
    counts = zero + WEIGHT_N[:, None] * share / SCALE + 20 * rng.standard_normal((70, 4))
    return np.rint(counts), np.rint(zero), hole, off


def recipe(run: Run, folder: Path) -> dict[str, Any]:
    done = run("init", folder, "-o", folder / "r.toml")
    assert done.exit_code == 0, done.err
    return tomllib.loads((folder / "r.toml").read_text(encoding="utf-8"))


def test_places_zeros_and_corrections_by_what_cells_felt(tmp_path: Path, run: Run) -> None:
    counts, zero, hole, off = plate(1)
    table = np.column_stack([np.arange(70), 1e3 * hole, 1e3 * off, WEIGHT_N / 9.81, zero, counts])
    head = "nr,otw_x,otw_y,dx,dy,m_kg,z1,z2,z3,z4,k1,k2,k3,k4"
    np.savetxt(tmp_path / "pomiary.csv", table, "%.9g", ",", header=head, comments="")
    (tmp_path / "NOTES.txt").write_text(PLATE)
    found = recipe(run, tmp_path)
    columns = found["columns"]
    assert columns["hole_x_m"] == {"column": "otw_x", "unit": "mm", "plus": {"dx": "mm"}}
    assert columns["hole_y_m"] == {"column": "otw_y", "unit": "mm", "plus": {"dy": "mm"}}
    assert columns["k3_counts"] == {"column": "k3", "minus": "z3"}
    assert found["robot"]["nameplate"]["scale_n_per_count"] == pytest.approx(1 / 1120, rel=1e-5)
    assert found["robot"]["nameplate"]["scale_relative_sd"] == 0.03
    fitted = run("offline-fit", "--recipe", tmp_path / "r.toml", "--out", tmp_path / "o")
    assert fitted.exit_code == 0, fitted.err
    assert "CoP error" in fitted.out


def test_a_scale_and_zeros_by_the_weights_on_a_plate() -> None:
    counts, _, hole, off = plate(2)
    scale, bias = common_scale(counts, WEIGHT_N, hole + off, CELLS_M)
    assert scale == pytest.approx(SCALE.mean(), rel=0.02)
    forces = counts * scale + bias
    np.testing.assert_allclose(forces.sum(axis=1), WEIGHT_N, atol=0.03 * WEIGHT_N.max())


def walk(folder: Path, words: dict[str, str], *, hung: bool) -> None:
    """Two feet that step in turn, of four cells each, the body in the same table."""
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 30.0, 0.01)
    phase = np.mod(t, 1.2) / 1.2
    swings = {"left": phase < 0.35, "right": (phase > 0.5) & (phase < 0.85)}
    at = {}
    for i, (foot, moves) in enumerate(swings.items()):
        u = np.clip((phase - 0.5 * i) / 0.35, 0.0, 1.0)
        x = 0.3 * (np.floor(t / 1.2) + np.where(phase < 0.5 * i, 0.0, u * u * (3 - 2 * u)))
        y = np.full(t.size, 0.1 if foot == "left" else -0.1)
        at[foot] = np.column_stack([x, y, np.where(moves, 0.05 * np.sin(np.pi * u), 0.0)])
    middle = (at["left"] + at["right"]) / 2
    # the CoM goes on evenly
    com = np.column_stack([0.25 * t, 0.02 * np.sin(2 * np.pi * t / 1.2), np.full(t.size, 0.7)])
    com[:, 0] += middle[:, 0].mean() - com[:, 0].mean()
    columns: dict[str, Any] = {"t_s": t}
    for foot in swings:
        carries = ~swings[foot]
        for cell in range(1, 5):
            load = np.convolve(carries * 60.0, np.ones(5) / 5, "same")
            columns[f"{words[foot]}_kyt{cell}"] = np.rint(
                9000 + 300 * cell + 75 * load + 15 * rng.standard_normal(t.size)
            )
    for foot, place in at.items():
        columns |= {f"{words[foot]}_podi_{a}": place[:, k] for k, a in enumerate("xyz")}
        columns[f"{words[foot]}_epafi"] = (~swings[foot]).astype(float)
    columns |= {f"kb_{a}": com[:, k] for k, a in enumerate("xyz")}
    table = np.column_stack([*columns.values()])
    np.savetxt(folder / "peripatos.csv", table, "%.9g", ",", header=",".join(columns), comments="")
    if hung:
        cells = [c for c in columns if "kyt" in c]
        still = np.column_stack([
            t[:500], *(9000 + 300 * int(c[-1]) + 15 * rng.standard_normal(500) for c in cells)
        ])  # fmt: skip
        np.savetxt(folder / "prin.csv", np.rint(still * 100) / 100, "%.9g", ",",
                   header=",".join(["t_s", *cells]), comments="")  # fmt: skip


@pytest.mark.parametrize("words", [("ar", "de"), ("oen", "oreun"), ("ab", "cd")])
def test_cells_are_of_the_foot_that_the_bodys_stream_calls_so(
    tmp_path: Path, run: Run, words: tuple[str, str]
) -> None:
    walk(tmp_path, dict(zip(("left", "right"), words, strict=True)), hung=True)
    found = recipe(run, tmp_path)
    cells = next(f for f in found.get("files", [found]) if "peripatos" in str(f.get("match", "p")))
    columns = cells.get("columns", found.get("columns", {}))
    assert columns["left_kyt1_counts"] == f"{words[0]}_kyt1"
    assert columns["right_kyt4_counts"] == f"{words[1]}_kyt4"
    assert not any("epafi" in str(entry) for entry in columns.values())
    assert [Path(p).name for p in found["data"]["zeros"]] == ["prin.csv"]


def stand(folder: Path) -> None:
    """Poses on two feet whose places have no z, and whose names differ by a letter."""
    rng = np.random.default_rng(4)
    rows = []
    for _ in range(24):
        share = rng.uniform(0.3, 0.7)
        com = [1e3 * rng.uniform(-0.03, 0.05), 1e3 * (0.2 * share - 0.1), 600.0]
        left = 1.0 + 0.9 * share * rng.dirichlet([9, 9, 9, 9])
        right = 1.0 + 0.9 * (1 - share) * rng.dirichlet([9, 9, 9, 9])
        pose = [0.5, 100.0, 4.0 + rng.normal(), -0.5, -100.0, -4.0 + rng.normal(), *com]
        rows += [[*left + 1e-3 * rng.standard_normal(4), *right, *pose] for _ in range(40)]
    head = "fi1 fi2 fi3 fi4 fd1 fd2 fd3 fd4 pi_x pi_y pi_ang pd_x pd_y pd_ang cm_x cm_y cm_z"
    table = np.column_stack([10 * np.arange(len(rows)), rows])
    np.savetxt(folder / "pose.csv", table, "%.7g", ",",
               header=f"t_ms,{head.replace(' ', ',')}", comments="")  # fmt: skip


def test_feet_of_a_stand_without_heights_by_their_twins(tmp_path: Path, run: Run) -> None:
    stand(tmp_path)
    (tmp_path / "NOTES.txt").write_text(
        "The robot stands on both feet, in all poses, and nothing else touches it at all.\n"
        "Its mass is 41.6 kg on the floor scale with the battery and both of the soles.\n"
        "The catalogue says 80 N/V (+-6 %) of every cell, compression gives more volts.\n"
    )
    found = recipe(run, tmp_path)
    columns = found["columns"]
    assert columns["left_foot_y_m"] == {"column": "pi_y", "unit": "mm"}
    assert columns["right_foot_yaw_rad"]["column"] == "pd_ang"
    assert columns["com_z_m"] == {"column": "cm_z", "unit": "mm"}
    assert columns["left_1_counts"] == "fi1"
    assert columns["right_4_counts"] == "fd4"
    assert found["robot"]["mass_kg"] == 41.6
    assert found["robot"]["nameplate"]["scale_n_per_count"] == 80


@pytest.mark.parametrize(
    ("said", "unit", "scale"),
    [
        ("about 46 đơn vị/N, a few percent apart", None, 1 / 46),
        ("Constante de catálogo 80 N/V (±6 %)", "V", 80.0),
        ("nominal 600 N = 4,0 V of the amplifier", "V", 150.0),
        ("52428 counts for 70 kgf", None, 70 * 9.80665 / 52428),
        ("nominal 2,0 mV/V a 30 kgf (full scale)", "mV/V", 30 * 9.80665 / 2),
        ("1 count = 0.0125 N", None, 0.0125),
        ("0,00182 N per conteggio", None, 0.00182),
    ],
)
def test_a_sensitivity_in_any_words(said: str, unit: str | None, scale: float) -> None:
    found = scale_in([said], unit)
    assert found is not None
    assert found[0] == pytest.approx(scale, rel=1e-6)


def test_two_sensitivities_are_none() -> None:
    assert scale_in(["left 80 N/V", "right 90 N/V"], "V") is None
    assert scale_in(["cells of 300 N, read at 50 Hz in volts"], "V") is None


def test_a_remark_with_commas_is_one_field() -> None:
    rows = ["1,2.0,\n", "2,2.5,again, the cable hung\n", "3,2.7,fine\n"]
    assert with_whole_remarks(rows, ",", 3)[1] == '2,2.5,"again, the cable hung"\n'
    decimal = ["1,2,5\n", "2,2,7,1\n"]  # decimal commas are none
    assert with_whole_remarks(decimal, ",", 3) == decimal
