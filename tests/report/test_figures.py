"""Figures: drawn where there is something to draw, with words that hold its numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers.results import header, nowhere, office_run, recognition, revisit_run

from fpnav.report.entry import Entry, entries_of
from fpnav.report.figures.runs import confusion_table
from fpnav.report.figures.style import Drawing, as_png, as_svg, new_figure, shown, styled
from fpnav.report.figures.table import COMPARISONS, PLOTS


@pytest.fixture(scope="module")
def entries() -> list[Entry]:
    pairs = recognition([[0.9, 0.2], [0.3, 0.8]], pairs={0: [0], 1: [1]}, queries=nowhere(2))
    return entries_of(
        [("office", office_run("match", step_m=1.0)), ("laps", revisit_run()), ("pairs", pairs)]
    )


@pytest.mark.parametrize(
    ("name", "drawn"),
    [
        ("map", ["office", "laps"]),
        ("matches", ["laps", "pairs"]),
        ("precision-recall", ["office", "laps", "pairs"]),
        ("recall", ["office", "laps", "pairs"]),
        ("tolerance", ["laps"]),
        ("confusion", ["office"]),
        ("calibration", ["office", "laps"]),
        ("belief", ["office"]),
        ("error", ["office", "laps"]),
        ("novelty", ["office"]),
        ("strips", ["office"]),
    ],
)
def test_a_figure_is_drawn_of_the_results_that_have_it(
    entries: list[Entry], name: str, drawn: list[str]
) -> None:
    with styled():
        made = {entry.name: PLOTS[name].draw(entry) for entry in entries}
    assert [entry for entry, drawing in made.items() if drawing is not None] == drawn
    assert all(len(drawing.alt) > 20 for drawing in made.values() if drawing is not None)


def test_the_letters_of_a_signature_are_explained_where_the_result_says_what_they_are() -> None:
    run = office_run("match", step_m=1.0)
    told = replace(run, header={**run.header, "summary": "corners c and edges v"})
    with styled():
        first, second = (
            PLOTS["strips"].draw(entry) for entry in entries_of([("a", run), ("b", told)])
        )
    assert first is not None
    assert second is not None
    assert (first.note, second.note) == ("", "Corners c and edges v.")


def test_walls_of_a_simulated_world_are_drawn_under_the_run() -> None:
    world = {"rooms": [], "doors": [], "changes": [], "walls": [[-1, -1, 40, -1], [-1, 9, 40, 9]]}
    run = office_run("match", step_m=1.0)
    chain = [{"format": "fpnav/map", "chain": [{"worlds": [world]}]}]
    walled = replace(run, header={**run.header, "chain": chain})
    with styled():
        texts = [
            legend_of(PLOTS["map"].draw(entry)) for entry in entries_of([("a", run), ("b", walled)])
        ]
    assert "walls" not in texts[0]
    assert "walls" in texts[1]


def legend_of(drawing: Drawing | None) -> list[str]:
    assert drawing is not None
    return [text.get_text() for text in drawing.figure.legends[0].get_texts()]


def test_a_comparison_needs_two_results_that_have_it(entries: list[Entry]) -> None:
    with styled():
        assert COMPARISONS["compare-recall"].draw(entries) is not None
        assert COMPARISONS["compare-tolerance"].draw(entries) is None


def test_words_under_a_figure_hold_its_numbers(entries: list[Entry]) -> None:
    with styled():
        drawing = PLOTS["recall"].draw(entries[2])
    assert drawing is not None
    assert drawing.alt == "Recall over the first N answers. pairs: 100 % at 1, 100 % at 2."


@pytest.mark.parametrize(
    "text", ["$$", "$\\frac{1}{0$", "/a$b$c", "_hidden", "日本", "a\nb\x1b[0m"]
)
def test_any_text_is_drawn_as_it_stands(text: str) -> None:
    with styled():
        figure, axis = new_figure()
        axis.plot([0, 1], [0, 1], label=shown(text))
        axis.set_title(shown(text))
        axis.legend()
    assert b"<svg" in as_svg(figure)
    assert as_png(figure).startswith(b"\x89PNG")


def test_settings_of_the_user_change_nothing() -> None:
    import matplotlib as mpl

    def draw() -> bytes:
        with styled():
            figure, axis = new_figure()
            axis.plot([0, 1], [0, 1])
        return as_svg(figure)

    plain = draw()
    with mpl.rc_context({"lines.linewidth": 9, "axes.facecolor": "red", "font.size": 30}):
        assert draw() == plain


def test_long_names_lose_their_middle() -> None:
    assert shown("a" * 30 + "b" * 30) == "a" * 19 + "\u2026" + "b" * 19


def test_the_confusion_counts_decisions_and_the_last_column_what_was_withheld() -> None:
    ids = np.array([4, 7])
    table = confusion_table(np.array([4, 4, 7, -1, 7]), np.array([4, 7, -1, 4, 99]), ids)
    assert table.tolist() == [[1, 1, 0], [0, 0, 2]]


def test_a_carried_threshold_is_marked_and_said_and_its_absence_too() -> None:
    pairs = {0: [0], 1: [1]}
    there = recognition(
        [[0.9, 0.2], [0.3, 0.8]], pairs=pairs, header=header("recognize", sources=[{"name": "o"}])
    )
    run = recognition([[0.5, 0.2], [0.4, 0.3]], pairs=pairs)
    with styled():
        marked, plain, refused = (
            PLOTS["precision-recall"].draw(entries_of([("run", run)], other)[0])
            for other in (("day-1", there), None, ("itself", run))
        )
    assert marked is not None
    assert plain is not None
    assert refused is not None
    said = "100 % on day-1: score 0.8 there, which 100.0 % of its best matches reach; 0.4 here, "
    assert f"{said}precision 50.0 % (1 of 2), recall 50.0 % (1 of 2)" in marked.note
    assert "threshold for 100 % on day-1" in legend_of(marked)
    assert plain.note == ""
    assert "this very run" in refused.note
    assert not any("itself" in label for label in legend_of(refused))
