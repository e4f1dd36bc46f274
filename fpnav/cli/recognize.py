"""``fpnav recognize``: the same places again, frame to frame, without a map."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress
from fpnav.cli.session import Session, choice_of, log_options_of


def _heading(ctx: click.Context, parameter: click.Parameter, value: str) -> float | None:
    """Degrees, or None for ``any``."""
    if value == "any":
        return None
    try:
        degrees = float(value)
    except ValueError:
        raise click.BadParameter(f"{value!r}: expected degrees or any") from None
    if not 0 < degrees <= 180:
        raise click.BadParameter(f"{value}: expected 0 to 180 degrees or any")
    return degrees


@click.command("recognize")
@click.argument("reference", type=options.FILE, metavar="REF")
@click.argument("query", type=options.FILE, required=False, metavar="[QUERY]")
@options.output
@click.option(
    "--exclude-path", "exclude_path_m", type=click.FloatRange(0), default=15.0,
    show_default=True, help="Metres of travel before a query that cannot match it.",
)  # fmt: skip
@click.option(
    "--exclude-frames", type=click.IntRange(0), default=0, show_default=True,
    help="Frames before a query that cannot match it.",
)  # fmt: skip
@click.option(
    "--query-every", type=click.IntRange(1), default=1, show_default=True,
    help="Every Nth signature is a query.",
)  # fmt: skip
@click.option(
    "--radius", "radius_m", type=click.FloatRange(0, min_open=True), default=1.5,
    show_default=True, help="Metres within which two frames show the same place.",
)  # fmt: skip
@click.option(
    "--heading", "heading_deg", callback=_heading, default="45", show_default=True,
    help="Degrees between headings that still count as the same place, or any.",
)  # fmt: skip
@click.option(
    "--verify-top", type=click.IntRange(0), default=200, show_default=True,
    help="Candidates a query's geometric check may look at, where the system has one.",
)  # fmt: skip
@click.option(
    "--method", type=click.Choice(["match", "smooth"]), default="match", show_default=True,
    help="Each query by itself, or the run smoothed by the motion between queries.",
)  # fmt: skip
@options.truth
@options.system_options
@options.log_options
@options.run_options
@options.resume
def command(
    reference: Path, query: Path | None, truth_file: Path | None, resume: bool, **given: Any
) -> None:
    """Match each frame of REF with its own past, or each frame of QUERY with REF.

    \b
    Example: fpnav recognize drive.mcap -s fingerprint --exclude-path 15 -o result.h5
    """
    from fpnav.execution.checkpoint import Checkpoints
    from fpnav.execution.spread import make_spread
    from fpnav.execution.stages import recognize_run
    from fpnav.execution.walk import signatures_of
    from fpnav.localization.locate import Method
    from fpnav.store.results import write_result

    files = [reference] if query is None else [reference, query]
    session = Session.begin(files, **given)
    checkpoints = Checkpoints(session.output, resume=resume)
    spread = make_spread(given["jobs"], given["scheduler"])
    logs = log_options_of(given)
    with progress("extract", None) as advance:
        runs = [
            signatures_of([file], choice_of(given), logs, spread, advance, checkpoints)
            for file in files
        ]
    names = ("exclude_path_m", "exclude_frames", "query_every", "radius_m", "heading_deg")
    with progress("recognize", None) as advance:
        result = recognize_run(
            runs[0],
            None if query is None else runs[1],
            verify_top=given["verify_top"],
            method=Method(given["method"]),
            truth_file=truth_file,
            advance=advance,
            **{name: given[name] for name in names},
        )
    write_result(session.output, result, clobber=not session.no_clobber)
    checkpoints.clear()
    found = int((result.decision >= 0).sum())
    session.end(
        f"{found} of {len(result.queries)} queries recognised",
        {"queries": len(result.queries), "recognised": found},
    )
