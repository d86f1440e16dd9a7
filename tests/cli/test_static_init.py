"""``footcal static-init`` on stances whose truth is known, as the shell runs it."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pandas as pd
import pytest

from footcal_cli.core.chain import Chain, link
from footcal_cli.core.effects import TABLE
from footcal_cli.core.parameters import Status
from footcal_cli.records.files import read_record, write_record
from footcal_cli.records.results import EffectRecord, ParameterRecord, ParametersRecord, RmseRecord
from tests.cli.walk_files import write_belief, write_stand
from tests.conftest import Run, drawing
from tests.core.walk_data import CHANNELS, make_standing
from tests.core.walking import stand_log

OPTIONS = "[static_init]\ndelay_s = 0.0\nwarm_s = 0.25"


def test_one_stance_teaches_sums_and_says_so(run: Run, tmp_path: Path) -> None:
    made = make_standing(1, 3, replace=False)
    recipe, belief = write_stand(tmp_path, made, OPTIONS), write_belief(tmp_path, made)
    out = tmp_path / "out"
    answer = run("static-init", "--recipe", recipe, "--parameters", belief, "--out", out)
    assert answer.exit_code == 0, answer.err
    text = answer.out.replace("\n", " ")
    assert "1 stance shows 3 of 16 parameter directions" in text
    assert "none of the 16 parameters by itself" in text
    assert "diagonal twist of the biases" in text
    assert "Next stance to record: stand on the" in text
    record = read_record(ParametersRecord, out / "parameters.json")
    assert {p.status for p in record.parameters.values()} == {"prior kept: not observable"}


def test_ten_stances_with_lifted_feet_calibrate_the_biases(run: Run, tmp_path: Path) -> None:
    made = make_standing(16, 3, replace=True, lift=True)
    recipe, belief = write_stand(tmp_path, made, OPTIONS), write_belief(tmp_path, made)
    out = tmp_path / "out"
    with drawing():
        answer = run("static-init", "--recipe", recipe, "--parameters", belief, "--out", out)
    assert answer.exit_code == 0, answer.err
    assert "16 stances show 16 of 16 parameter directions" in answer.out.replace("\n", " ")
    record = read_record(ParametersRecord, out / "parameters.json")
    for i, channel in enumerate(CHANNELS):
        scale, bias = (record.parameters[f"{channel}.{n}"] for n in ("scale", "bias"))
        assert bias.status == "estimated"
        zero = -made.bias0[i] / made.scale0[i]
        assert scale.value * zero + bias.value == pytest.approx(made.true_bias[i], abs=0.3)
    errors = read_record(RmseRecord, out / "rmse.json")
    held = {(r.stage, r.quantity): r.rmse for r in errors.rows if r.split == "held_out"}
    assert held["after", "vgrf"] < held["before", "vgrf"]
    drawn = {p.stem for p in (out / "figures").glob("*.png")}
    assert drawn == {"curve", "stances", "directions", "beliefs"}


def test_a_gate_on_the_cop_is_judged_on_stances_not_seen(run: Run, tmp_path: Path) -> None:
    made = make_standing(4, 3, replace=True)
    recipe, belief = write_stand(tmp_path, made, OPTIONS), write_belief(tmp_path, made)
    answer = run(
        "static-init", "--recipe", recipe, "--parameters", belief, "--max-cop-rmse-mm", "0.001",
        "--out", tmp_path / "out",
    )  # fmt: skip
    assert answer.exit_code == 1
    assert "GATE NOT MET  cop_x" in answer.err


def test_a_robot_that_never_stands_still_is_told_how_long_to(run: Run, tmp_path: Path) -> None:
    made = make_standing(1, 3, replace=False, samples=50)
    recipe, belief = write_stand(tmp_path, made, OPTIONS), write_belief(tmp_path, made)
    answer = run(
        "static-init", "--recipe", recipe, "--parameters", belief, "--out", tmp_path / "out"
    )
    assert answer.exit_code == 3
    assert "stand still for at least" in answer.err
    assert answer.err.count("\n") == 1


def test_effects_of_a_calibration_are_undone_before_a_stand_is_judged(
    run: Run, tmp_path: Path
) -> None:
    """`parameters_extended.json` of a diagnosis: the same stances, read as bent cells show them."""
    made = make_standing(12, 3, replace=True)
    chain = Chain((link(TABLE["scale_bias"], CHANNELS),))
    values = {f"{c}.scale": float(v) for c, v in zip(CHANNELS, made.scale0, strict=True)}
    values |= {f"{c}.bias": float(v) for c, v in zip(CHANNELS, made.bias0, strict=True)}
    bent = chain.with_link(link(TABLE["nonlinearity"], CHANNELS, ["left_fl", "right_rr"]))
    sizes = {"left_fl.quadratic": 0.02, "right_rr.quadratic": -0.015}
    forces, _ = chain.remove(stand_log(made), values)
    shown, _ = bent.apply(forces, values | sizes)
    recipe = write_stand(tmp_path, dataclasses.replace(made, counts=shown.readings), OPTIONS)
    belief = write_belief(tmp_path, made)
    record = read_record(ParametersRecord, belief)
    effects: dict[str, tuple[str, ...]] = {"left_fl": ("left_fl",), "right_rr": ("right_rr",)}
    extended = record.model_copy(
        update={
            "parameters": record.parameters
            | {
                name: ParameterRecord(value=size, sd=None, unit="1/N", status=Status.FIXED)
                for name, size in sizes.items()
            },
            "effects": (EffectRecord(effect="nonlinearity", owners=effects),),
        }
    )
    write_record(extended, tmp_path / "extended.json")
    errors = {}
    for name in ("belief", "extended"):
        out = tmp_path / name
        answer = run("static-init", "--recipe", recipe, "--parameters", tmp_path / f"{name}.json",
                     "--out", out)  # fmt: skip
        assert answer.exit_code == 0, answer.err
        rows = read_record(RmseRecord, out / "rmse.json").rows
        errors[name] = {
            r.quantity: r.rmse for r in rows if r.split == "held_out" and r.stage == "after"
        }
    assert errors["extended"]["cop_x"] < 0.8 * errors["belief"]["cop_x"]
    assert errors["extended"]["vgrf"] < 0.8 * errors["belief"]["vgrf"]


def test_a_recording_that_the_logger_cut_into_files_is_one(run: Run, tmp_path: Path) -> None:
    """Cut within a stance, which would be two short ones."""
    made = make_standing(16, 3, replace=True, lift=True)
    recipe, belief = write_stand(tmp_path, made, OPTIONS), write_belief(tmp_path, made)
    logs = sorted(path for path in tmp_path.iterdir() if path.suffix in (".parquet", ".csv"))
    parts: dict[str, list[Path]] = {}
    for path in logs:
        log = pd.read_parquet(path) if path.suffix == ".parquet" else pd.read_csv(path)
        early = log["time_s"] < log["time_s"].quantile(0.46)
        for i, piece in enumerate((log[early], log[~early])):
            parts.setdefault(path.stem, []).append(tmp_path / f"{path.stem}_{i}.parquet")
            piece.to_parquet(parts[path.stem][-1])
    found = []
    for name, given in (("whole", logs), ("cut", [p for both in parts.values() for p in both])):
        out = tmp_path / name
        answer = run("static-init", *given, "--recipe", recipe, "--parameters", belief,
                     "--out", out)  # fmt: skip
        assert answer.exit_code == 0, answer.err
        record = read_record(ParametersRecord, out / "parameters.json")
        found.append([x for p in record.parameters.values() for x in (p.value, p.sd)])
    assert found[1] == pytest.approx(found[0])
    assert "16 stances" in answer.out.replace("\n", " ")


def test_scales_are_as_unsure_as_the_mass_that_the_robot_is_said_to_have(
    run: Run, tmp_path: Path
) -> None:
    made = make_standing(16, 3, replace=True, lift=True)
    recipe, belief = write_stand(tmp_path, made, OPTIONS), write_belief(tmp_path, made)
    weighed = recipe.read_text().replace("[robot]", "[robot]\nmass_sd_kg = 0.001")
    sd: dict[str, list[float]] = {}
    for how in ("not said", "weighed"):
        if how == "weighed":
            recipe.write_text(weighed)
        out = tmp_path / how
        answer = run("static-init", "--recipe", recipe, "--parameters", belief, "--out", out)
        assert answer.exit_code == 0, answer.err
        found = read_record(ParametersRecord, out / "parameters.json").parameters
        scales = [found[f"{c}.scale"] for c in CHANNELS]
        sd[how] = [(scale.sd or 0.0) / scale.value for scale in scales]
    shared = [(a**2 - b**2) ** 0.5 for a, b in zip(sd["not said"], sd["weighed"], strict=True)]
    # the mass is stated to 1 %: no scale takes more of its error, and zeros, which the robot in the
    # air leaves little of it, take a part that differs from cell to cell
    assert all(0.002 < s < 0.01 for s in shared)
    assert max(shared) == pytest.approx(min(shared), rel=0.1)


@pytest.mark.parametrize("command", ["static-init", "online-replay", "pose-calib", "apply"])
def test_without_a_recipe_a_refusal_says_what_the_log_looks_like(
    command: str, run: Run, tmp_path: Path
) -> None:
    log = tmp_path / "walk.csv"
    rows = [f"{0.01 * i:.2f},{251 + i % 7},{249 - i % 5}" for i in range(40)]
    log.write_text("\n".join(["t,left_Fz_N,right_Fz_N", *rows]))
    answer = run(command, log, "--out", tmp_path / "out")
    assert answer.exit_code == 2
    assert f"run `footcal init {log}`" in " ".join(answer.err.split())
    assert len(answer.err.split("for example:")[1].strip().splitlines()) == 3
