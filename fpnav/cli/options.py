"""Every option that several commands share, declared once, checked where it is parsed."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from fpnav.systems.registry import SYSTEMS

Function = TypeVar("Function", bound=Callable[..., Any])
FILE = click.Path(path_type=Path)


def _topics(
    ctx: click.Context, parameter: click.Parameter, values: tuple[str, ...]
) -> dict[str, str]:
    """``role=/name`` pairs as a dict."""
    from fpnav.values import ROLES

    topics = {}
    for value in values:
        role, equals, name = value.partition("=")
        if not equals or role not in ROLES:
            raise click.BadParameter(
                f"{value!r}: expected role=/name with role of {', '.join(ROLES)}"
            )
        topics[role] = name
    return topics


def _system(ctx: click.Context, parameter: click.Parameter, value: str | None) -> str | None:
    """A known system's name."""
    if value is None:
        return None
    from fpnav.errors import UsageError
    from fpnav.systems.registry import system_class

    try:
        system_class(value)
    except UsageError as error:
        raise click.BadParameter(str(error)) from error
    return value


def _positive(ctx: click.Context, parameter: click.Parameter, value: int) -> int:
    return value if value > 0 else (os.cpu_count() or 1)


output = click.option("-o", "--output", type=FILE, required=True, help="File to write.")
no_clobber = click.option("--no-clobber", is_flag=True, help="Refuse to replace an existing file.")
system = click.option(
    "-s",
    "--system",
    callback=_system,
    help=f"How places are recognised: {', '.join(SYSTEMS)}; a+b joins two.",
)
preset = click.option("--preset", help="Named parameter set of the system (see fpnav systems).")
params = click.option(
    "--params", "params_file", type=FILE, help="TOML file with one table per parameter block."
)
settings = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="BLOCK.KEY=VALUE",
    help="One parameter; beats the file.",
)
jobs = click.option(
    "--jobs", "-j", type=int, default=1, callback=_positive, show_default=True,
    help="Worker processes; 0 = one per core.",
)  # fmt: skip
scheduler = click.option("--scheduler", help="Address of a running Dask scheduler (extra dask).")
topics = click.option(
    "--topic", "topics", multiple=True, callback=_topics, metavar="ROLE=/NAME",
    help="Topic that plays a role, where the guess is wrong.",
)  # fmt: skip
step = click.option(
    "--step", "step_m", type=click.FloatRange(0), metavar="METRES",
    help="Least travel between used frames; 0 = every frame [default: the preset's].",
)  # fmt: skip
step_heading = click.option(
    "--step-heading", "step_deg", type=click.FloatRange(0), metavar="DEGREES",
    help="Or this much turning; 0 = turning alone makes no frame [default: the preset's].",
)  # fmt: skip
start = click.option(
    "--start", "start_s", type=click.FloatRange(0), default=0.0, metavar="SECONDS",
    help="Use each log from this time after its first frame.",
)  # fmt: skip
end = click.option(
    "--end", "end_s", type=click.FloatRange(0), default=float("inf"), metavar="SECONDS",
    help="Use each log up to this time after its first frame.",
)  # fmt: skip
max_loss = click.option(
    "--max-loss", type=click.FloatRange(0, 1), default=0.01, show_default=True,
    help="Share of a used topic's messages that may be lost; more ends with exit code 3.",
)  # fmt: skip
allow_truncated = click.option(
    "--allow-truncated", is_flag=True, help="Use what a cut log holds, however little."
)
stats_json = click.option(
    "--stats-json", type=FILE, help="Write measured times here; they stand nowhere else."
)
resume = click.option("--resume", is_flag=True, help="Continue a run that was killed.")
quiet = click.option("-q", "--quiet", is_flag=True, help="No progress and no notes.")
as_json = click.option(
    "--json", "as_json", is_flag=True, help="Print the summary as one JSON line."
)
method = click.option(
    "--method", type=click.Choice(["match", "filter", "smooth"]), default="match",
    show_default=True, help="One observation, belief so far, or belief given the whole run.",
)  # fmt: skip
truth = click.option(
    "--truth", "truth_file", type=FILE,
    help="FILE.tum, or FILE.json with accepted reference indices [default: the log's own topic].",
)  # fmt: skip


def log_options(function: Function) -> Function:
    """How logs are read: topics, thinning, tolerated loss."""
    for option in (allow_truncated, max_loss, end, start, step_heading, step, topics):
        function = option(function)
    return function


def system_options(function: Function) -> Function:
    """Which system, with which parameters."""
    for option in (settings, params, preset, system):
        function = option(function)
    return function


def run_options(function: Function) -> Function:
    """How the run is carried out and what it says of itself."""
    for option in (as_json, quiet, stats_json, scheduler, jobs, no_clobber):
        function = option(function)
    return function
