"""What right and wrong matches saw: frames of the logs behind a result, beside its list."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fpnav.errors import UsageError
from fpnav.execution.sights import FrameKey, Sight, sight, sights_of
from fpnav.logs.frames import open_log
from fpnav.report.entry import entries_of
from fpnav.report.figures.match import draw_match
from fpnav.report.figures.style import styled
from fpnav.report.looks import looks_of
from fpnav.report.write import write_report
from fpnav.store.results import read_result
from fpnav.store.tables import Result


@pytest.fixture(scope="module")
def log(root: Path) -> Path:
    return root / "sample_logs" / "office_test.mcap"


@pytest.fixture(scope="module")
def result(log: Path, tmp_path_factory: pytest.TempPathFactory) -> Result:
    target = tmp_path_factory.mktemp("looks") / "run.h5"
    words = ["recognize", log, "-s", "tiny", "--step", "1", "--exclude-path", "5", "-o", target]
    subprocess.run([sys.executable, "-m", "fpnav", *map(str, words)], check=True)
    return read_result(target)


def test_frames_are_found_by_their_index_and_keep_their_order(log: Path) -> None:
    with open_log(log) as opened:
        everything = {f.reference.index: f.reference.stamp_ns for f in opened.frames()}
        picked = list(opened.at([40, 7, 7, 10**6]))
    assert [frame.reference.index for frame in picked] == [7, 40]
    assert [frame.reference.stamp_ns for frame in picked] == [everything[7], everything[40]]


def test_a_sight_is_the_frame_made_small(log: Path) -> None:
    with open_log(log) as opened:
        (frame,) = opened.at([3])
    seen = sight(frame)
    assert seen.role == "panorama"
    height, width = seen.pixels.shape[:2]
    assert 0 < height <= 160
    assert 0 < width <= 420
    assert 0 < len(seen.points_m) <= 360
    hits = frame.scan.points_m() if frame.scan is not None else np.zeros((0, 2))
    assert {tuple(point) for point in seen.points_m} <= {tuple(point) for point in hits}


def test_every_listed_match_has_its_picture_in_the_page_and_beside_it(
    log: Path, result: Result, tmp_path: Path
) -> None:
    looks = looks_of(entries_of([("run", result)]), [log])["run"]
    assert looks
    write_report([("run", result)], tmp_path / "seen", logs=[log])
    page = (tmp_path / "seen" / "index.html").read_text()
    for look in looks.values():
        assert (tmp_path / "seen" / f"{look.name}.png").read_bytes() == look.png
        assert look.uri in page
        assert look.alt in page


def test_without_logs_the_page_says_how_to_see_more(result: Result, tmp_path: Path) -> None:
    write_report([("run", result)], tmp_path)
    assert "--log LOG" in (tmp_path / "index.html").read_text()
    assert not list(tmp_path.glob("*-query-*.png"))


def test_a_log_the_result_was_not_made_from_is_refused_by_name(root: Path, result: Result) -> None:
    other = root / "sample_logs" / "office_map.mcap"
    with pytest.raises(UsageError, match=r"office_map\.mcap: no result was made from this log"):
        looks_of(entries_of([("run", result)]), [other])


def test_frames_no_log_holds_are_left_out(log: Path) -> None:
    with open_log(log) as opened:
        here, roles = opened.sha256, tuple(opened.roles)
    found = sights_of([log], {FrameKey(here, roles, 2), FrameKey("elsewhere", roles, 2)})
    assert set(found) == {FrameKey(here, roles, 2)}


def test_the_query_is_laid_where_the_result_says_it_stands() -> None:
    nothing = np.zeros((0, 0, 3), np.uint8)
    asked = Sight(nothing, "", np.array([[1.0, 0.0]]))
    answer = Sight(nothing, "", np.array([[3.0, 0.0]]))
    with styled():
        figure, said = draw_match(asked, answer, (2.0, 0.0, 0.0), "right")
    lines = figure.axes[0].get_lines()
    assert lines[0].get_xydata().tolist() == lines[2].get_xydata().tolist() == [[0.0, 3.0]]
    assert said == "scan of the query over that of the answer"


def test_an_answers_panorama_is_turned_to_the_querys_heading() -> None:
    pixels = np.zeros((1, 8, 3), np.uint8)
    pixels[0, 4] = 255
    seen = Sight(pixels, "panorama", np.zeros((0, 2)))
    with styled():
        figure, _ = draw_match(seen, seen, (0.0, 0.0, np.pi / 2), "right")
    query, answer = (axis.get_images()[0].get_array() for axis in figure.axes)
    assert query is not None
    assert answer is not None
    assert query[0, :, 0].argmax() == 4
    assert answer[0, :, 0].argmax() == 6


def test_an_image_that_is_not_at_hand_is_said_and_not_left_blank() -> None:
    seen = Sight(np.zeros((4, 4, 3), np.uint8), "camera", np.zeros((0, 2)))
    with styled():
        figure, said = draw_match(None, seen, (0.0, 0.0, np.nan), "wrong")
    assert "query: no image at hand" in {text.get_text() for text in figure.axes[0].texts}
    assert said == "image of the query left of that of the answer"
