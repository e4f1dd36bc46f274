"""The walk through the real commands: what they write, say, refuse and survive."""

from __future__ import annotations

import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from helpers.walks import write_walk

from fpnav.cli.main import COMMANDS

FPNAV = [sys.executable, "-m", "fpnav"]
FINE = ("--set", "fingerprint.theta=0.25", "--no-loops")


def fpnav(*words: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [*FPNAV, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=cwd)


def done(*words: str | Path) -> subprocess.CompletedProcess[str]:
    outcome = fpnav(*words)
    assert outcome.returncode == 0, outcome.stderr
    return outcome


def refused(*words: str | Path, code: int = 1) -> str:
    outcome = fpnav(*words)
    assert outcome.returncode == code, outcome.stderr
    assert "Traceback" not in outcome.stderr
    assert outcome.stdout == ""
    return outcome.stderr.strip()


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mapping log, a second log beside it, and the file of every stage."""
    folder = tmp_path_factory.mktemp("walk")
    write_walk(folder / "map.mcap", seed=1)
    write_walk(folder / "again.mcap", offset_m=0.1, seed=2)
    done("extract", folder / "map.mcap", "-s", "fingerprint", "-o", folder / "map.sig.h5")
    done("build-map", folder / "map.sig.h5", *FINE, "-o", folder / "map.h5")
    done("localize", folder / "map.h5", folder / "again.mcap", "-o", folder / "result.h5")
    return folder


def test_the_walk_ends_with_a_page_and_figures(folder: Path, tmp_path: Path) -> None:
    outcome = done("report", folder / "result.h5", "-o", tmp_path / "report")
    page = Path(outcome.stdout.strip())
    assert page == tmp_path / "report" / "index.html"
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    metrics = report["results"][0]["metrics"]
    assert metrics["place_accuracy_top1"]["value"] >= 0.7
    assert metrics["place_accuracy_top1"]["of"] == 60
    assert metrics["position_error_median_m"]["value"] <= 0.5


def test_a_stage_says_in_one_line_what_it_made(folder: Path, tmp_path: Path) -> None:
    outcome = done("build-map", folder / "map.sig.h5", *FINE, "-o", tmp_path / "map.h5")
    assert outcome.stdout == ""
    assert outcome.stderr.count("\n") == 1
    assert "places" in outcome.stderr
    assert "\x1b" not in outcome.stderr


def test_json_is_one_object_on_stdout(folder: Path, tmp_path: Path) -> None:
    outcome = done("build-map", folder / "map.sig.h5", *FINE, "--json", "-o", tmp_path / "map.h5")
    facts = json.loads(outcome.stdout)
    assert facts["output"] == "map.h5"
    assert facts["signatures"] == 60
    assert facts["places"] >= 2


@pytest.mark.parametrize("method", ["match", "filter", "smooth"])
def test_every_method_localizes_most_of_the_second_walk(
    folder: Path, tmp_path: Path, method: str
) -> None:
    result = tmp_path / "result.h5"
    outcome = done(
        "localize", folder / "map.h5", folder / "again.mcap", "--method", method, "--json",
        "-o", result,
    )  # fmt: skip
    facts = json.loads(outcome.stdout)
    assert facts["queries"] == 60
    assert facts["localized"] >= 30


def test_recognition_of_a_second_log_in_the_first(folder: Path, tmp_path: Path) -> None:
    done(
        "recognize", folder / "map.mcap", folder / "again.mcap", "-s", "fingerprint",
        "-o", tmp_path / "result.h5",
    )  # fmt: skip
    done("report", tmp_path / "result.h5", "-o", tmp_path / "report")
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert report["results"][0]["metrics"]["recall_at_1"]["value"] >= 0.8


def test_same_input_same_bytes_on_one_or_two_processes(folder: Path, tmp_path: Path) -> None:
    for jobs in ("1", "2"):
        out = tmp_path / f"{jobs}.h5"
        done("extract", folder / "map.mcap", "-s", "fingerprint", "-j", jobs, "-o", out)
    assert digest(tmp_path / "1.h5") == digest(tmp_path / "2.h5") == digest(folder / "map.sig.h5")


def test_a_log_where_signatures_are_accepted_gives_the_same_map(
    folder: Path, tmp_path: Path
) -> None:
    done("build-map", folder / "map.mcap", "-s", "fingerprint", *FINE, "-o", tmp_path / "map.h5")
    done("localize", tmp_path / "map.h5", folder / "again.mcap", "-o", tmp_path / "result.h5")
    for name in ("places", "scores", "decision"):
        assert stored(tmp_path / "result.h5", name) == stored(folder / "result.h5", name)


def stored(path: Path, name: str) -> bytes:
    from fpnav.store.results import read_result

    values: bytes = getattr(read_result(path), name).tobytes()
    return values


def test_signatures_made_otherwise_are_refused_with_both_sides(
    folder: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other.h5"
    done(
        "extract", folder / "again.mcap", "-s", "fingerprint",
        "--set", "fingerprint.delta_n_deg=30", "-o", other,
    )  # fmt: skip
    said = refused("localize", folder / "map.h5", other, "-o", tmp_path / "result.h5")
    assert "delta_n_deg" in said
    assert "30" in said
    assert "20" in said


def test_late_parameters_may_be_set_on_stored_signatures(folder: Path, tmp_path: Path) -> None:
    few, many = (
        json.loads(
            done(
                "build-map", folder / "map.sig.h5", "--json", "--no-loops",
                "--set", "fingerprint.segment=threshold", "--set", f"fingerprint.theta={theta}",
                "-o", tmp_path / "map.h5",
            ).stdout
        )["places"]
        for theta in ("0.9", "0.2")
    )  # fmt: skip
    assert few < many


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("--set", "fingerprint.thta=1"), "did you mean 'theta'"),
        (("--set", "fingerprnt.theta=1"), "did you mean 'fingerprint'"),
        (("--set", "theta=1"), "block.key=value"),
        (("--set", "placecell.rt=0.5"), "the system at work is fingerprint"),
        (("--set", "fingerprint.theta=[1]"), "fingerprint"),
        (("--preset", "papr"), "has no preset"),
        (("--params", "nowhere.toml"), "no such parameter file"),
    ],
)
def test_a_wrong_parameter_is_a_usage_error(
    folder: Path, tmp_path: Path, words: tuple[str, ...], part: str
) -> None:
    said = refused(
        "extract", folder / "map.mcap", "-s", "fingerprint", *words, "-o", tmp_path / "x.h5", code=2
    )
    assert part in said


def test_a_result_is_no_log_and_no_map(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.h5"
    assert "expected 'fpnav/map'" in refused(
        "localize", folder / "result.h5", folder / "again.mcap", "-o", out
    )
    assert "expected 'fpnav/signatures'" in refused("build-map", folder / "map.h5", "-o", out)
    assert not out.exists()


def test_outputs_are_checked_before_the_work(folder: Path, tmp_path: Path) -> None:
    log = folder / "map.mcap"
    words = ("extract", log, "-s", "fingerprint", "-o")
    assert "does not exist" in refused(*words, tmp_path / "no" / "x.h5", code=2)
    assert "is also an input" in refused(*words, log, code=2)
    taken = tmp_path / "taken.h5"
    taken.write_text("mine")
    assert "--no-clobber" in refused(*words, taken, "--no-clobber", code=2)
    assert taken.read_text() == "mine"


def test_a_part_of_a_log_is_used_where_asked_for(folder: Path, tmp_path: Path) -> None:
    words = ("extract", folder / "map.mcap", "-s", "fingerprint", "--json", "-o")
    first = done(*words, tmp_path / "a.h5", "--end", "2.05")
    rest = done(*words, tmp_path / "b.h5", "--start", "2.05")
    counts = [json.loads(outcome.stdout)["signatures"] for outcome in (first, rest)]
    assert counts == [21, 39]


def test_measured_times_go_to_their_own_file(folder: Path, tmp_path: Path) -> None:
    stats = tmp_path / "stats.json"
    done("build-map", folder / "map.sig.h5", "-o", tmp_path / "map.h5", "--stats-json", stats)
    assert json.loads(stats.read_text())["wall_s"] > 0


def test_a_log_without_the_needed_sensors_says_which(tmp_path: Path) -> None:
    from fpnav.logs.writer import LogWriter
    from fpnav.publish import publish
    from fpnav.values import Pose2

    log = tmp_path / "bare.mcap"
    with publish(log) as stream, LogWriter(stream) as writer:
        for number in range(5):
            writer.odometry(10**9 + number * 10**8, Pose2(number * 0.1, 0.0, 0.0))
    said = refused("extract", log, "-s", "fingerprint", "-o", tmp_path / "x.h5")
    assert said.count("\n") == 0
    assert "bare.mcap" in said


def test_a_killed_extraction_is_resumed_to_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    words = ["extract", folder / "map.mcap", "-s", "fingerprint", "--resume"]
    plain = tmp_path / "plain.h5"
    done(*words[:4], "-o", plain)
    target = tmp_path / "resumed.h5"
    kept = tmp_path / ".resumed.h5.fpresume"
    process = subprocess.Popen([*FPNAV, *map(str, words), "-o", str(target)])
    deadline = time.monotonic() + 60
    while not list(kept.glob("*/*.npz")) and process.poll() is None:
        assert time.monotonic() < deadline
    process.kill()
    process.wait()
    done(*words, "-o", target)
    assert digest(target) == digest(plain)
    assert not kept.exists()


KILLED: dict[str, tuple[str, ...]] = {
    "simulate": (
        "simulate", "campus", "--route", "tour", "--places", "12", "-j", "2",
        "--sensors", "panorama,scan", "--set", "panorama.width_px=90",
        "--set", "panorama.height_px=16",
    ),
    "ingest": ("ingest", "map.mcap"),
    "extract": ("extract", "map.mcap", "-s", "fingerprint", "-j", "2"),
    "build-map": ("build-map", "map.sig.h5"),
    "localize": ("localize", "map.h5", "again.mcap"),
    "recognize": ("recognize", "map.mcap", "again.mcap", "-s", "fingerprint"),
    "report": ("report", "result.h5"),
    "export": ("export", "map.h5", "--to", "graphml"),
    "export mcap": ("export", "result.h5", "--to", "mcap"),
}  # fmt: skip
"""Lines that are killed, by name; the output is added."""

WRITES_NOTHING = {"info", "check", "systems"}
TOO_LONG_TO_KILL = {"reproduce", "navigate"}
"""They make their files with the writers of simulate, localize and report."""


def test_every_command_that_writes_is_killed_in_the_sweep() -> None:
    swept = {words[0] for words in KILLED.values()}
    assert set(COMMANDS) <= swept | WRITES_NOTHING | TOO_LONG_TO_KILL


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("name", KILLED)
def test_killed_at_any_moment_the_old_file_stays_or_the_new_one_is_whole(
    folder: Path, tmp_path: Path, name: str, number: signal.Signals
) -> None:
    target = tmp_path / ("report" if name == "report" else "target")
    line = [*FPNAV, *KILLED[name], "-o", str(target)]
    began = time.monotonic()
    subprocess.run(line, check=True, capture_output=True, cwd=folder)
    took = time.monotonic() - began
    whole = tree_digest(target)
    moments = random.Random(str((name, number)))
    for _ in range(6):
        process = subprocess.Popen(
            line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder
        )
        while not is_up(process):
            time.sleep(0.001)
        try:
            process.wait(moments.uniform(0, 1.1 * took))
        except subprocess.TimeoutExpired:
            process.send_signal(number)
        process.wait(timeout=60)
        assert process.returncode in (0, -number)
        assert tree_digest(target) == whole
        if number != signal.SIGKILL:
            assert not list(tmp_path.rglob("*.fptmp"))
    subprocess.run(line, check=True, capture_output=True, cwd=folder)
    assert tree_digest(target) == whole
    assert not list(tmp_path.rglob("*.fptmp"))


def is_up(process: subprocess.Popen[bytes]) -> bool:
    """Whether fpnav, not only the interpreter that starts it, answers to signals: it catches
    SIGTERM, which Python itself does not."""
    if process.poll() is not None:
        return True
    for line in Path(f"/proc/{process.pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("SigCgt:"):
            return bool(int(line.split()[1], 16) >> (signal.SIGTERM - 1) & 1)
    return False


def tree_digest(target: Path) -> dict[str, str]:
    """Digest of every visible file under the target."""
    files = [target] if target.is_file() else sorted(target.rglob("*"))
    return {file.name: digest(file) for file in files if not file.name.startswith(".")}


def test_help_imports_nothing_heavy(root: Path) -> None:
    code = (
        "import sys\n"
        "from fpnav.cli.main import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "print([m for m in ('numpy', 'cv2', 'h5py', 'networkx', 'matplotlib', 'rosbags') "
        "if m in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": str(root)}
    outcome = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    assert outcome.stdout.strip().endswith("[]")
