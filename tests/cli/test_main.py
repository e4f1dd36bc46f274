"""Errors and signals become exit codes, as make and the shell want them."""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from helpers import misbehaving
from helpers.faults import leftovers

from fpnav import __version__
from fpnav.cli import main
from fpnav.errors import (
    FpnavError,
    GateError,
    LogError,
    LossError,
    StoreError,
    TruthError,
    UsageError,
)
from fpnav.experiments.registry import STUDIES
from fpnav.navigation.registry import POLICIES
from fpnav.sim.catalogue import WORLDS

SCRIPT = [sys.executable, misbehaving.__file__]
HEAVY = ("numpy", "cv2", "h5py", "numba", "networkx", "matplotlib", "mcap", "rosbags", "rich",
         "jinja2", "scipy", "trimesh", "msgspec", "dask", "zstandard", "lz4")  # fmt: skip


def spawn(*arguments: str, **options: Any) -> subprocess.Popen[bytes]:
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.Popen([*SCRIPT, *arguments], env=environment(), **options)


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(Path(misbehaving.__file__).parents[1])}


def ended(process: subprocess.Popen[bytes], within_s: float = 20.0) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=within_s)
    return process.returncode, (out or b"").decode(), (err or b"").decode()


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[object], int]]:
    """Run a command that raises or returns something through the entry point, in process."""
    monkeypatch.setattr(main, "COMMANDS", dict(main.COMMANDS))

    def run(outcome: object) -> int:
        def callback(_: str) -> object:
            if isinstance(outcome, BaseException):
                raise outcome
            return outcome

        misbehaving.install("outcome", callback)
        return main._run(["outcome"])

    yield run
    sys.modules.pop("fpnav.cli.outcome", None)


@pytest.mark.parametrize(
    ("outcome", "code"),
    [
        (None, 0),
        (0, 0),
        (3, 3),
        (FpnavError("said"), 1),
        (LogError("said"), 1),
        (StoreError("said"), 1),
        (TruthError("said"), 1),
        (UsageError("said"), 2),
        (LossError("said"), 3),
        (GateError("said"), 4),
        (MemoryError(), 1),
        (PermissionError(13, "Permission denied", "said"), 1),
        (OSError("said"), 1),
        (click.UsageError("said"), 2),
        (click.BadParameter("said"), 2),
        (click.FileError("said"), 2),
        (ZeroDivisionError("said"), 70),
        (AssertionError("said"), 70),
    ],
    ids=repr,
)
def test_every_outcome_has_its_exit_code(
    command: Callable[[object], int],
    capsys: pytest.CaptureFixture[str],
    outcome: object,
    code: int,
) -> None:
    assert command(outcome) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert (err == "") == (code == 0 or outcome == 3)


def test_a_known_error_is_one_line(
    command: Callable[[object], int], capsys: pytest.CaptureFixture[str]
) -> None:
    command(LogError("drive.mcap: cut at byte 7"))
    assert capsys.readouterr().err == "fpnav: error: drive.mcap: cut at byte 7\n"
    command(FileNotFoundError(2, "No such file or directory", "x.mcap"))
    assert capsys.readouterr().err == "fpnav: error: x.mcap: No such file or directory\n"


def test_a_bug_shows_its_traceback_and_says_what_it_is(
    command: Callable[[object], int], capsys: pytest.CaptureFixture[str]
) -> None:
    command(ZeroDivisionError("no one thought of this"))
    err = capsys.readouterr().err
    assert "Traceback (most recent call last)" in err
    assert "ZeroDivisionError: no one thought of this" in err
    assert err.endswith(
        f"fpnav {__version__}: this is a bug; please report it with the lines above\n"
    )


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("\x1b[31mred\x07", r"\x1b[31mred\x07"),
        ("two\nlines\r\ttab", r"two\nlines\r\ttab"),
        ("\u202egnp.exe", r"\u202egnp.exe"),
        ("\u2066x\u2069\u200e", r"\u2066x\u2069\u200e"),
        ("\x9b31m", r"\x9b31m"),
        (os.fsdecode(b"\xff.mcap"), r"\udcff.mcap"),
        ("Küche →", "Küche →"),
    ],
)
def test_control_characters_are_shown_and_not_obeyed(
    command: Callable[[object], int], capsys: pytest.CaptureFixture[str], name: str, shown: str
) -> None:
    command(LogError(f"{name}: damaged"))
    assert capsys.readouterr().err == f"fpnav: error: {shown}: damaged\n"


