"""A report written once for all tests that look at it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from helpers.results import header, office_run, revisit_run

from fpnav.report.write import write_report
from fpnav.store.tables import Result

HOSTILE = '"><img src=x onerror=alert(1)><script>$$\\frac{1}{0</script>'


def hostile_office() -> Result:
    """A map result whose every name from outside tries to break out."""
    facts = header("smooth", synthetic=True, system=HOSTILE, preset="=cmd()")
    facts["sources"] = [{"name": HOSTILE, "sha256": "ab" * 32, "bytes": 1}]
    topic = {"topic": HOSTILE, "in_file": 9, "used": 7, "skipped": {HOSTILE: 2}, "unread": 0}
    facts["ledger"] = [{"inputs": [{"name": HOSTILE}], "topics": [topic]}]
    run = office_run("smooth", step_m=1.5)
    run.queries["label"] = b"=HYPERLINK(1)"
    strips = tuple(f"$<b>{strip[:8]}" for strip in run.view.strips)
    return replace(run, header=facts, view=replace(run.view, strips=strips))


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of a hostile map result and a recognition of the same name."""
    target = tmp_path_factory.mktemp("reports") / "new" / "report"
    write_report([(f"_{HOSTILE}", hostile_office()), (f"_{HOSTILE}", revisit_run())], target)
    return target
