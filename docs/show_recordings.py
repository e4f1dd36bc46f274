"""Writes docs/recordings.md: what ingest, info and check say of the recordings in FPNAV_DATA.

FPNAV_DATA=DATA python docs/show_recordings.py [KILLIAN.g2o.zip]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

RECORDINGS = (
    "bags/birmingham_p3dx/trace0.bag",
    "bags/olin_turtlebot4/macfirst_floor_take_2",
    "laser/carmen/freiburg-079-corrected.log.gz",
    "laser/carmen/intel-corrected.log.gz",
    "laser/carmen/belgioioso-corrected.log.gz",
    "laser/intel_raw/intel_raw.log.gz",
    "laser/wean_hall/robotdata1.log.gz",
    "laser/wean_hall/robotdata3.log.gz",
    "images/rtabmap_samples",
    "images/bob_route/train",
    "images/bob_route/test",
    "sonar/scitos_ring/ring.csv",
    "mcap/wifi/real_4_2_0.mcap",
    "mcap/wifi/zero_bytes.mcap",
    "laser/wean_hall/wean.dat.gz",
    "scores/vprbench_corridor.npz",
)

HEAD = """# Recordings, as fpnav tells them

Made by `docs/show_recordings.py` from the recordings that development goes by: what `ingest`,
`info` and `check` say. Lines of checks that found nothing are left out here.
"""


def told(folder: Path, *arguments: str) -> list[str]:
    """A command line and what it says, stderr too; checks that are ok are left out."""
    command = [str(Path(sys.executable).with_name("fpnav")), *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    lines = [line for line in (done.stdout + done.stderr).splitlines() if "  ok  " not in line]
    return [f"$ fpnav {' '.join(arguments)}", *lines, ""]


def section(name: str, source: Path, folder: Path) -> str:
    """One recording: the three commands, or the one line that refuses it."""
    (folder / source.name).symlink_to(source)
    log = f"{source.name.split('.')[0]}_in.mcap"
    lines = told(folder, "ingest", source.name, "-o", log)
    if (folder / log).exists():
        lines += told(folder, "info", log) + told(folder, "check", log)
    return "\n".join([f"\n## {name}\n", "```text", *lines[:-1], "```", ""])


def main() -> None:
    """Write the page."""
    data = Path(os.environ["FPNAV_DATA"]).resolve()
    sources = [(name, data / name) for name in RECORDINGS]
    sources += [(f"{Path(p).name} (PyPI rtb-data)", Path(p).resolve()) for p in sys.argv[1:]]
    parts = [HEAD]
    for name, source in sources:
        with tempfile.TemporaryDirectory() as folder:
            parts.append(section(name, source, Path(folder)))
    Path(__file__).with_name("recordings.md").write_text("".join(parts))


if __name__ == "__main__":
    main()
