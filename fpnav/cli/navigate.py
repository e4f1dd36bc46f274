"""``fpnav navigate``: a policy drives by a map, in a simulated world or asked on a log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress
from fpnav.cli.session import Session, log_options_of, plural


def _start(ctx: click.Context, parameter: click.Parameter, value: str | None) -> Any:
    if value is None:
        return None
    from fpnav.sim.mission import pose_from

    try:
        return pose_from(value)
    except ValueError:
        raise click.BadParameter(f"{value!r}: expected X,Y or X,Y,DEGREES") from None


@click.command("navigate")
@click.argument("where", metavar="WORLD_OR_LOG")
@click.option("--map", "map_file", type=options.FILE, required=True, help="Map to go by.")
@click.option("--goal", help="Come to this place of the map: its label or number.")
@click.option("--route", help="Follow this route of the world, as the mapping run did.")
@click.option(
    "--policy", help="What decides: place-action or wall-following [default: the system's]."
)
@click.option("--seed", type=click.IntRange(0), help="The building [default: the map's].")
@click.option(
    "--run", type=click.IntRange(0), help="Noise, people, light [default: two after the map's]."
)
@click.option("--trips", type=click.IntRange(1), default=1, show_default=True, help="How often.")
@click.option(
    "--within", "within_m", type=click.FloatRange(0.0), default=1.5, show_default=True,
    help="Starts lie this near the goal, in metres.",
)  # fmt: skip
@click.option(
    "--from", "start", callback=_start, metavar="X,Y,DEG", help="Start here, in the world."
)
@click.option(
    "--seconds", type=click.FloatRange(0.0), default=0.0,
    help="Longest time of a trip [default: 30 to a goal, twice what the route takes].",
)  # fmt: skip
@click.option(
    "--period", "period_s", type=click.FloatRange(0.05), default=0.25, show_default=True,
    help="Seconds between decisions.",
)  # fmt: skip
@click.option("--sensors", help="Roles to carry, separated by commas [default: the world's].")
@options.output
@options.params
@options.settings
@options.log_options
@options.run_options
def command(where: str, map_file: Path, goal: str | None, route: str | None, **given: Any) -> None:
    """Drive a simulated robot through WORLD by a map; or ask on a LOG what would have been done.

    In a world two files are written, RUN.mcap and RUN.h5 (a result that ``fpnav report`` reads),
    whichever of them -o names; on a log RUN.h5 alone.

    \b
    fpnav navigate room --map home.h5 --goal goal --trips 20 -o homing.h5
    fpnav navigate suburb --map loop.h5 --route loop --sensors pan,scan -o lap.h5
    fpnav navigate homing.mcap --map home.h5 --goal goal -o asked.h5
    """
    from fpnav.errors import UsageError
    from fpnav.sim.catalogue import WORLDS

    if (goal is None) == (route is None):
        raise UsageError("give one of --goal PLACE and --route NAME")
    log_file = given["output"].with_suffix(".mcap")
    given["output"] = log_file.with_suffix(".h5")
    session = Session.begin((map_file,), **given)
    guide = _guide(map_file, goal, route or "", given)
    if where in WORLDS:
        actions, task = _driven(guide, where, log_file, given)
    elif Path(where).exists():
        log_file, actions, task = Path(where), None, guide.facts(driven=False)
    else:
        raise UsageError(f"{where}: no world ({', '.join(WORLDS)}) and no log of that name")
    result = _located(guide, log_file, actions, task, given)
    _end(session, result)


def _guide(map_file: Path, goal: str | None, route: str, given: dict[str, Any]) -> Any:
    """The map, its system and the policy asked for."""
    from fpnav.execution.guided import Guide
    from fpnav.execution.walk import SystemChoice, system_of
    from fpnav.navigation.registry import BLOCKS as POLICY_BLOCKS
    from fpnav.params import read_tables
    from fpnav.sim.rig import BLOCKS
    from fpnav.store.header import MAP, check_header
    from fpnav.store.maps import read_map
    from fpnav.store.results import read_header
    from fpnav.systems.registry import SYSTEMS

    known = [*SYSTEMS, *POLICY_BLOCKS, "world", *BLOCKS]
    tables = read_tables(given["params_file"], given["settings"], known)
    header = read_header(map_file)
    check_header(map_file, header, MAP)
    system, preset = system_of(header, SystemChoice(tables=tables))
    built = read_map(map_file, system.RECORD, system.PARTS)
    policy = given["policy"] or system.POLICY
    return Guide(header, built, system, preset, policy, tables, goal, route)


def _driven(guide: Any, world: str, log_file: Path, given: dict[str, Any]) -> Any:
    """Decisions of the trips made, and the task as the protocol says it; the log is written."""
    from fpnav.publish import check_output
    from fpnav.sim.mission import Order, send_out

    check_output(log_file, inputs=(), clobber=not given["no_clobber"])
    order = Order(**{name: given[name] for name in Order.__slots__})
    with progress("navigate", order.trips) as advance:
        return send_out(
            guide, world, order, log_file, clobber=not given["no_clobber"], advance=advance
        )


def _located(guide: Any, log_file: Path, actions: Any, task: Any, given: dict[str, Any]) -> Any:
    """The run located on the map, with the decisions; made on the log where nobody drove."""
    from fpnav.execution.checkpoint import Checkpoints
    from fpnav.execution.guided import asked_on_log
    from fpnav.execution.outcome import with_actions
    from fpnav.execution.spread import make_spread
    from fpnav.execution.stages import locate_run
    from fpnav.execution.walk import signatures_of
    from fpnav.localization.locate import Method

    spread = make_spread(given["jobs"], given["scheduler"])
    checkpoints = Checkpoints(given["output"], resume=False)
    options_of_log = log_options_of(given)
    with progress("extract", None) as advance:
        run = signatures_of([log_file], guide.choice, options_of_log, spread, advance, checkpoints)
    with progress("localize", len(run.table)) as advance:
        result = locate_run(
            guide.system, guide.header, guide.built, run, method=Method.MATCH, advance=advance
        )
    if actions is None:
        actions = asked_on_log(guide.make_policy(), run.table)
    return with_actions(result, actions, task)


def _end(session: Session, result: Any) -> None:
    """Write the result and say how it went."""
    from fpnav.evaluation.case import judge
    from fpnav.evaluation.guidance import MEASURES
    from fpnav.store.results import write_result
    from fpnav.values import Metric

    write_result(session.output, result, clobber=not session.no_clobber)
    case = judge(result)
    found = [
        metric for name, ask in MEASURES.items() if isinstance(metric := ask(name, case), Metric)
    ]
    told = [f"{metric.name} {metric.value:.3f} ({metric.n} of {metric.of})" for metric in found]
    trips = plural(len(set(result.actions["trip"].tolist())), "trip")
    session.end(
        ", ".join([f"{trips}, {plural(len(result.actions), 'decision')}", *told]),
        {metric.name: [metric.n, metric.of] for metric in found},
    )
