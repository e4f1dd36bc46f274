"""Progress is for people at a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

from fpnav.cli.progress import progress, set_quiet


@pytest.fixture(autouse=True)
def loud() -> Iterator[None]:
    yield
    set_quiet(False)


def run() -> int:
    done = 0
    with progress("extract", 3) as advance:
        for _ in range(3):
            advance(1)
            done += 1
    return done


def test_without_a_terminal_nothing_is_shown(capfd: pytest.CaptureFixture[str]) -> None:
    assert run() == 3
    assert capfd.readouterr() == ("", "")


def test_a_terminal_sees_a_bar_on_stderr_unless_it_asked_for_quiet(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    run()
    out, err = capsys.readouterr()
    assert out == ""
    assert "extract" in err
    set_quiet(True)
    run()
    assert capsys.readouterr() == ("", "")
