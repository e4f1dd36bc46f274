"""``fpnav reproduce``: a paper's experiments, from simulated logs to a report beside its claims."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress, set_quiet
from fpnav.cli.session import Session, plural


def _seeds(ctx: click.Context, parameter: click.Parameter, value: str) -> tuple[int, ...]:
    try:
        seeds = tuple(int(part) for part in value.split(","))
    except ValueError:
        raise click.BadParameter(f"{value!r}: expected numbers separated by commas") from None
    if min(seeds) < 0 or len(set(seeds)) < len(seeds):
        raise click.BadParameter(f"{value!r}: expected different numbers from 0 on")
    return seeds


def _names(ctx: click.Context, parameter: click.Parameter, value: str) -> tuple[str, ...]:
    return tuple(part for part in value.split(",") if part)


@click.command("reproduce")
@click.argument("paper", metavar="PAPER")
@click.option(
    "--seeds", default="1,2,3,4,5", show_default=True, callback=_seeds, metavar="N,N,...",
    help="Worlds to run in.",
)  # fmt: skip
@click.option(
    "--only",
    default="",
    callback=_names,
    metavar="NAME,NAME,...",
    help="Experiments to run [default: all].",
)
@click.option(
    "--work",
    type=options.FILE,
    help="Folder where logs and signatures are kept [default: DIR/work].",
)
@click.option(
    "--small", is_flag=True, help="Shortened routes: shows that everything runs, not how well."
)
@click.option("-o", "--output", type=options.FILE, required=True, help="Folder to write.")
@options.run_options
def command(
    paper: str,
    seeds: tuple[int, ...],
    only: tuple[str, ...],
    small: bool,
    work: Path | None,
    **given: Any,
) -> None:
    """Run the experiments of PAPER in simulated worlds and report them beside its claims.

    PAPER is tapus, giovannangeli or kortenkamp.

    \b
    Example: fpnav reproduce giovannangeli --seeds 1 --only B1 -o build/reproduction
    """
    from fpnav.errors import UsageError
    from fpnav.execution.spread import make_spread
    from fpnav.experiments.registry import study_of
    from fpnav.experiments.study import conduct
    from fpnav.experiments.workshop import Workshop
    from fpnav.report.study import write_study
    from fpnav.report.write import PAGE

    spread = make_spread(given.pop("jobs"), given.pop("scheduler"))
    output = given.pop("output")
    session = Session(output, **given)
    set_quiet(session.quiet)
    study = study_of(paper)
    if session.no_clobber and (output / PAGE).exists():
        raise UsageError(f"{output / PAGE}: exists and --no-clobber is set")
    chosen = only or tuple(study.experiments)
    with progress(f"reproduce {paper}", len(seeds) * len(chosen)) as advance:
        workshop = Workshop(work or output / "work", spread, small)
        findings = conduct(study, workshop, seeds, chosen, advance)
    write_study(study.heading, study.claims, findings, output, small=small)
    if not session.as_json:
        click.echo(output / PAGE)
    session.end(
        f"{plural(len(chosen), 'experiment')} in {plural(len(seeds), 'world')}",
        {"page": str(output / PAGE), "experiments": list(chosen), "seeds": list(seeds)},
    )