def test_an_unknown_command_is_answered_with_the_nearest(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main._run(["ingets"]) == 2
    assert "no command 'ingets'; did you mean 'ingest'?" in capsys.readouterr().err
    assert main._run(["zzz"]) == 2
    assert capsys.readouterr().err == "fpnav: error: no command 'zzz' (see fpnav --help)\n"
    assert main._run(["\x1b[31m"]) == 2
    assert "\x1b" not in capsys.readouterr().err


def test_help_and_version_go_to_stdout_and_nothing_at_all_is_a_usage_error(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main._run(["--help"]) == main._run(["-h"]) == 0
    out = capsys.readouterr().out
    for name, line in main.COMMANDS.items():
        assert name in out
        assert line[:40] in out
    assert main._run(["--version"]) == 0
    assert __version__ in capsys.readouterr().out
    assert main._run([]) == 2
    assert "Commands:" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "named", "help_of"),
    [
        (["--nonsense"], "--nonsense", "fpnav"),
        (["report"], "RESULT.h5", "fpnav report"),
        (["localize", "m.h5", "l.mcap", "--method", "guess", "-o", "o"], "guess", "fpnav localize"),
    ],
)
def test_a_wrong_command_line_is_answered_in_one_line(
    line: list[str], named: str, help_of: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main._run(line) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert named in err
    assert re.fullmatch(rf"fpnav: error: .+ \(see {help_of} --help\)\n", err)


@pytest.mark.parametrize(
    ("name", "known"), [("simulate", WORLDS), ("reproduce", STUDIES), ("navigate", POLICIES)]
)
def test_help_names_every_world_paper_and_policy(
    name: str, known: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main._run([name, "--help"]) == 0
    words = set(re.findall(r"[\w-]+", capsys.readouterr().out))
    assert set(known) <= words


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from fpnav.cli.main import main\n"
        "try:\n    main(['--help'])\n"
        "except SystemExit as leave:\n    print(leave.code, file=sys.stderr)\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert done.stderr.splitlines() == ["0", "[]"]
    assert "Commands:" in done.stdout


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_process_by_that_signal_after_cleaning_up(
    tmp_path: Path, number: signal.Signals
) -> None:
    target = tmp_path / "map.h5"
    target.write_bytes(b"old")
    process = spawn("publish", str(target))
    assert process.stdout is not None
    process.stdout.readline()
    assert leftovers(tmp_path) != []
    process.send_signal(number)
    code, _, err = ended(process, within_s=5.0)
    assert code == -number
    assert err == ""
    assert target.read_bytes() == b"old"
    assert leftovers(tmp_path) == []


def test_a_second_signal_ends_the_process_at_once() -> None:
    process = spawn("linger")
    assert process.stdout is not None
    process.stdout.readline()
    for number in (signal.SIGINT, signal.SIGINT):
        process.send_signal(number)
        time.sleep(0.3)
    assert ended(process, within_s=2.0)[0] == -signal.SIGINT


def test_a_hangup_that_was_ignored_stays_ignored(tmp_path: Path) -> None:
    process = spawn(
        "publish", str(tmp_path / "x"),
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
    )  # fmt: skip
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    assert process.poll() is None
    process.terminate()
    assert ended(process)[0] == -signal.SIGTERM


def test_a_signal_that_a_destructor_swallows_is_raised_again() -> None:
    process = spawn("swallow")
    assert process.stdout is not None
    process.stdout.readline()
    process.terminate()
    code, _, err = ended(process, within_s=5.0)
    assert code == -signal.SIGTERM
    assert err == ""


def test_signals_are_not_lost_while_hdf5_is_written(tmp_path: Path) -> None:
    _store_rounds(tmp_path, 6)


@pytest.mark.slow
def test_of_many_signals_none_is_lost_while_hdf5_is_written(tmp_path: Path) -> None:
    _store_rounds(tmp_path, 30)


def _store_rounds(folder: Path, rounds: int) -> None:
    rng = random.Random(4)
    for number in range(rounds):
        process = spawn("store", str(folder / "x.h5"))
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(0.05 * rng.random())
        wanted = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)[number % 3]
        process.send_signal(wanted)
        assert ended(process)[0] == -wanted


def test_a_reader_that_leaves_early_is_success() -> None:
    process = spawn("shout")
    assert process.stdout is not None
    assert process.stdout.readline() == b"line 0\n"
    process.stdout.close()
    process.stdout = None
    assert ended(process) == (0, "", "")


def test_a_reader_that_left_before_the_only_line_is_success() -> None:
    process = spawn("whisper", stdin=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    process.stdout = None
    assert ended(process) == (0, "", "")


def test_a_broken_pipe_that_is_not_the_readers_is_an_error() -> None:
    code, _, err = ended(spawn("broken"))
    assert code != 0
    assert "Traceback" not in err


def test_a_full_device_is_one_line_and_a_failure() -> None:
    with open("/dev/full", "wb") as full:
        code, _, err = ended(spawn("whisper", stdin=subprocess.DEVNULL, stdout=full))
    assert code == 1
    assert err.count("\n") == 1
    assert "No space left on device" in err


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_standard_streams_change_no_exit_code(closed: str) -> None:
    for arguments, expected in (("--version", 0), ("fail message", 1)):
        line = " ".join([*SCRIPT, arguments, closed])
        done = subprocess.run(["sh", "-c", line], env=environment(), capture_output=True)
        assert done.returncode == expected
        assert b"Traceback" not in done.stderr
