"""Every row of groups A to D of the fault catalogue has a test, here or in the file named."""

from __future__ import annotations

import ast
import re
import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from helpers import mcaps
from helpers import robot_logs as robot
from helpers.commands import run
from helpers.logs import jpeg, log_bytes
from mcap.writer import Writer
from rosbags.typesys.store import Typestore

from fpnav.errors import LogError
from fpnav.logs import images, messages
from fpnav.logs.codecs import ChannelFacts
from fpnav.logs.encodings import codec_for
from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.ledger import Ledger
from fpnav.logs.reader import LogFile

ROWS = {
    "A1": "test_faults::test_what_is_no_log_is_refused_in_one_line",
    "A2": "test_faults::test_what_is_no_log_is_refused_in_one_line",
    "A3": "test_faults::test_a_cut_log_is_over_budget_unless_allowed",
    "A4": "test_faults::test_a_cut_log_is_over_budget_unless_allowed",
    "A5": "test_faults::test_logs_without_index_or_chunks_read_as_those_with",
    "A6": "test_faults::test_logs_without_index_or_chunks_read_as_those_with",
    "A7": "test_faults::test_logs_without_index_or_chunks_read_as_those_with",
    "A8": "test_faults::test_logs_without_index_or_chunks_read_as_those_with",
    "A9": "test_faults::test_logs_without_index_or_chunks_read_as_those_with",
    "A10": "test_faults::test_a10_lost_chunks_are_counted_with_their_topics",
    "A11": "test_faults::test_a11_logs_without_crc_are_unverified",
    "A12": "test_reader::test_a_wrong_summary_crc_is_noted_and_the_summary_not_used",
    "A13": "test_reader::test_a_wrong_data_crc_matters_where_nothing_else_covers_the_messages",
    "A14": "test_reader::test_attachments_are_sought_over_and_read_when_asked_for",
    "A15": "test_reader::test_a_record_longer_than_the_file_ends_the_data",
    "A16": "test_faults::test_a16_a_record_over_the_limit_is_skipped_and_what_follows_is_read",
    "A17": "test_reader::test_a_chunk_that_lies_is_skipped_with_its_code",
    "A18": "test_reader::test_a_chunk_that_lies_is_skipped_with_its_code",
    "A19": "test_reader::test_a_chunk_that_lies_is_skipped_with_its_code",
    "A20": "test_faults::test_a_cut_log_is_over_budget_unless_allowed",
    "A21": "test_faults::test_a21_messages_of_unknown_channels_and_schemas_are_counted",
    "A22": "test_faults::test_a_channel_defined_twice_spoils_its_topic_alone",
    "A23": "test_faults::test_a23_channels_of_one_topic_are_read_together_in_time_order",
    "A24": "test_faults::test_a24_wrong_statistics_are_a_note",
    "A25": "test_fast::test_a_chunk_whose_index_is_wrong_is_walked",
    "A26": "test_reader::test_private_and_unknown_records_and_padding_are_skipped",
    "A27": "test_faults::test_a27_files_of_one_recording_are_merged_in_order_without_duplicates",
    "A28": "test_faults::test_a28_the_same_file_twice_is_a_usage_error",
    "A29": "test_reader::test_a_file_that_grows_while_it_is_read_is_refused",
    "A30": "test_catalogue::test_a30_a_file_that_shrinks_while_it_is_read_is_refused",
    "A31": "test_faults::test_a31_a_pipe_is_a_usage_error",
    "A32": "test_catalogue::test_a32_an_attachments_name_is_shown_and_never_used",
    "A33": "test_faults::test_a33_odd_topic_names_do_no_harm",
    "B1": "test_faults::test_b1_messages_out_of_log_time_order_are_put_in_order",
    "B2": "test_faults::test_b2_a_late_message_is_skipped_and_counted",
    "B3": "test_faults::test_b3_equal_stamps_keep_their_order_and_are_noted",
    "B4": "test_faults::test_a_clock_that_jumps_back_makes_the_log_go_by_log_time",
    "B5": "test_faults::test_b5_exact_duplicates_are_dropped_and_same_stamps_with_other_bytes_kept",
    "B6": "test_faults::test_b6_a_few_zero_stamps_are_skipped",
    "B7": "test_checks::test_each_fault_is_found_by_its_check",
    "B8": "test_faults::test_b8_impossible_stamps_are_skipped",
    "B9": "test_faults::test_b9_streams_that_never_meet_are_refused_with_both_ranges",
    "B10": "test_faults::test_b10_gaps_are_noted",
    "B11": "test_faults::test_a_clock_that_jumps_back_makes_the_log_go_by_log_time",
    "B12": "test_faults::test_b12_nanoseconds_survive",
    "B13": "test_faults::test_b13_one_message_is_enough_and_none_is_refused",
    "C1": "test_encodings::test_a_channel_that_cannot_be_decoded_says_why",
    "C2": "test_encodings::test_a_known_type_without_a_definition_is_taken_for_the_standard_one",
    "C3": "test_encodings::test_nested_definitions_may_be_left_out",
    "C4": "test_encodings::test_every_role_reads_the_same",
    "C5": "test_encodings::test_a_channel_that_cannot_be_decoded_says_why",
    "C6": "test_encodings::test_a_channel_that_cannot_be_decoded_says_why",
    "C7": "test_encodings::test_a_channel_that_cannot_be_decoded_says_why",
    "C8": "test_encodings::test_a_channel_that_cannot_be_decoded_says_why",
    "C9": "test_encodings::test_other_encapsulations_are_never_guessed",
    "C10": "test_encodings::test_a_payload_cut_anywhere_is_refused",
    "C11": "test_encodings::test_trailing_bytes_beyond_padding_are_another_type",
    "C12": "test_encodings::test_a_sequence_longer_than_its_payload_is_refused_before_it_is_made",
    "C13": "test_encodings::test_a_frame_name_that_is_not_text_is_mended",
    "C14": "test_faults::test_a_channel_defined_twice_spoils_its_topic_alone",
    "C15": "test_catalogue::test_c15_a_definition_in_a_ros1_log_is_never_compiled",
    "C16": "test_encodings::test_json_that_is_none_or_lacks_fields_is_refused",
    "D1": "test_images::test_fields_that_contradict_are_refused",
    "D2": "test_images::test_fields_that_contradict_are_refused",
    "D3": "test_images::test_fields_that_contradict_are_refused",
    "D4": "test_images::test_measurements_are_stretched_to_grey",
    "D5": "test_images::test_a_painted_target_keeps_its_colours",
    "D6": "test_catalogue::test_d6_the_bytes_of_an_image_decide_and_its_format_is_a_hint",
    "D7": "test_catalogue::test_d7_compressed_depth_is_named_and_not_taken_for_a_picture",
    "D8": "test_catalogue::test_d8_video_is_said_to_be_not_used",
    "D9": "test_images::test_a_jpeg_needs_its_end_marker_and_may_have_padding_behind_it",
    "D10": "test_faults::test_a10_lost_chunks_are_counted_with_their_topics",
    "D11": "test_images::test_a_bomb_is_refused_by_its_header",
    "D12": "test_checks::test_each_fault_is_found_by_its_check",
    "D13": "test_catalogue::test_d13_images_of_one_shade_are_told",
    "D14": "test_images::test_decoders_keep_their_remarks_to_themselves",
    "D15": "test_images::test_other_formats_are_refused_with_their_first_bytes",
    "D16": "test_catalogue::test_d16_a_camera_is_not_turned_by_its_exif",
}


