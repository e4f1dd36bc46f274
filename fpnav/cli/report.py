"""``fpnav report``: accuracy, plots and a page from saved results."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress, set_quiet
from fpnav.cli.session import Session


def _gates(
    ctx: click.Context, parameter: click.Parameter, values: tuple[str, ...]
) -> list[tuple[str, float]]:
    """``METRIC=VALUE`` pairs; the metric must be one that fpnav measures."""
    from fpnav.evaluation.table import METRICS

    gates = []
    for value in values:
        name, equals, least = value.partition("=")
        if not equals or name not in METRICS:
            raise click.BadParameter(f"{value!r}: expected METRIC=VALUE, METRIC of {list(METRICS)}")
        try:
            number = float(least)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise click.BadParameter(f"{value!r}: {least!r} is not a number")
        gates.append((name, number))
    return gates


@click.command("report")
@click.argument("files", type=options.FILE, nargs=-1, required=True, metavar="RESULT.h5...")
@click.option("-o", "--output", type=options.FILE, required=True, help="Folder to write.")
@click.option(
    "--fail-under", "gates", multiple=True, callback=_gates, metavar="METRIC=VALUE",
    help="Exit 4 where a result has less; for errors, such as position_error_median_m, more.",
)  # fmt: skip
@click.option(
    "--threshold-from", "other", type=options.FILE, metavar="OTHER.h5",
    help="Result of another run by the same system: precision and recall at its thresholds too.",
)  # fmt: skip
@click.option(
    "--log", "logs", type=options.FILE, multiple=True, metavar="LOG",
    help="Log behind the results, repeated for several: show what right and wrong matches saw.",
)  # fmt: skip
@options.as_json
@options.quiet
@options.no_clobber
@options.stats_json
def command(
    files: tuple[Path, ...],
    output: Path,
    gates: list[tuple[str, float]],
    other: Path | None,
    logs: tuple[Path, ...],
    **given: Any,
) -> None:
    """Write DIR/index.html, report.json, CSV and figures from saved results, side by side.

    \b
    Example: fpnav report match.h5 filter.h5 -o report/ --fail-under place_accuracy_top1=0.8
    """
    from fpnav.errors import UsageError
    from fpnav.report.gates import check_gates
    from fpnav.report.write import PAGE, write_report
    from fpnav.store.results import read_result

    session = Session(output, **given)
    set_quiet(session.quiet)
    page = output / PAGE
    if session.no_clobber and page.exists():
        raise UsageError(f"{page}: exists and --no-clobber is set")
    results = [(file.stem, read_result(file)) for file in files]
    chosen_on = (other.stem, read_result(other)) if other else None
    with progress("report", len(results)) as advance:
        entries = write_report(results, output, advance, chosen_on, logs)
    names = [entry.name for entry in entries]
    if not session.as_json:
        click.echo(page)
    session.end(f"report on {', '.join(names)}", {"page": str(page), "results": names})
    check_gates(entries, gates)
