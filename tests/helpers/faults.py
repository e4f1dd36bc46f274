"""Faults on demand: the Nth system step of a write ends the process or fails with an errno."""

from __future__ import annotations

import errno
import fcntl
import io
import os
import resource
import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

from fpnav import publish
from fpnav.errors import FpnavError

Act = Callable[[str], None]

DONE, REFUSED = 0, 1
KILLED = 137
_COUNTED = ("open", "fsync", "replace", "unlink", "ftruncate", "pwrite", "close")


class Steps:
    """Counts system steps and acts at the chosen one; 0 = only counts."""

    def __init__(self, at: int, act: Act) -> None:
        self.at = at
        self.act = act
        self.names: list[str] = []

    def __call__(self, name: str) -> None:
        self.names.append(name)
        if len(self.names) == self.at:
            self.act(name)


def die(name: str) -> None:
    """End as SIGKILL would: no handler, no ``finally``, nothing flushed."""
    os._exit(KILLED)


def fail_with(number: int) -> Act:
    """Fail the step as the operating system would."""

    def act(name: str) -> None:
        raise OSError(number, os.strerror(number))

    return act


@contextmanager
def shimmed(steps: Steps) -> Iterator[None]:
    """Count every step the writer of files takes while the block runs."""

    class Counted(io.FileIO):
        def write(self, data: Any) -> int:
            steps("write")
            return super().write(data)

        def truncate(self, size: int | None = None) -> int:
            steps("truncate")
            return super().truncate(size)

        def close(self) -> None:
            was_open = not self.closed
            super().close()
            if was_open:
                steps("close")

    def opened(path: Any, mode: str) -> io.BufferedRandom | io.BufferedReader:
        if mode != "w+b":
            return open(path, mode)  # type: ignore[return-value]
        steps("open")
        return io.BufferedRandom(Counted(path, "w+"))

    def counted(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            if name == "close":
                function(*arguments, **options)
                return steps(name)
            steps(name)
            return function(*arguments, **options)

        return call

    with (
        mock.patch.multiple(os, **{name: counted(name, getattr(os, name)) for name in _COUNTED}),
        mock.patch.object(fcntl, "flock", counted("flock", fcntl.flock)),
        mock.patch.object(publish, "open", opened, create=True),
    ):
        yield


def count_steps(action: Callable[[], None]) -> list[str]:
    """Names of the system steps an undisturbed run takes."""
    steps = Steps(0, die)
    with shimmed(steps):
        action()
    return steps.names


def in_child(action: Callable[[], None]) -> int:
    """Run in a forked process; DONE, REFUSED (an FpnavError) or KILLED, never a signal's death.

    Raises
    ------
    AssertionError
        The child died of a signal, or of another exception.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # forking with idle worker threads
        child = os.fork()
    if child == 0:
        _act_and_exit(action)
    _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    assert code in (DONE, REFUSED, KILLED), f"child ended with {code}"
    return code


def _act_and_exit(action: Callable[[], None]) -> None:
    code = 99
    try:
        action()
        code = DONE
    except FpnavError:
        code = REFUSED
    finally:
        os._exit(code)


def limited_to(size: int, action: Callable[[], None]) -> Callable[[], None]:
    """The action where no file may grow beyond ``size`` bytes."""

    def act() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        action()

    return act


def disturbed(at: int, act: Act, action: Callable[[], None]) -> Callable[[], None]:
    """The action with a fault at its Nth step."""

    def run() -> None:
        with shimmed(Steps(at, act)):
            action()

    return run


def leftovers(folder: Path) -> list[str]:
    """Temps and locks in a folder."""
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("."))


FULL_DISK = (errno.ENOSPC, errno.EIO, errno.EDQUOT)
