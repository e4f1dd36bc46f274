"""Make the sample logs and their README anew: the same bytes every time.

Each log is one line of ``fpnav simulate``; the lines below are what the README shows.
"""

from __future__ import annotations

import shlex
import sys
from importlib.metadata import version
from pathlib import Path

from fpnav.cli.main import cli
from fpnav.publish import file_digest, publish_bytes

HERE = Path(__file__).resolve().parent
SHORT = "--step 0.25 --set world.map_m=48 --set world.test_m=48"
HALF = "--set panorama.width_px=750 --set panorama.height_px=120"
NEAR = "--set capture.images_near_m=0.15 --set film.quality=70"
LINES = {
    "office_map.mcap": f"simulate office --route map --seed 3 --run 1 {SHORT}",
    "office_test.mcap": f"simulate office --route test --seed 3 --run 2 {SHORT}",
    "room_line.mcap": f"simulate room --route line --seed 1 --run 1 --step 0.1 {HALF}",
    "gateways_route.mcap": f"simulate gateways --route route-3 --seed 2 --run 1 {NEAR}",
}
WHAT = {
    "office_map.mcap": "Mapping run: corridor and three offices; panorama, scan, sonar ring",
    "office_test.mcap": "Test run: the same rooms on another path, other people, other light",
    "room_line.mcap": "A line of five places through one room; panorama, scan, compass",
    "gateways_route.mcap": "Five gateways of a hallway; two cameras near them, sonar ring",
}
MADE_WITH = ("opencv-python-headless", "embreex", "numpy", "numba", "zstandard", "mcap")
HEAD = """# Sample logs

Short simulated runs, small enough for git: ROS 2 MCAP with truth (`/truth`), labels and the
attachment `world.json`. `make sample-logs` makes every one of them again.

"""
TAIL = """
The bytes depend on nothing but the line above and the versions of the libraries that encode
images, cast rays and compress: with other versions, or on another kind of processor, single
pixels and ranges may round otherwise and the digests differ. These were made with {versions}.
"""


def main() -> None:
    """Make every log, then the README."""
    for name, line in LINES.items():
        cli.main([*shlex.split(line), "-q", "-o", str(HERE / name)], standalone_mode=False)
        print(f"{name}: {(HERE / name).stat().st_size} bytes", file=sys.stderr)
    publish_bytes(HERE / "README.md", readme().encode())


def readme() -> str:
    """The README: one row for each log."""
    rows = ["| file | what | made by | bytes | sha256 |", "|---|---|---|---|---|"]
    for name, line in LINES.items():
        file = HERE / name
        command = f"`fpnav {line} -o {name}`"
        size, digest = file.stat().st_size, file_digest(file)
        rows.append(f"| {name} | {WHAT[name]} | {command} | {size} | `{digest}` |")
    versions = ", ".join(f"{package} {version(package)}" for package in MADE_WITH)
    return HEAD + "\n".join(rows) + "\n" + TAIL.format(versions=versions)


if __name__ == "__main__":
    main()
