"""From saved results to a folder with the report: figures, tables, and the page last."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import MappingProxyType

from fpnav.errors import FpnavError
from fpnav.evaluation.sheets import query_sheet
from fpnav.publish import publish_bytes
from fpnav.report.context import Picture, page_context
from fpnav.report.document import as_json, document
from fpnav.report.entry import Entry, entries_of
from fpnav.report.figures.style import Drawing, as_png, as_svg, styled
from fpnav.report.figures.table import COMPARISONS, PLOTS
from fpnav.report.looks import Looks, looks_of
from fpnav.report.page import render
from fpnav.report.sheets import metrics_sheet
from fpnav.store.tables import Result

PAGE = "index.html"

Advance = Callable[[int], None]


def write_report(
    results: Sequence[tuple[str, Result]],
    folder: Path,
    advance: Advance = lambda done: None,
    chosen_on: tuple[str, Result] | None = None,
    logs: Sequence[Path] = (),
) -> list[Entry]:
    """Write the report of named results into a folder, which is made if missing.

    ``report.json``, ``metrics.csv``, per result ``NAME-queries.csv`` and ``NAME-FIGURE.svg`` and
    ``.png``, and ``index.html``, published last. The same results give the same bytes.
    ``chosen_on`` : name and result of the run whose thresholds are carried over. ``logs`` : logs
    the results were made from; frames of the listed matches are shown, and written as
    ``NAME-query-N.png``.

    Returns
    -------
    The evaluated entries, in order.

    Raises
    ------
    FpnavError
        There is no result, a truth does not fit, a log is another one or cannot be read, or the
        folder cannot be written.
    """
    entries = entries_of(results, chosen_on)
    return write_entries(entries, folder, advance, looks_of(entries, logs))


def write_entries(
    entries: Sequence[Entry],
    folder: Path,
    advance: Advance = lambda done: None,
    looks: Looks = MappingProxyType({}),
) -> list[Entry]:
    """The same for entries that are evaluated already; ``advance`` is told of each one done."""
    if not entries:
        raise FpnavError("no result to report on")
    make_folder(folder)
    pictures: dict[str, list[Picture]] = {}
    for entry in entries:
        pictures[entry.slug] = list(_pictures(entry))
        publish_pictures(folder, pictures[entry.slug])
        for look in looks.get(entry.slug, {}).values():
            publish_bytes(folder / f"{look.name}.png", look.png)
        if entry.evaluation is not None:
            publish_bytes(folder / f"{entry.slug}-queries.csv", query_sheet(entry.evaluation))
        advance(1)
    compared = list(_compared(entries)) if len(entries) > 1 else []
    publish_pictures(folder, compared)
    publish_bytes(folder / "metrics.csv", metrics_sheet(entries))
    publish_bytes(folder / "report.json", as_json(document(entries)))
    publish_bytes(folder / PAGE, render(page_context(entries, pictures, compared, looks)))
    return list(entries)


def make_folder(folder: Path) -> None:
    """Make a report's folder; raises FpnavError where it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FpnavError(f"{folder}: cannot be made a folder: {error.strerror}") from error


def _pictures(entry: Entry) -> Iterator[Picture]:
    for name, plot in PLOTS.items():
        with styled():
            drawing = plot.draw(entry)
        if drawing is not None:
            yield picture_of(f"{entry.slug}-{name}", plot.title, plot.caption, drawing)


def _compared(entries: Sequence[Entry]) -> Iterator[Picture]:
    for name, comparison in COMPARISONS.items():
        with styled():
            drawing = comparison.draw(entries)
        if drawing is not None:
            yield picture_of(name, comparison.title, comparison.caption, drawing)


def picture_of(name: str, title: str, caption: str, drawing: Drawing) -> Picture:
    """A drawing as it is published."""
    svg, png = as_svg(drawing.figure), as_png(drawing.figure)
    shape = drawing.wide, drawing.whole
    caption = f"{caption} {drawing.note}".rstrip()
    return Picture(name, title, caption, drawing.alt, *shape, svg, png)


def publish_pictures(folder: Path, pictures: Sequence[Picture]) -> None:
    """Write each picture as SVG and PNG."""
    for picture in pictures:
        publish_bytes(folder / f"{picture.name}.svg", picture.svg)
        publish_bytes(folder / f"{picture.name}.png", picture.png)