def test_every_row_has_a_test() -> None:
    counts = {"A": 33, "B": 13, "C": 16, "D": 16}
    assert set(ROWS) == {f"{group}{i + 1}" for group, n in counts.items() for i in range(n)}


@pytest.mark.parametrize("row", ROWS)
def test_the_test_of_a_row_exists(row: str) -> None:
    module, _, name = ROWS[row].partition("::")
    tree = ast.parse((Path(__file__).parent / f"{module}.py").read_text())
    assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_a30_a_file_that_shrinks_while_it_is_read_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(mcaps.plain_log("none", messages=100, size=80_000, chunk_size=50_000))
    with LogFile(path) as file:
        deliveries = file.scan(Ledger())
        next(deliveries)
        with open(path, "rb+") as handle:
            handle.truncate(200_000)
        with pytest.raises(LogError, match="E120 changed while it was read"):
            list(deliveries)


@pytest.mark.parametrize("name", ["../../etc/x", "/etc/x", "a\0b", "\x1b[31mred"])
def test_a32_an_attachments_name_is_shown_and_never_used(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.mcap"
    with open(path, "wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.add_attachment(0, 0, name, "text/plain", b"contents")
        writer.finish()
    told = run(capsys, "info", path)
    shown = name.replace("\0", r"\x00").replace("\x1b", r"\x1b")
    assert f"attachment {shown}, 8 B" in told.out
    assert [one.name for one in tmp_path.iterdir()] == ["a.mcap"]


def test_c15_a_definition_in_a_ros1_log_is_never_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("a definition of a log was registered")

    messages.typestore(messages.NOETIC)  # made once, from definitions of our own
    monkeypatch.setattr(Typestore, "register", refuse)
    text = messages.definition(messages.LASER_SCAN, messages.NOETIC, 1)
    hostile = text + b"\nfloat32 __import__('os').system('true')\n"
    facts = ChannelFacts("ros1", "sensor_msgs/LaserScan", "ros1msg", hostile)
    assert re.match("E30[123]", str(codec_for(facts)))
    facts = ChannelFacts("ros1", "sensor_msgs/LaserScan", "ros1msg", text)
    assert not isinstance(codec_for(facts), str)


@pytest.mark.parametrize(
    "words", ["", "jpeg", "png", "bgr8; jpeg compressed bgr8", "yuv422; jpeg compressed mono8"]
)
def test_d6_the_bytes_of_an_image_decide_and_its_format_is_a_hint(
    words: str, tmp_path: Path
) -> None:
    sent = robot.picture(robot.at(0), "/camera/image", jpeg(), words)
    path = robot.write(tmp_path / "a.mcap", [(robot.at(0), sent)])
    ingest([path], tmp_path / "b.mcap")
    with open_log(tmp_path / "b.mcap", strict=True) as log:
        frame = next(log.frames())
    assert frame.camera is not None
    assert frame.camera.pixels.shape == (16, 32, 3)


@pytest.mark.parametrize("body", [b"\x89PNG\r\n", b"rvl"])
def test_d7_compressed_depth_is_named_and_not_taken_for_a_picture(
    body: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "16UC1; compressedDepth png"
    sent = robot.picture(robot.at(0), "/kinect/compressedDepth", bytes(12) + body, words)
    path = robot.write(tmp_path / "a.mcap", [(robot.at(0), sent)])
    done = run(capsys, "ingest", path, "-o", tmp_path / "b.mcap", "--topic",
               "camera=/kinect/compressedDepth")  # fmt: skip
    assert done.code == 3
    assert "E404" in done.err
    assert not (tmp_path / "b.mcap").exists()


def test_d8_video_is_said_to_be_not_used(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parts = [mcaps.schema(1, "foxglove.CompressedVideo", b"", "protobuf"),
             mcaps.channel(1, "/video", 1, "protobuf"), mcaps.message(1, 5, b"x")]  # fmt: skip
    (tmp_path / "a.mcap").write_bytes(mcaps.whole(*parts))
    assert "not used: foxglove.CompressedVideo" in run(capsys, "info", tmp_path / "a.mcap").out
    done = run(capsys, "ingest", tmp_path / "a.mcap", "-o", tmp_path / "b.mcap")
    assert done.code == 1
    assert "E206 no topic of a type that plays a role; the log holds foxglove.Comp" in done.err


def test_d13_images_of_one_shade_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    black = images.encode_png(np.zeros((20, 30), np.uint8))
    path = tmp_path / "a.mcap"
    path.write_bytes(
        log_bytes(lambda w: [w.image("camera", robot.at(i), black, "png") for i in range(3)])
    )
    assert "D13   camera: 3 of 3 are of one shade" in run(capsys, "check", path).out


def test_d16_a_camera_is_not_turned_by_its_exif() -> None:
    orientation = struct.pack("<HHIHH", 0x0112, 3, 1, 6, 0)
    exif = b"Exif\0\0II*\0" + struct.pack("<IH", 8, 1) + orientation + bytes(4)
    plain = jpeg()
    turned = plain[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + plain[2:]
    assert cv2.imdecode(np.frombuffer(turned, np.uint8), cv2.IMREAD_COLOR).shape == (32, 16, 3)
    assert images.encoded_size(turned) == (32, 16)
    assert images.decode_encoded(turned).shape == (16, 32, 3)
