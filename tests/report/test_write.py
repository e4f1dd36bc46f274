"""The report of a result: what is written, that it is whole, safe, and the same every time."""

from __future__ import annotations

import base64
import csv
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest
from helpers.results import nowhere, recognition

from fpnav import __version__
from fpnav.errors import FpnavError
from fpnav.evaluation.sheets import safe
from fpnav.report.document import as_json
from fpnav.report.write import write_report
from fpnav.store.tables import Accepted, Result

ALLOWED = """
    html head meta title style body header p h1 h2 h3 h4 nav ul li a main div table thead tr th br
    tbody td span figure img figcaption section strong dl dt dd code details summary ol footer
"""


class Page(HTMLParser):
    """Every element and attribute of a page, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="session")
def page(folder: Path) -> Page:
    return Page((folder / "index.html").read_text(encoding="utf-8"))


def test_the_page_holds_no_element_that_the_template_does_not(page: Page) -> None:
    assert {tag for tag, _ in page.elements} <= set(ALLOWED.split())
    assert not any(name.startswith("on") for _, attrs in page.elements for name in attrs)


def test_names_from_outside_are_shown_as_they_are(page: Page) -> None:
    assert '"><img src=x onerror=alert(1)><script>$$\\frac{1}{0</script>' in page.text


def test_the_page_fetches_and_runs_nothing(page: Page) -> None:
    policies = [m["content"] for m in page.all("meta") if m.get("http-equiv")]
    assert policies == ["default-src 'none'; style-src 'unsafe-inline'; img-src data:"]
    assert all(str(image["src"]).startswith("data:image/") for image in page.all("img"))
    assert all(str(link["href"]).startswith("#") for link in page.all("a"))
    assert "url(" not in page.text
    assert "@import" not in page.text


def test_every_picture_says_in_words_what_it_shows(page: Page) -> None:
    alts = [str(image["alt"]) for image in page.all("img")]
    assert len(alts) >= 15
    assert all(len(alt) > 20 for alt in alts)


def test_links_within_the_page_lead_somewhere(page: Page) -> None:
    ids = [attrs["id"] for _, attrs in page.elements if "id" in attrs]
    assert len(set(ids)) == len(ids)
    assert {str(link["href"])[1:] for link in page.all("a")} <= set(ids)


def test_the_page_says_what_is_simulated_absent_or_not_causal(page: Page) -> None:
    assert "made by a simulator" in page.text
    assert "Answers use what comes after the query as well." in page.text
    assert "made without a map of places" in page.text
    assert "sha256 " + "ab" * 32 in page.text


def test_every_figure_is_published_as_svg_and_png(folder: Path) -> None:
    svgs = sorted(path.stem for path in folder.glob("*.svg"))
    assert svgs == sorted(path.stem for path in folder.glob("*.png"))
    assert sum(name.endswith("-map") for name in svgs) == 2
    assert "compare-precision-recall" in svgs
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in folder.glob("*.png"))


def test_every_svg_is_well_formed_and_undated(folder: Path) -> None:
    for path in folder.glob("*.svg"):
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
        tags = {element.tag.rsplit("}", 1)[-1] for element in root.iter()}
        assert "script" not in tags
        assert "date" not in tags


def test_file_names_are_plain(folder: Path) -> None:
    for path in folder.iterdir():
        assert re.fullmatch(r"[A-Za-z0-9._-]+", path.name)
        assert not path.name.startswith(".")


def test_report_json_has_the_shape_of_the_commands(folder: Path) -> None:
    text = (folder / "report.json").read_text(encoding="utf-8")
    report = json.loads(text, parse_constant=pytest.fail)
    assert report["fpnav"] == __version__
    names = [result["name"] for result in report["results"]]
    assert len(names) == len(set(names)) == 2
    for result in report["results"]:
        assert {"name", "system", "preset", "method", "protocol", "source", "metrics"} <= set(
            result
        )
        assert isinstance(result["source"], dict)
        for metric in result["metrics"].values():
            assert set(metric) == {"value", "n", "of", "unit", "low", "high"}
        assert not set(result["metrics"]) & set(result["absent"])
    assert report["results"][1]["protocol"]["exclude_path_m"] == 15.0


def test_figures_that_are_not_finite_are_a_bug_not_invalid_json() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        as_json({"value": float("nan")})


def test_the_query_sheet_has_a_row_per_query_and_no_formula(folder: Path) -> None:
    sheets = sorted(folder.glob("*-queries.csv"))
    assert len(sheets) == 2
    rows = [row for sheet in sheets for row in csv.DictReader(sheet.read_text().splitlines())]
    assert {row["label"] for row in rows} == {"'=HYPERLINK(1)", ""}
    assert {row["outcome"] for row in rows} <= {"right", "wrong", "not localized", "not judged"}


def test_the_metrics_sheet_has_every_metric_of_every_result(folder: Path) -> None:
    with (folder / "metrics.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    report = json.loads((folder / "report.json").read_text())
    expected = sum(len(r["metrics"]) + len(r["absent"]) for r in report["results"])
    assert len(rows) == expected
    assert all(bool(row["value"]) != bool(row["absent"]) for row in rows)


@pytest.mark.parametrize(
    ("cell", "expected"),
    [
        ("=1+1", "'=1+1"),
        ("+1", "'+1"),
        ("-cmd", "'-cmd"),
        ("@sum", "'@sum"),
        ("\t=1", "'\t=1"),
        ("plain", "plain"),
        (-1.5, "-1.5"),
        (-3, -3),
        (float("nan"), ""),
        (True, 1),
    ],
)
def test_cells_that_could_be_formulas_get_a_quote_and_numbers_none(
    cell: object, expected: object
) -> None:
    assert safe(cell) == expected


def test_the_same_results_give_the_same_bytes(tmp_path: Path) -> None:
    for name in ("first", "second"):
        write_report([("run", small_run())], tmp_path / name)
    first, second = tmp_path / "first", tmp_path / "second"
    names = sorted(path.name for path in first.iterdir())
    assert names == sorted(path.name for path in second.iterdir())
    for name in names:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name


def small_run() -> Result:
    return recognition([[0.9, 0.2], [0.3, 0.8], [0.7, 0.6]], pairs={0: [0], 1: [1], 2: [1]})


def test_no_path_of_the_machine_stands_in_any_file(folder: Path) -> None:
    needle = str(folder.parent.parent).encode()
    for path in folder.iterdir():
        data = path.read_bytes()
        for part in re.findall(rb"base64,([A-Za-z0-9+/=]+)", data):
            data += base64.b64decode(part)
        assert needle not in data, path.name


def test_a_result_without_truth_poses_or_queries_still_gives_a_page(tmp_path: Path) -> None:
    blind = recognition([[0.5, 0.4]], queries=nowhere(1), truth=Accepted("none", "none"))
    empty = recognition([[0.5]], pairs={0: []})
    write_report([("blind", blind), ("empty", empty)], tmp_path)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "no ground truth" in text
    assert "no query has a match in truth" in text


def test_nothing_to_report_on_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FpnavError, match="no result"):
        write_report([], tmp_path)


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    target = tmp_path / "taken"
    target.write_text("mine")
    with pytest.raises(FpnavError, match="cannot be made a folder"):
        write_report([("run", small_run())], target)
    assert target.read_text() == "mine"
