"""Entry point: finds the command, and turns errors and signals into exit codes, here alone."""

from __future__ import annotations

import contextlib
import importlib
import os
import signal
import sys
from types import FrameType
from typing import Any, NoReturn

import click

from fpnav import __version__
from fpnav.errors import FpnavError

COMMANDS: dict[str, str] = {
    "simulate": "Drive a simulated robot through a world and record it with truth.",
    "ingest": "Bring any recording into the standard MCAP form.",
    "info": "Say what a file is and holds.",
    "check": "Test every assumption a stage makes of a log.",
    "extract": "Turn the frames of logs into signatures.",
    "build-map": "Build a topological map from logs or signatures.",
    "localize": "Locate each signature of a log on a map.",
    "recognize": "Find the same places again, frame to frame, without a map.",
    "navigate": "Drive a simulated robot by a map, or ask on a log what it would do.",
    "report": "Write accuracy, plots and a page from saved results.",
    "reproduce": "Run the experiments of a paper and report them beside its claims.",
    "export": "Write a map or result in a format other tools read.",
    "systems": "List the systems with their needs, presets and parameters.",
}
"""Every command with its line in ``--help``; the module is imported only when it runs."""

BUG = 70
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Killed(BaseException):
    """A signal asked the process to end; carries its number through the clean-up."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


_next_hook = sys.unraisablehook
_swallowed: list[int] = []
"""Signals whose exception a destructor swallowed."""


class LazyGroup(click.Group):
    """Group whose commands are imported when they are asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of the walk."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command object of ``fpnav.cli.NAME``, None where there is none."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"fpnav.cli.{cmd_name.replace('-', '_')}")
        command: click.Command = module.command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands from the table, so that help imports none of them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; a wrong word is answered with the nearest right one."""
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            import difflib

            near = difflib.get_close_matches(args[0], COMMANDS, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise click.UsageError(f"no command {args[0]!r}{hint}", ctx)
        return super().resolve_command(ctx, args)


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="fpnav")
def cli() -> None:
    """Topological maps of places from recorded robot logs.

    \b
    fpnav ingest drive.bag -o drive.mcap
    fpnav build-map drive.mcap -s fingerprint -o map.h5
    fpnav localize map.h5 again.mcap -o result.h5
    fpnav report result.h5 -o report/

    Exit codes: 0 done, 1 known error, 2 usage, 3 more data lost than allowed, 4 a gate was not
    met, 70 a bug.
    """


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line and exit with the code of architecture.md."""
    _install_handlers()
    code = number = 0
    try:
        code = _run(arguments)
    except Killed as killed:
        number = killed.number
    except KeyboardInterrupt:
        number = signal.SIGINT
    asked = [number] if number else _swallowed
    if asked:  # only here: the traceback is gone, and what it kept alive has cleaned up
        _die_of(asked[0])
    _leave(code)


def _run(arguments: list[str] | None) -> int:
    try:
        # Bounds what OpenCV decodes; set before anything imports it, inherited by workers.
        os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(2**26))
        code = cli.main(arguments, prog_name="fpnav", standalone_mode=False)
    except FpnavError as error:
        return _say(error, error.exit_code)
    except click.exceptions.Exit as leave:
        return int(leave.exit_code)
    except click.exceptions.NoArgsIsHelpError as bare:
        bare.show(sys.stderr)
        return 2
    except click.ClickException as error:
        return _say(_usage(error), 2)
    except click.Abort:
        raise KeyboardInterrupt from None
    except SystemExit as leave:  # how click answers a closed pipe
        return _drop_stdout() if _reader_gone() else int(leave.code or 0)
    except MemoryError:
        return _say("out of memory; nothing was published", 1)
    except OSError as error:
        return _say(f"{error.filename or 'i/o'}: {error.strerror or error}", 1)
    except Exception:
        return _bug()
    return code if isinstance(code, int) else 0


def _say(message: object, code: int) -> int:
    """One line on stderr; control characters of logs are shown, not obeyed."""
    text = "".join(_visible(character) for character in str(message))
    click.echo(f"fpnav: error: {text}", err=True)
    return code


def _usage(error: click.ClickException) -> str:
    """What is wrong with a command line and where help is, in one line (click's are four)."""
    context = error.ctx if isinstance(error, click.UsageError) else None
    command = context.command_path if context else "fpnav"
    found = " ".join(error.format_message().split()).removesuffix(".")
    return f"{found} (see {command} --help)"


def _visible(character: str) -> str:
    bidirectional = "\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
    if character.isprintable() and character not in bidirectional:
        return character
    return character.encode("unicode_escape").decode()


def _bug() -> int:
    import traceback

    traceback.print_exc()
    print(
        f"fpnav {__version__}: this is a bug; please report it with the lines above",
        file=sys.stderr,
    )
    return BUG


def _install_handlers() -> None:
    sys.unraisablehook = _on_unraisable
    for number in _SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _on_signal)


def _on_unraisable(lost: Any) -> None:
    """A destructor swallowed a signal's exception: raise it again once that is over."""
    if isinstance(lost.exc_value, Killed):
        _swallowed.append(lost.exc_value.number)
        signal.signal(signal.SIGALRM, _on_alarm)
        signal.setitimer(signal.ITIMER_REAL, 0.01)
    else:
        _next_hook(lost)


def _on_alarm(number: int, frame: FrameType | None) -> None:
    raise Killed(_swallowed[0])


def _on_signal(number: int, frame: FrameType | None) -> None:
    """First signal: unwind and clean up. A second one finds the default action: die at once."""
    for other in _SIGNALS:
        signal.signal(other, signal.SIG_DFL)
    raise Killed(number)


def _die_of(number: int) -> NoReturn:
    """End by the signal itself, so that make and the shell see a signal."""
    _flush()
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
    os._exit(128 + number)


def _leave(code: int) -> NoReturn:
    """Exit; a reader that closed the pipe is success, a full device is not."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        gone = _reader_gone()
        _drop_stdout()
        if not gone:
            code = code or _say(f"stdout: {error.strerror}", 1)
    sys.exit(code)


def _flush() -> None:
    with contextlib.suppress(OSError, AttributeError):
        sys.stdout.flush()


def _reader_gone() -> bool:
    """Whether who read our output has left, as ``head`` does: only then is a broken pipe fine."""
    import select

    poll = select.poll()
    poll.register(1, 0)
    return any(event & select.POLLERR for _, event in poll.poll(0))


def _drop_stdout() -> int:
    """What is left in the buffer goes nowhere, or the interpreter would complain on leaving."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    return 0
