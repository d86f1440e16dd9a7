"""``[[effect]]`` rows of a recipe: checked, simulated, kept in records, refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from footcal_cli.core.chain import Chain, Link
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.effects.own import OwnRow, own_effect
from footcal_cli.core.log import Log
from footcal_cli.records import effects
from footcal_cli.records.files import read_record
from footcal_cli.records.results import EffectRecord, TruthRecord
from tests.conftest import REPOSITORY, Run

FEET = (REPOSITORY / "recipes/nao_simulated.toml").read_text().partition("[simulate]")[0]
ROW = """
[[effect]]
name = "soft_seat"
adds = "k * load * exp(-load / w)"
unit = "-"
usual = 0.05
remedy = "change the rubber"
experiments = ["weights"]
shapes = { w = { unit = "N", values = [2.0, 4.0, 8.0] } }
"""


def recipe(folder: Path, row: str = ROW) -> Path:
    path = folder / "own.toml"
    path.write_text(FEET + row, encoding="utf-8")
    return path


def test_the_check_states_contract_and_likeness(run: Run, tmp_path: Path) -> None:
    answer = run("effects", "--check", "--recipe", recipe(tmp_path))
    assert answer.exit_code == 0, answer.err
    assert answer.out.count("\nok ") == 5
    assert "dead_zone 0." in answer.out
    too_large = ROW.replace("usual = 0.05", "usual = 40.0")
    failed = run("effects", "--check", "--recipe", recipe(tmp_path, too_large))
    assert failed.exit_code == 1
    assert "FAILS    removing it undoes it" in failed.out


def test_a_simulated_log_keeps_the_row_in_its_truth(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = run(
        "simulate", "--experiment", "weights", "--effect", "left_fl.soft_seat=0.1,soft_seat_w=3",
        "--recipe", recipe(tmp_path), "--out", out, "--no-pictures",
    )  # fmt: skip
    assert answer.exit_code == 0, answer.err
    truth = read_record(TruthRecord, out / "truth.json")
    (item,) = [item for item in truth.effects if item.effect == "soft_seat"]
    assert item.row is not None
    chain = Chain((Link(effects.effect_of(item), dict(item.owners)),))
    load = np.linspace(0.0, 20.0, 50)[:, None]
    still = np.zeros(50, dtype=np.int64)
    log = Log("weights", ("left_fl",), np.arange(50.0), load, {}, still)
    shown, _ = chain.apply(log, truth.parameters)
    np.testing.assert_allclose(shown.readings, load + 0.1 * load * np.exp(-load / 3.0))
    restored, _ = chain.remove(shown, truth.parameters)
    np.testing.assert_allclose(restored.readings, load, atol=1e-10)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("load * exp", "laod * exp", "soft_seat: unknown signal 'laod'; did you mean 'load'?"),
        ("soft_seat", "hysteresis", "there is such an effect already"),
        ("usual = 0.05", "usual = 0.05\nbounds = [0.1, 0.2]", "bounds must hold 0"),
        ('remedy = "change the rubber"', "", "effect.0.remedy"),
    ],
)
def test_a_row_that_is_none_is_one_line(
    run: Run, tmp_path: Path, old: str, new: str, said: str
) -> None:
    answer = run("effects", "--recipe", recipe(tmp_path, ROW.replace(old, new)))
    assert answer.exit_code == 2
    assert said in answer.err
    assert len(answer.err.splitlines()) == 1


class _Point:
    value = "elsewhere:effects"

    def __init__(self, given: object) -> None:
        self.given = given

    def load(self) -> object:
        return self.given


def test_packages_bring_effects_by_entry_points(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    theirs: Effect = own_effect(OwnRow("theirs", "k * load ** 2", "ask them", "1/N", 0.01))
    monkeypatch.setattr(effects, "entry_points", lambda group: [_Point([theirs])])
    assert "ask them" in run("effects", "theirs").out
    owners: dict[str, tuple[str, ...]] = {"all": ("left_fl",)}
    assert effects.effect_of(EffectRecord(effect="theirs", owners=owners)) is theirs
    monkeypatch.setattr(effects, "entry_points", lambda group: [_Point([object()])])
    assert "no new effect" in run("effects").err
    monkeypatch.setattr(effects, "entry_points", lambda group: [])
    with pytest.raises(Exception, match="nothing here knows"):
        effects.effect_of(EffectRecord(effect="theirs", owners=owners))
