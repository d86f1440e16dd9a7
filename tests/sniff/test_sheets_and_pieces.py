"""``init`` of recordings with sheets of steps, weights by their names, grids and dates in notes."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.listed_places import corners_in, pieces_in
from footcal_cli.sniff.own_offsets import legs_by_offsets
from tests.conftest import Run

LOADS = (0.0, 5.0, 10.0, 15.0, 20.0, 15.0, 10.0, 5.0, 0.0)
STEP_S = 20.0


def recipe(run: Run, folder: Path) -> dict[str, Any]:
    done = run("init", folder, "-o", folder / "r.toml")
    assert done.exit_code == 0, done.err
    return tomllib.loads((folder / "r.toml").read_text(encoding="utf-8"))


def recorded(path: Path, scale: float, seed: int) -> None:
    """A ladder of holds at 20 Hz, restless for two seconds after each change."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, STEP_S * len(LOADS), 0.05)
    load = np.array(LOADS)[(t // STEP_S).astype(int)]
    restless = 0.3 * rng.standard_normal(t.size) * (t % STEP_S < 2.0)
    volts = scale * (load + restless + 0.002 * rng.standard_normal(t.size))
    np.savetxt(path, np.column_stack([1e3 * t, volts]), "%.6f", ",",
               header="t_ms,mV_per_V", comments="")  # fmt: skip


def test_one_sheet_of_steps_for_runs_of_several_cells(tmp_path: Path, run: Run) -> None:
    rows = ["run,mark_s,plates_lb"]
    for cell, scale in (("A", 0.01), ("B", 0.0102)):
        for again in (1, 2):
            recorded(tmp_path / f"cell{cell}_run{again}.txt", scale, ord(cell) + again)
            rows += [f"{cell}{again},{STEP_S * i:.1f},{lb:g}" for i, lb in enumerate(LOADS)]
    (tmp_path / "steps.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "NOTES.txt").write_text(
        "Positions in the foot, in inches: A (4.1, 0.0), B (-2.2, 1.5), C (-2.2, -1.5).\n"
        "Two runs per cell, the first one in the morning and the second one after lunch.\n"
        "Somebody has to touch the hanger when plates go on, and it swings a bit afterwards.\n"
    )
    found = recipe(run, tmp_path)
    assert found["robot"]["channels"] == ["A", "B"]
    files = {f["match"]: f for f in found["files"]}
    one = files["cellB_run2.txt"]
    assert one["join"][0]["only_where"] == {"run": "B2"}
    assert one["join"][0]["apart_s"] > 1.0
    assert one["columns"]["channel"] == {"value": "B"}
    assert one["columns"]["session"] == {"value": 2}
    fitted = run("offline-fit", "--recipe", tmp_path / "r.toml", "--out", tmp_path / "o")
    assert fitted.exit_code == 0, fitted.err


def test_a_sheet_of_steps_for_each_recording_and_weights_in_notes(tmp_path: Path, run: Run) -> None:
    stacks = ("-", "P1", "P1+P2", "P1+P2+P3", "P1+P2+P3+P4")
    ladder = [*stacks, *stacks[-2::-1]]
    for cell in "AB":
        for again in (1, 2):
            stem = tmp_path / f"istunto{again}_kenno{cell}"
            recorded(Path(f"{stem}.csv"), 0.04, ord(cell) + again)
            rows = [f"{i + 1},{STEP_S * i:.1f},{put},21.5" for i, put in enumerate(ladder)]
            Path(f"{stem}_loki.csv").write_text(
                "\n".join(["askel,alku_s,punnukset,lampotila_C", *rows]) + "\n"
            )
    (tmp_path / "NOTES.txt").write_text(
        "Punnusten massat ja niiden numerot on annettu tässä luettelossa (kg):\n"
        "  P1 4,9987   P2 5,0012   P3 4,9994   P4 5,0021\n"
        "Punnukset pinotaan vadille keskelle, yksi kerrallaan lisää tai pois, ja odotetaan.\n"
    )
    found = recipe(run, tmp_path)
    assert found["robot"]["channels"] == ["kennoa", "kennob"]
    one = next(f for f in found["files"] if f["match"] == "istunto2_kennoB.csv")
    assert one["columns"]["load_n"]["names"]["P1+P2"] == "9.9999"
    assert one["columns"]["session"] == {"value": 2}


def test_stacks_of_weights_by_their_letters(tmp_path: Path, run: Run) -> None:
    rng = np.random.default_rng(2)
    masses = dict(zip("ABCDE", (5.005, 5.001, 5.0, 4.999, 4.996), strict=True))
    (tmp_path / "kotouce.csv").write_text(
        "\n".join(["kotouc;hmotnost_kg", *(f"{k};{v}" for k, v in masses.items())]) + "\n"
    )
    rows = ["relace;snimac;krok;kotouce;cteni_prumer;cteni_smodch"]
    for again in (1, 2):
        for cell in ("S1", "S2"):
            order = "".join(rng.permutation([*"ABCDE"]))
            stacks = [order[:n] for n in (0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0)]
            for step, put in enumerate(stacks):
                kg = sum(masses[letter] for letter in put)
                counts = round(99000 + 82000 * kg + 60 * rng.standard_normal())
                scatter = round(450 + 8 * rng.standard_normal())
                rows.append(f"{again};{cell};{step};{put or '-'};{counts};{scatter}")
    (tmp_path / "cteni.csv").write_text("\n".join(rows) + "\n")
    columns = recipe(run, tmp_path)["columns"]
    assert columns["counts"] == "cteni_prumer"
    assert columns["channel"] == "snimac"
    assert columns["load_n"]["column"] == "kotouce"
    assert columns["load_n"]["names"]["-"] == "0"


def test_a_grid_by_two_corners() -> None:
    text = (
        "Griglia 7 x 5: lettera A..G lungo x, passo 45 mm; numero 1..5 lungo y, passo 40 mm.\n"
        "Quindi A1 = (-135, -80), G5 = (+135, +80).\n"
    )
    sheet = corners_in(Path("NOTES.txt"), text)
    assert sheet is not None
    places = {
        name: (sheet.columns[1].values[i], sheet.columns[2].values[i])  # type: ignore[index]
        for i, name in enumerate(sheet.columns[0].words)
    }
    assert len(places) == 35
    assert places["D3"] == pytest.approx((0.0, 0.0))
    assert places["B5"] == pytest.approx((-90.0, 80.0))
    assert corners_in(Path("NOTES.txt"), text.replace("45", "7").replace("40", "9")) is None


def test_weights_that_notes_list() -> None:
    sheet = pieces_in(Path("NOTES.txt"), "Pesi: M1 10,004 kg   M2 10,001 kg   M3 9,997 kg")
    assert sheet is not None
    assert sheet.columns[0].words == ("M1", "M2", "M3")
    assert sheet.columns[1].unit == "kg"
    assert pieces_in(Path("NOTES.txt"), "cells c1 0.5 c2 0.7 without a unit") is None


def test_files_of_six_axes_are_legs_where_their_offsets_differ(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)

    def hung(name: str, offset: tuple[float, ...]) -> Path:
        down = rng.standard_normal((60, 3))
        down /= np.linalg.norm(down, axis=1)[:, None]
        force = 33.0 * down + offset + 0.1 * rng.standard_normal((60, 3))
        torque = np.cross([0.0, 0.0, -0.12], 33.0 * down)
        table = np.column_stack([20 * np.arange(60), force, torque])
        np.savetxt(tmp_path / name, table, "%.5f", ",", header="t,Fx,Fy,Fz,Mx,My,Mz", comments="")
        return tmp_path / name

    legs = [guess_file(hung(f"g_{n}.csv", tuple(4.0 * rng.standard_normal(3)))) for n in "abc"]
    runs = [guess_file(hung(f"r_{n}.csv", (3.0, -2.0, 5.0))) for n in "abc"]
    assert legs_by_offsets(legs, ("BKA", "BKI", "DKA")) == {
        "BKA": "bka", "BKI": "bki", "DKA": "dka"
    }  # fmt: skip
    assert legs_by_offsets(runs, ("a", "b", "c")) == {}


def test_streams_that_gave_nothing_leave_the_header_whole(tmp_path: Path) -> None:
    rows = [f"{10 * i};{1 + 0.001 * (i % 7):.4f};{1.1 + 0.001 * (i % 5):.4f};;;" for i in range(99)]
    (tmp_path / "hung.csv").write_text("\n".join(["t_ms;fi1;fi2;cm_x;cm_y;cm_z", *rows]) + "\n")
    file = guess_file(tmp_path / "hung.csv")
    assert [c.column for c in file.columns] == ["t_ms", "fi1", "fi2", "cm_x", "cm_y", "cm_z"]
