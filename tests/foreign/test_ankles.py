"""`online-replay` on six-axis ankles, in a world that it does not know."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footcal_cli.core.online.merging import merge_six_axis
from footcal_cli.core.online.six_axis_replay import replay_six_axis
from footcal_cli.core.online.streams import BodyStream, Merged, MergeRule, SensorStream
from tests.foreign import draw_biped, walk
from tests.foreign.ankles import AXES, UNITS, ankle_offsets
from tests.foreign.biped import FEET


def merged(seed: int) -> Merged:
    """The walk of a seed as its recipe has it."""
    recorded, robot = walk(seed), draw_biped(seed)
    cells, body = recorded.logs["cells"], recorded.logs["body"]
    columns = [f"{f}_{a}_{u}" for f in FEET for a, u in zip(AXES, UNITS, strict=True)]
    sensors = SensorStream(cells["time_s"].to_numpy(), cells[columns].to_numpy(), tuple(columns))

    def vector(pattern: str, axes: str = "xyz") -> np.ndarray:
        return body[[pattern.format(axis) for axis in axes]].to_numpy()

    rot = np.stack(
        [Rotation.from_quat(vector(f"{f}_foot_q{{}}", "xyzw")).as_matrix() for f in FEET], axis=1
    )
    stream = BodyStream(
        body["time_s"].to_numpy(), vector("com_{}_m"), vector("com_acc_{}_mps2"),
        vector("angmom_rate_{}_nm", "xy"),
        np.stack([vector(f"{f}_foot_{{}}_m") for f in FEET], axis=1),
        np.arctan2(rot[..., 1, 0], rot[..., 0, 0]), rot,
    )  # fmt: skip
    foot = robot.recipe()["feet"]["left"]
    return merge_six_axis(
        sensors, stream, ((np.array(foot["transducer_position_m"]), np.eye(3)),) * 2,
        np.array([[foot["weight_below_n"], 3.0]] * 2), np.array([foot["com_below_m"]] * 2),
        robot.mass_kg, 9.80665, rule=MergeRule(delay_s=recorded.truth["stated_delay_s"]),
    )  # fmt: skip


@pytest.mark.slow
def test_what_a_foot_in_the_air_keeps_is_its_offset() -> None:
    """With noise of any length its vertical offsets were off by 0.8 and 1.0 N (3 and 4 sd)."""
    found = replay_six_axis(merged(107013), samples_per_update=5).estimates
    for foot, true in zip(FEET, ankle_offsets(draw_biped(107013)), strict=True):
        assert found[f"{foot}.offset_fz"] == pytest.approx(float(true[2]), abs=0.1)
        assert found.sd[found.names.index(f"{foot}.offset_fz")] < 0.1
