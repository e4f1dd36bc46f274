"""What the page is told: provenance without repetition, losses, the best of a row."""

from __future__ import annotations

from dataclasses import replace

from helpers.results import header, recognition

from fpnav.report.context import page_context
from fpnav.report.entry import Entry, entries_of
from fpnav.values import Metric

TOPIC = {"in_file": 9, "used": 7, "skipped": {"E201": 2}, "unread": 0}


def section(**facts: object) -> dict[str, object]:
    result = replace(recognition([[0.9]], pairs={0: [0]}), header=header("recognize", **facts))
    context = page_context(entries_of([("run", result)]), {}, [])
    found: dict[str, object] = context["entries"][0]
    return found


def test_numbered_topics_that_fared_alike_share_a_row() -> None:
    topics = [{**TOPIC, "topic": f"/sonar/{i}"} for i in range(24)]
    topics += [{**TOPIC, "topic": "/scan"}, {**TOPIC, "topic": "/sonar/24", "used": 6}]
    ledger = [{"inputs": [{"name": "drive.mcap"}], "topics": topics}]
    rows = section(ledger=ledger)["ledger"]
    assert isinstance(rows, list)
    assert [row["topic"] for row in rows] == ["/sonar/0 and 23 like it", "/scan", "/sonar/24"]
    assert rows[0]["skipped"] == [("E201", "2")]
    assert rows[0]["log"] == "drive.mcap"


def test_the_chain_names_each_file_once() -> None:
    signatures = {"format": "fpnav/signatures", "sources": [{"name": "a.mcap", "bytes": 12345}]}
    mapped = {"format": "fpnav/map", "chain": [signatures]}
    chain = section(chain=[mapped, signatures])["chain"]
    assert isinstance(chain, list)
    assert [link["format"] for link in chain] == ["result", "map", "signatures"]
    assert chain[2]["sources"][0]["bytes"] == "12\u202f345"


def test_a_header_without_ledger_or_protocol_is_no_error() -> None:
    found = section(ledger=None, protocol={}, sources=[])
    assert found["ledger"] == []
    assert found["protocol"] == []


def entry(name: str, **values: float) -> Entry:
    return Entry(name, name, header(), {n: Metric(n, v, 1, 2) for n, v in values.items()})


def test_the_best_of_a_row_is_marked_where_better_has_a_direction() -> None:
    entries = [
        entry("a", recall_at_1=0.8, position_error_median_m=0.5, places=20),
        entry("b", recall_at_1=0.6, position_error_median_m=0.2, places=30),
    ]
    rows = {row["name"]: row["best"] for row in page_context(entries, {}, [])["table"]}
    assert rows["recall_at_1"] == [True, False]
    assert rows["position_error_median_m"] == [False, True]
    assert rows["places"] == [False, False]


def test_equal_figures_and_lonely_ones_are_not_marked() -> None:
    entries = [entry("a", recall_at_1=0.8, ece=0.1), entry("b", recall_at_1=0.8)]
    rows = {row["name"]: row["best"] for row in page_context(entries, {}, [])["table"]}
    assert rows == {"recall_at_1": [False, False], "ece": [False, False]}


def test_figures_the_table_does_not_know_are_shown_under_their_own_name() -> None:
    context = page_context([entry("a", nearest_wins=0.9)], {}, [])
    assert [row["title"] for row in context["table"]] == ["nearest_wins"]
    assert context["entries"][0]["summary"] == "Several runs taken together."
