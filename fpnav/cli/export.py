"""``fpnav export``: a map or result in a format other tools read."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from fpnav.cli import options

FORMATS = ("graphml", "geojson", "json", "tum", "g2o", "csv", "mcap")


@click.command("export")
@click.argument("file", type=options.FILE, metavar="FILE.h5")
@click.option(
    "--to", "name", type=click.Choice(FORMATS), required=True,
    help="graphml, geojson (Nav2 route server), json (node-link), tum, g2o, csv, mcap (Foxglove).",
)  # fmt: skip
@click.option(
    "-o", "--output", type=options.FILE, required=True, help="File to write; - is stdout for text."
)
@options.no_clobber
@options.quiet
def command(file: Path, name: str, output: Path, no_clobber: bool, quiet: bool) -> None:
    """Write the map or result in FILE.h5 in a format other tools read.

    \b
    Example: fpnav export map.h5 --to geojson -o places.geojson
    """
    from fpnav.errors import UsageError
    from fpnav.export.subject import read_subject
    from fpnav.export.table import FORMATS as WRITERS
    from fpnav.export.table import export
    from fpnav.publish import check_output, publish_bytes

    to_stdout = str(output) == "-"
    if to_stdout and not WRITERS[name].text:
        raise UsageError(f"--to {name} is not text; name a file with -o")
    if not to_stdout:
        check_output(output, inputs=[file], clobber=not no_clobber)
    data = export(read_subject(file), name)
    if to_stdout:
        sys.stdout.buffer.write(data)
        return
    publish_bytes(output, data, clobber=not no_clobber)
    if not quiet:
        click.echo(f"{output}: {len(data)} bytes for {WRITERS[name].purpose}", err=True)
