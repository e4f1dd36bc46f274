"""The real command line, run in this process."""

from __future__ import annotations

import signal
from dataclasses import dataclass
from pathlib import Path

import pytest

from fpnav.cli.main import main


@dataclass(frozen=True)
class Outcome:
    """What a command said and how it ended."""

    code: int
    out: str
    err: str


def run(capsys: pytest.CaptureFixture[str], *words: str | Path) -> Outcome:
    """Run ``fpnav WORDS``; signal handlers are put back."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    try:
        with pytest.raises(SystemExit) as left:
            main([str(word) for word in words])
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    said = capsys.readouterr()
    return Outcome(int(left.value.code or 0), said.out, said.err)
