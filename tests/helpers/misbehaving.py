"""Commands that misbehave on request: run as a script, they go through the real entry point."""

from __future__ import annotations

import contextlib
import sys
import time
import types
from collections.abc import Callable
from pathlib import Path

import click

from fpnav.cli import main
from fpnav.errors import FpnavError


def shout(_: str) -> None:
    """More lines than a pipe holds."""
    for number in range(100_000):
        click.echo(f"line {number}")


def whisper(_: str) -> None:
    """One line, once stdin is closed."""
    sys.stdin.read()
    click.echo("one line")


def fail(message: str) -> None:
    raise FpnavError(message)


def broken(_: str) -> None:
    """A broken pipe that is not stdout's."""
    raise BrokenPipeError(32, "Broken pipe")


def crash(_: str) -> None:
    raise ZeroDivisionError("no one thought of this")


def publish(target: str) -> None:
    """Half a file, then a wait."""
    from fpnav.publish import publish

    with publish(Path(target)) as handle:
        handle.write(b"half")
        handle.flush()
        _ready()
        time.sleep(60)


def store(target: str) -> None:
    """One HDF5 file after the other, without end."""
    import numpy as np

    from fpnav.store.hdf5 import create, write_array

    _ready()
    while True:
        with create(Path(target)) as file:
            write_array(file, "values", np.arange(50_000.0))


def linger(_: str) -> None:
    """A clean-up that takes too long."""
    try:
        _ready()
        time.sleep(60)
    finally:
        time.sleep(60)


def swallow(_: str) -> None:
    """A wait in which destructors swallow whatever is raised."""

    class Swallowing:
        def __del__(self) -> None:
            time.sleep(0.2)

    _ready()
    for _round in range(300):
        Swallowing()
        time.sleep(0.05)


def _ready() -> None:
    with contextlib.suppress(BrokenPipeError):
        print("ready", flush=True)


COMMANDS: dict[str, Callable[[str], None]] = {
    function.__name__: function
    for function in (shout, whisper, fail, broken, crash, publish, store, linger, swallow)
}


def install(name: str, callback: Callable[[str], object]) -> None:
    """Make a callback a command of one optional argument."""
    module = types.ModuleType(f"fpnav.cli.{name}")
    argument = click.Argument(["argument"], default="")
    module.command = click.Command(  # type: ignore[attr-defined]
        name, callback=lambda argument: callback(argument), params=[argument]
    )
    sys.modules[f"fpnav.cli.{name}"] = module
    main.COMMANDS[name] = "Misbehave."


if __name__ == "__main__":
    for name, callback in COMMANDS.items():
        install(name, callback)
    main.main(sys.argv[1:])
