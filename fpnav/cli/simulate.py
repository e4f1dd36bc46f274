"""``fpnav simulate``: a world and a route -> a log with its truth."""

from __future__ import annotations

from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress
from fpnav.cli.session import Session, plural


@click.command("simulate")
@click.argument("world")
@click.option(
    "--route",
    required=True,
    help="Way through the world, such as map or test; a wrong one lists them.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="The building.")
@click.option(
    "--run", type=click.IntRange(0), default=1, show_default=True, help="Noise, people, light."
)
@click.option("--sensors", help="Roles to record, separated by commas [default: the world's].")
@click.option(
    "--step", type=click.FloatRange(0.01), help="Metres between data sets [default: 0.15]."
)
@click.option("--length", type=click.FloatRange(0.1), help="Stop after this many metres.")
@click.option("--kidnap", type=click.IntRange(0), help="Times the robot is set down elsewhere.")
@click.option("--places", type=click.IntRange(1), help="Number of places (campus).")
@options.output
@options.params
@options.settings
@options.run_options
def command(world: str, route: str, seed: int, run: int, **given: Any) -> None:
    """Drive a simulated robot through WORLD and record what its sensors saw, with truth.

    WORLD is office, room, outdoor, suburb, gateways, gateway_types or campus.

    \b
    Example: fpnav simulate office --route map --seed 1 --run 1 -o map.mcap
    """
    from fpnav.execution.spread import make_spread
    from fpnav.params import read_tables
    from fpnav.sim.catalogue import Setting, default_rig, overrides_in
    from fpnav.sim.record import Job, driven, record
    from fpnav.sim.rig import BLOCKS, make_rig

    session = Session.begin((), **given)
    tables = read_tables(
        given["params_file"], [*given["settings"], *_short(given)], ["world", *BLOCKS]
    )
    roles, defaults = default_rig(world)
    rig = make_rig(given["sensors"].split(",") if given["sensors"] else roles, defaults, tables)
    job = Job(Setting(world, seed, run, overrides_in(tables)), route, rig)
    _, _, times = driven(job)
    with progress("simulate", len(times)) as advance:
        spread = make_spread(given["jobs"], given["scheduler"])
        facts = record(
            job, session.output, spread=spread, clobber=not session.no_clobber, advance=advance
        )
    session.end(_sentence(facts), facts)


def _short(given: dict[str, Any]) -> list[str]:
    """The options that are parameters under another name."""
    pairs = (
        ("capture.step_m", given["step"]),
        ("capture.length_m", given["length"]),
        ("capture.kidnaps", given["kidnap"]),
        ("world.places", given["places"]),
    )
    return [f"{name}={value}" for name, value in pairs if value is not None]


def _sentence(facts: dict[str, Any]) -> str:
    count = plural(facts["data_sets"], "data set")
    return f"{count} on {facts['length_m']} m, {facts['duration_s']} s, with truth"
