"""``fpnav ingest``: any recording -> one standard log."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress
from fpnav.cli.session import Session

_DEGREES = click.FloatRange(0, 360, min_open=True)


@click.command("ingest")
@click.argument("sources", nargs=-1, required=True, type=options.FILE)
@options.output
@click.option("--format", "format_name", help="Format, where the guess is wrong.")
@options.topics
@click.option(
    "--role",
    type=click.Choice(["camera", "panorama", "omni", "camera_offset"]),
    help="What the images are, where the recording does not say.",
)
@click.option("--hfov", type=_DEGREES, help="Horizontal field of view of the images, degrees.")
@click.option("--vfov", type=_DEGREES, help="Vertical field of view of the images, degrees.")
@click.option("--horizon-row", type=float, help="Pixel row (from 0) of elevation 0.")
@click.option("--centre", type=(float, float), help="Centre of an omni image, pixels x y.")
@click.option("--radii", type=(float, float), help="Inner and outer radius, pixels.")
@click.option("--baseline", type=float, help="Lateral offset of camera_offset, metres.")
@click.option(
    "--poses",
    type=click.Choice(["auto", "truth", "odometry"]),
    default="auto",
    show_default=True,
    help="What the poses of a CARMEN or g2o log are; auto: truth where a mapper corrected them.",
)
@click.option(
    "--compression",
    type=click.Choice(["zstd", "lz4", "none"]),
    default="zstd",
    show_default=True,
    help="Compression of the log's chunks.",
)
@options.max_loss
@click.option("--strict", is_flag=True, help="Lose nothing: --max-loss 0.")
@options.allow_truncated
@options.no_clobber
@options.stats_json
@options.quiet
@options.as_json
def command(sources: tuple[Path, ...], format_name: str | None, **given: Any) -> None:
    """Bring SOURCES, the files of one recording, into the standard MCAP form.

    Damaged logs are salvaged: what is whole is written, what was lost is counted, and more than
    --max-loss of it ends with exit code 3 and no output.

    \b
    fpnav ingest drive.bag -o drive.mcap
    fpnav ingest corrected.log.gz --poses truth -o run.mcap
    fpnav ingest photos/ --role panorama --vfov 60 -o photos.mcap
    """
    from fpnav.logs.ingest import ingest
    from fpnav.logs.ledger import Budget

    session = Session.begin(sources, **given)
    budget = Budget(given["max_loss"], given["strict"], given["allow_truncated"])
    with progress("ingest", None) as advance:
        done = ingest(
            sources,
            session.output,
            format=format_name,
            options=_source_options(given),
            budget=budget,
            compression=given["compression"],
            clobber=not session.no_clobber,
            advance=advance,
        )
    total = sum(done.messages.values())
    roles = ", ".join(f"{role} {count}" for role, count in done.messages.items() if ":" not in role)
    losses = _losses(done.ledger)
    for note in [] if session.quiet else _notes(done.ledger):
        click.echo(note, err=True)
    session.end(
        f"{total} messages from {done.format}: {roles}{losses}",
        {"format": done.format, "messages": done.messages, "ledger": done.ledger.as_dict()},
    )


def _source_options(given: dict[str, Any]) -> Any:
    """What the user said about the recording."""
    from fpnav.logs.sources.base import SourceOptions
    from fpnav.values import Calibration

    centre = given["centre"] or (math.nan, math.nan)
    radii = given["radii"] or (math.nan, math.nan)
    calibration = Calibration(
        0,
        0,
        horizontal_fov_rad=_radians(given["hfov"]),
        vertical_fov_rad=_radians(given["vfov"]),
        horizon_row=_number(given["horizon_row"]),
        centre_x_px=centre[0],
        centre_y_px=centre[1],
        radius_in_px=radii[0],
        radius_out_px=radii[1],
        baseline_m=_number(given["baseline"]),
    )
    return SourceOptions(given["poses"], given["role"] or "", calibration, given["topics"])


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _radians(degrees: float | None) -> float:
    return math.nan if degrees is None else math.radians(degrees)


def _notes(ledger: Any) -> list[str]:
    """What is worth knowing of the reading, a line for each code."""
    from fpnav.cli.plain import visible

    shown = []
    for code, remark in sorted(ledger.remarks.items()):
        times = f" ({ledger.notes[code]} times)" if ledger.notes[code] > 1 else ""
        shown.append(f"note {code}: {visible(remark)}{times}")
    return shown


def _losses(ledger: Any) -> str:
    """Losses within the budget, in words; empty where there are none."""
    name, fraction = ledger.worst()
    return f"; lost {fraction:.2%} of {name}" if fraction else ""
