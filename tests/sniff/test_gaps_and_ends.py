"""Loads that do not stand in every row, lines that sum up, moments: what the data decide."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.errors import DataError
from footcal_cli.sniff.columns import guess_file
from footcal_cli.sniff.experiment import plan_of
from footcal_cli.sniff.loads import loads_and_cells
from footcal_cli.tables.turns import rows_of_turns
from tests.conftest import Run

SCALE, ZERO = 2e-4, 8_000_000


def counts(kg: float) -> int:
    """What an ideal cell reads."""
    return round(ZERO + 9.80665 * kg / SCALE)


def written(path: Path, lines: Sequence[str]) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


def load_of(path: Path) -> tuple[list[float], bool, tuple[str, ...]]:
    """Known loads of a log, whether gaps are held, and what stands where there is none."""
    loads, _ = loads_and_cells(guess_file(path))
    assert len(loads) == 1
    assert loads[0].values is not None
    return loads[0].values.tolist(), loads[0].held, loads[0].missing


@pytest.mark.parametrize(
    ("lies", "held"), [((0, 0, 1, 1, 2, 2), True), ((0, 5, 1, 7, 2, 3), False)]
)
def test_gaps_are_held_only_where_the_readings_agree(
    lies: tuple[float, ...], held: bool, tmp_path: Path
) -> None:
    noted = [f"{kg:g}" if i % 2 == 0 else "" for i, kg in enumerate(lies)]
    rows = [f"{kg},{counts(put)},{i}" for i, (kg, put) in enumerate(zip(noted, lies, strict=True))]
    values, was_held, missing = load_of(written(tmp_path / "log.csv", ["load_kg,adc,trial", *rows]))
    assert was_held == held
    assert values == pytest.approx(lies if held else [0, np.nan, 1, np.nan, 2, np.nan], nan_ok=True)
    assert missing == (() if held else ("",))


def test_loads_noted_as_events_after_the_first_rows_are_not_used_alone(tmp_path: Path) -> None:
    """The rows of the events are those in which a weight is just put on."""
    lies = [0.0] * 4 + [1.0] * 5 + [2.0] * 5
    noted = {4: "1", 9: "2"}
    rows = [f"{noted.get(i, '')},{counts(kg)},{i}" for i, kg in enumerate(lies)]
    _, held, missing = load_of(written(tmp_path / "log.csv", ["load_kg,adc,trial", *rows]))
    assert not held
    assert not missing


@pytest.mark.parametrize(("dash", "noted"), [(0.0, True), (3.0, False)])
def test_a_dash_is_no_load_where_the_readings_say_so(
    dash: float, noted: bool, tmp_path: Path
) -> None:
    stacks = [("-", dash), ("1kg", 1), ("2x1kg", 2), ("5kg", 5), ("5kg+2x1kg", 7), ("-", dash)]
    rows = [f"{word},{counts(kg) + i}" for word, kg in stacks for i in range(3)]
    values, _, missing = load_of(written(tmp_path / "log.csv", ["stack,adc", *rows]))
    assert values[:3] == pytest.approx([0.0 if noted else np.nan] * 3, nan_ok=True)
    assert ("-" in missing) != noted


@pytest.mark.parametrize(
    ("rows", "kept"),
    [
        (["0,5", "0,4", "1,9", "1,8", "2,12", "2,13", "5,25", "5,24", "16,100"], 8),
        (["0,5", "0,4", "1,9", "1,8", "2,12", "2,13", "5,25", "5,24", "16,101"], 9),
        (["0,0", "1,10", "2,20", "3,30"], 4),  # the last load is the sum of all others, too
    ],
)
def test_only_a_sum_far_beyond_all_rows_ends_a_table(
    rows: list[str], kept: int, tmp_path: Path
) -> None:
    assert guess_file(written(tmp_path / "log.csv", ["load_kg,adc", *rows])).rows == kept


@pytest.mark.parametrize(("sign", "role"), [(1.0, "cop_points"), (-1.0, None)])
def test_moments_are_a_cop_only_where_they_follow_the_marks(
    sign: float, role: str | None, tmp_path: Path
) -> None:
    marks = [(x, y) for x in (-100, 0, 100) for y in (-150, 0, 150)]
    rows = [f"{x},{y},400,{0.4 * y},{-0.4 * sign * x}" for x, y in marks]
    log = written(tmp_path / "log.csv", ["x_mm,y_mm,Fz (N),Mx (Nm),My (Nm)", *rows])
    plan = plan_of(guess_file(log))
    assert (plan.role if plan else None) == role


def test_a_plate_of_six_axes_without_marks_is_not_read_by_its_moments(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    rows = [",".join(f"{v:.3f}" for v in rng.normal(0, 5, 6)) for _ in range(40)]
    log = written(tmp_path / "log.csv", ["Fx,Fy,Fz,Mx,My,Mz", *rows])
    plan = plan_of(guess_file(log))
    assert plan is not None
    assert plan.command == "hang-calib"


def test_remarks_below_their_readings_are_refused(tmp_path: Path) -> None:
    lines = []
    for kg in (0, 1, 2, 5):
        lines += [str(counts(kg))] * 6 + [f"# that was {kg} kg"]
    with pytest.raises(DataError, match="each seems to be of the readings above it"):
        guess_file(written(tmp_path / "log.txt", lines))


def test_a_metric_of_two_labels_is_two_columns() -> None:
    text = "\n".join(
        f'raw{{cell="{cell}",rig="a"}} {i + k} {1_710_237_600_000 + 100 * i}'
        + f"\nload_kg {i} {1_710_237_600_000 + 100 * i}" * (k == 0)
        for i in range(4) for k, cell in enumerate(("fl", "fr"))
    )  # fmt: skip
    rows = rows_of_turns(text)
    assert len(rows) == 4
    assert rows[1] == {"time_ms": "1710237600100", "fl.raw": "1", "load_kg": "1", "fr.raw": "2"}


def test_readings_that_no_load_moves_are_no_fault_of_the_program(run: Run, tmp_path: Path) -> None:
    """The same numbers under every load: a slope of the rounding alone, and its inverse."""
    names = [f"{kg:g}kg.csv" for kg in (0, 0.5, 1, 2, 5)]
    for name in names:
        written(tmp_path / name, ["adc", *(f"{0.1 * i:.3f}" for i in range(25))])
    recipe = tmp_path / "my.toml"
    recipe.write_text(
        '[robot]\nchannels = ["cell"]\n[columns]\nchannel = { value = "cell" }\ncounts = "adc"\n'
        "load_n = { file_name = '^(\\d+(?:\\.\\d+)?)kg', unit = \"kg\" }\n"
        f"[data]\nweights = {names}\n"
    )
    answer = run("offline-fit", "--recipe", recipe, "--out", tmp_path / "out", "--quiet")
    assert answer.exit_code == 3
    assert "the readings do not depend on the loads" in answer.err


def test_an_inertial_unit_without_names_is_no_wrench(tmp_path: Path) -> None:
    """Rates of turning and accelerations, called x, y, z twice: gravity says which they are."""
    rng = np.random.default_rng(1)
    rot = Rotation.random(12, random_state=2)
    rows = [
        ",".join(f"{v:.5f}" for v in (*rng.normal(0, 0.01, 3), *felt, *turned))
        for felt, turned in zip(rot.inv().apply([0, 0, 9.81]), rot.as_quat(), strict=True)
        for _ in range(10)
    ]
    log = written(tmp_path / "imu.csv", ["x,y,z,x.1,y.1,z.1,x.2,y.2,z.2,w", *rows])
    plan = plan_of(guess_file(log))
    assert plan is None or plan.command != "hang-calib"


def test_a_second_table_below_what_was_looked_at_ends_the_first(tmp_path: Path) -> None:
    """Plates of a capture system are long; its markers stand below them."""
    row = ",".join(["{0}", *["-300.123456"] * 12])
    names = ",".join(["Frame", *(f"{k}{a}{i}" for i in (1, 2) for k in "FM" for a in "xyz")])
    plates = [row.format(i) for i in range(1, 9001)]
    markers = [f"{i},912.4,-80.1,33.0" for i in range(1, 901)]
    text = "\n".join([names, *plates, "", "Trajectories", "100", "Frame,X,Y,Z", *markers])
    (tmp_path / "trial.csv").write_text(text + "\n")
    guess = guess_file(tmp_path / "trial.csv")
    assert len(text) > 2**20
    assert guess.layout.until == "Trajectories"
    assert guess.rows == 9000
