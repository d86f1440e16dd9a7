"""A stranger's log goes in, a calibration or the next step comes out."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import Run
from tests.strangers import (
    eighteenth,
    eighth,
    eleventh,
    fifteenth,
    fifth,
    fourteenth_bench,
    fourteenth_robots,
    fourth,
    later,
    legged,
    nineteenth,
    ninth,
    seen,
    seen_wrists,
    seventeenth,
    seventh_bench,
    seventh_robots,
    seventh_wrists,
    sixteenth_bench,
    sixteenth_robots,
    sixth_bench,
    sixth_robots,
    sixth_wrists,
    split_names,
    tenth_bench,
    tenth_robots,
    third,
    thirteenth_bench,
    thirteenth_robots,
    thirtieth,
    thirty_eighth,
    thirty_fifth,
    thirty_first,
    thirty_first_robots,
    thirty_first_stands,
    thirty_fourth,
    thirty_ninth,
    thirty_second,
    thirty_seventh,
    thirty_sixth,
    thirty_third,
    turned,
    twelfth_bench,
    twelfth_robots,
    twentieth,
    twenty_eighth_bench,
    twenty_eighth_robots,
    twenty_fifth,
    twenty_first,
    twenty_fourth_bench,
    twenty_fourth_robots,
    twenty_ninth,
    twenty_second,
    twenty_seventh,
    twenty_sixth,
    twenty_third_bench,
    twenty_third_robots,
    unseen,
)
from tests.strangers.rigs import Write
from tests.strangers.trial import trial

SAMPLE = (
    seen.one_file_per_channel, third.netft_orientations, third.mixed_unit_texts, fourth.labview_lvm,
    fourth.two_rows_of_names, legged.quadruped_long_pushes, legged.hexapod_standing,
    sixth_robots.hung_by_accelerometer, sixth_robots.solo_torque_first_nwu,
    sixth_wrists.known_wrenches_on_an_ankle,
    seventh_bench.event_column, ninth.urscript_pose, tenth_bench.minus_9999,
    eleventh.poses_in_a_sheet, eleventh.simulink_structure, tenth_robots.qualisys_force_tsv,
    twelfth_robots.zeros_where_lost, twelfth_bench.stata_list, twelfth_bench.xml_records,
    thirteenth_bench.campbell_toa5, thirteenth_robots.axis_and_angle,
    thirteenth_bench.html_of_a_scale, fourteenth_bench.confluence_wiki,
    fourteenth_bench.certificate_kilonewtons, fourteenth_robots.xarm_report,
    twelfth_bench.added_and_removed, sixteenth_bench.notebook_of_sums,
    sixteenth_bench.torque_by_lever, sixteenth_bench.wincc_archive, sixteenth_bench.pandas_describe,
    sixteenth_bench.phone_terminal, sixteenth_bench.repl_lists,
    sixteenth_robots.simulink_inspector, sixteenth_robots.sensor_logger_zyx,
    sixteenth_robots.melfa_positions, sixteenth_robots.kuka_rsi_xml,
    seventeenth.linear_acceleration, seventeenth.stamped_and_weighed, seventeenth.ten_samples_a_row,
    fourteenth_bench.tracer_daq, fourteenth_bench.openscale, twentieth.samples_and_their_extremes,
    twentieth.force_and_its_stress, twentieth.millis_that_jitter, twentieth.one_clock_in_two_files,
    twentieth.flags_are_no_loads, twentieth.vertical_axis_is_dead, twentieth.steps_of_two_insoles,
    twentieth.poses_alone, twentieth.one_row, twentieth.stamps_out_of_order,
    twenty_second.matrices_in_a_second_file, twenty_second.angle_of_the_shaft,
    twenty_second.results_of_a_calibration, twenty_second.one_axis_is_dead,
    twenty_third_bench.tdms_as_text, twenty_third_bench.influx_annotated,
    twenty_third_bench.names_below_units, twenty_third_bench.listed_loads_held_briefly,
    twenty_third_bench.markdown_notebook, twenty_third_bench.summary_mean_sd,
    twenty_third_bench.readings_of_lbf_force, twenty_third_robots.kistler_two_dimensions,
    twenty_third_robots.json_of_topics, twenty_third_robots.flat_message_with_groups,
    twenty_third_robots.topics_for_legs, twenty_third_robots.holds_of_weights_short,
    thirteenth_bench.percent_of_full_scale, twenty_fourth_bench.diadem_extremes,
    twenty_fourth_bench.totals_below,
    twenty_fourth_bench.plates_times, twenty_fourth_bench.pounds_in_file_names,
    twenty_fourth_bench.broken_header_cells,
    twenty_fourth_bench.merged_loads, twenty_fourth_bench.said_afterwards,
    twenty_fourth_bench.target_and_actual, twenty_fourth_bench.shunt_first,
    twenty_fourth_bench.lvm_segments, twenty_fourth_robots.one_matrix_per_hold,
    twenty_fourth_robots.file_per_hold_and_angles, twenty_fourth_robots.matrix_in_one_cell,

    twenty_eighth_bench.nines_where_nothing, twenty_eighth_bench.grams_called_kilograms,
    twenty_eighth_robots.medilogic_sohlen, twenty_eighth_robots.russian_wrist,
    twenty_fourth_robots.plate_moments_at_points,
    twenty_fourth_robots.c3d_two_plates, twenty_fourth_robots.amti_points_in_file_names,
    twenty_fourth_robots.feet_loaded_by_name,
    twenty_fifth.metrics_of_two_cells, twenty_sixth.trailing_minus,
    twenty_sixth.mass_in_each_head, twenty_sixth.up_down_and_mean,
    twenty_sixth.quaternion_in_counts,
    twenty_ninth.monitor_and_protocol, twenty_ninth.smart_home,
    twenty_ninth.registers_of_a_master, twenty_ninth.plates_that_point_down,
    *thirtieth.THIRTIETH, *split_names.SPLIT_NAMES, *thirty_fifth.THIRTY_FIFTH,
    *thirty_sixth.THIRTY_SIXTH, thirty_seventh.italian_counts_and_holes,
    thirty_seventh.japanese_plates, thirty_eighth.turkish_wrist, thirty_eighth.channel_by_number,
    thirty_first.italian_amplifier, thirty_first.merged_feet, thirty_first.tare_and_weights,
    thirty_first_stands.merged_french_stand, thirty_first_stands.motive_and_cells,
    thirty_first_robots.legs_in_their_files, thirty_first_robots.numbered_legs_and_hips,
    twenty_seventh.ros_json_of_two_arms, twenty_seventh.comment_column_of_loads,

)  # fmt: skip
"""Shapes that between them pass every line of the reader; the whole corpora are slow."""


NOT_READ: dict[str, set[str]] = {
    "twenty_seventh": {"counts_with_their_sign_apart"},
    "twenty_eighth": {"si_suffixes", "telegraf_tags_in_a_cell"},
    "thirty_third": {"notes_of_who_lay_where"},
}
"""Logs that end with a refusal which does not lead on, by corpus; docs/bring_your_log.md."""


@pytest.mark.parametrize("shape", SAMPLE, ids=lambda s: s.__name__)
def test_a_sample_of_the_corpus(shape: Write, run: Run, tmp_path: Path) -> None:
    found = trial(shape, tmp_path, run)
    assert found.outcome == ("next step" if found.made.says else "calibration")


CORPORA = {
    "seen": (*seen.SEEN, *seen_wrists.SEEN_WRISTS), "unseen": unseen.UNSEEN,
    "third": third.THIRD, "later": later.LATER, "turned": turned.TURNED,
    "legged": legged.LEGGED,
    "fifteenth": fifteenth.FIFTEENTH, "seventeenth": seventeenth.SEVENTEENTH,
    "eighteenth": eighteenth.EIGHTEENTH, "nineteenth": nineteenth.NINETEENTH,
    "twentieth": twentieth.TWENTIETH, "twenty_first": twenty_first.TWENTY_FIRST,
    "twenty_second": twenty_second.TWENTY_SECOND,
    "twenty_fourth": (
        *twenty_fourth_bench.TWENTY_FOURTH_BENCH, *twenty_fourth_robots.TWENTY_FOURTH_ROBOTS
    ),
    "twenty_fifth": twenty_fifth.TWENTY_FIFTH, "twenty_sixth": twenty_sixth.TWENTY_SIXTH,
    "twenty_seventh": twenty_seventh.TWENTY_SEVENTH, "twenty_ninth": twenty_ninth.TWENTY_NINTH,
    "thirtieth": thirtieth.THIRTIETH,
    "thirty_first": (
        *thirty_first.THIRTY_FIRST_BENCH, *thirty_first_stands.THIRTY_FIRST_STANDS,
        *thirty_first_robots.THIRTY_FIRST_ROBOTS,
    ),
    "twenty_eighth": (
        *twenty_eighth_bench.TWENTY_EIGHTH_BENCH, *twenty_eighth_robots.TWENTY_EIGHTH_ROBOTS
    ),
    "twenty_third": (
        *twenty_third_bench.TWENTY_THIRD_BENCH, *twenty_third_robots.TWENTY_THIRD_ROBOTS
    ),
    "sixteenth": (
        *sixteenth_bench.SIXTEENTH_BENCH, *sixteenth_robots.SIXTEENTH_ROBOTS
    ),
    "thirty_second": thirty_second.THIRTY_SECOND, "thirty_third": thirty_third.THIRTY_THIRD,
    "thirty_fourth": thirty_fourth.THIRTY_FOURTH, "split_names": split_names.SPLIT_NAMES,
    "thirty_seventh": thirty_seventh.THIRTY_SEVENTH, "thirty_eighth": thirty_eighth.THIRTY_EIGHTH,
    "thirty_ninth": thirty_ninth.THIRTY_NINTH,
    "thirty_fifth": thirty_fifth.THIRTY_FIFTH, "thirty_sixth": thirty_sixth.THIRTY_SIXTH,
    "fourth": fourth.FOURTH, "fifth": fifth.FIFTH,
    "sixth": (
        *sixth_bench.SIXTH_BENCH, *sixth_wrists.SIXTH_WRISTS, *sixth_robots.SIXTH_ROBOTS
    ),
    "eighth": eighth.EIGHTH, "ninth": ninth.NINTH,
    "eleventh": eleventh.ELEVENTH,
    "twelfth": (*twelfth_bench.TWELFTH_BENCH, *twelfth_robots.TWELFTH_ROBOTS),
    "thirteenth": (
        *thirteenth_bench.THIRTEENTH_BENCH, *thirteenth_robots.THIRTEENTH_ROBOTS
    ),
    "fourteenth": (
        *fourteenth_bench.FOURTEENTH_BENCH, *fourteenth_robots.FOURTEENTH_ROBOTS
    ),
    "tenth": (*tenth_bench.TENTH_BENCH, *tenth_robots.TENTH_ROBOTS),
    "seventh": (
        *seventh_bench.SEVENTH_BENCH, *seventh_wrists.SEVENTH_WRISTS,
        *seventh_robots.SEVENTH_ROBOTS,
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("corpus", CORPORA)
def test_the_whole_corpus(corpus: str, run: Run, tmp_path: Path) -> None:
    found = {
        shape.__name__: trial(shape, tmp_path / shape.__name__, run) for shape in CORPORA[corpus]
    }
    for kind in ("calibration", "next step"):
        count = sum(one.outcome == kind for one in found.values())
        print(f"{corpus}: {count} of {len(found)} to a {kind}")  # noqa: T201 - the study's answer
    left = {name: one.outcome for name, one in found.items() if not one.good}
    assert left.keys() == NOT_READ.get(corpus, set()), left
    assert not any(one.wrong for one in found.values())
