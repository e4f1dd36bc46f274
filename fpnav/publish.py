"""The only writer of final files: temp beside the target, fsync, verify, replace.

A killed run leaves the old target or the new one, never a mix. Temps are named
``.TARGET.PID.fptmp``; the next run on the same target removes those whose process is gone.
One writer per target: the loser fails at once. Devices and pipes cannot be replaced: what is meant
for them is kept in memory and written to them at the end, which is not atomic.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import os
import re
import shutil
import signal
import stat
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from fpnav.errors import FpnavError, UsageError

_TEMP = re.compile(r"\.(?P<target>.+)\.(?P<pid>\d+)\.fptmp", re.DOTALL)
_DEFERRED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGALRM)
_NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)
_NO_FOLDER_SYNC = (errno.EINVAL, errno.EACCES, errno.EPERM)


@contextlib.contextmanager
def publish(
    path: Path, *, clobber: bool = True, verify: Callable[[Path], None] | None = None
) -> Iterator[BinaryIO]:
    """Open a temp file for writing and put it in place of ``path`` when the block ends well.

    Parameters
    ----------
    path : final name; a symlink is followed, its target replaced
    clobber : False refuses an existing target before any work is done
    verify : called with the temp's path after fsync, before the replace; raises to refuse

    Raises
    ------
    FpnavError
        The folder cannot be written, the disk is full, another process writes the same target.
    """
    check_output(path, clobber=clobber)
    if _is_special(path):
        with _direct(path) as handle:
            yield handle
        return
    target = Path(os.path.realpath(path))
    temp = target.with_name(f".{target.name}.{os.getpid()}.fptmp")
    with _translated(path, target.name, temp.name, _lock_of(target).name), _locked(target):
        _remove_stale(target)
        try:
            with open(temp, "w+b") as handle:
                yield handle
                handle.flush()
                os.fsync(handle.fileno())
            if verify is not None:
                verify(temp)
            os.replace(temp, target)
        finally:
            with contextlib.suppress(OSError):
                temp.unlink()
    _sync_folder(target)


def publish_bytes(path: Path, data: bytes, *, clobber: bool = True) -> None:
    """Publish a small file whole."""
    with publish(path, clobber=clobber) as handle:
        handle.write(data)


def publish_once(path: Path, make: Callable[[], object]) -> None:
    """Have a file made unless it is there; where another worker is making it, wait for that."""
    if path.exists():
        return
    lock = path.with_name(f".{path.name}.making")
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # without a lock: publishing tells what is wrong
            handle = stack.enter_context(open(lock, "ab"))
            stack.callback(lock.unlink, missing_ok=True)
            fcntl.flock(handle, fcntl.LOCK_EX)
        if not path.exists():
            make()


def check_output(path: Path, *, inputs: Iterable[Path] = (), clobber: bool = True) -> None:
    """Refuse an impossible output before the work starts, not after 40 minutes.

    Raises
    ------
    UsageError
        The folder does not exist, the target is a folder or one of the inputs, or exists and
        ``clobber`` is off.
    FpnavError
        The folder cannot be written.
    """
    if _is_special(path):
        return
    target = Path(os.path.realpath(path))
    if not target.parent.is_dir():
        raise UsageError(
            f"{path}: folder {target.parent.name or '/'} does not exist; make it first"
        )
    if target.is_dir():
        raise UsageError(f"{path}: is a folder, expected a file name")
    if target.exists():
        for source in inputs:
            if source.exists() and os.path.samefile(source, target):
                raise UsageError(f"{path}: output is also an input; give another name with -o")
        if not clobber:
            raise UsageError(f"{path}: exists and --no-clobber is set")
    if not os.access(target.parent, os.W_OK):
        raise FpnavError(f"{path}: folder is not writable")


def file_digest(path: Path) -> str:
    """sha256 of a file's bytes, as hex."""
    with open(path, "rb") as handle:
        return hashlib.file_digest(handle, "sha256").hexdigest()


@contextlib.contextmanager
def scratch_copy(path: Path) -> Iterator[Any]:
    """A named temporary copy of a file to change at will; gone when the block ends."""
    with tempfile.NamedTemporaryFile(prefix="fpnav-", suffix=path.suffix) as copy:
        with open(path, "rb") as handle:
            shutil.copyfileobj(handle, copy)
        copy.seek(0)
        yield copy


@contextlib.contextmanager
def signals_deferred() -> Iterator[None]:
    """Signals that end the process wait until the block is over.

    Blocking them would not do: another thread may take them, and Python still acts in this one.
    """
    came: list[int] = []
    before = _handlers() if threading.current_thread() is threading.main_thread() else {}
    try:
        for number in before:
            signal.signal(number, lambda number, frame: came.append(number))
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])


def _handlers() -> dict[signal.Signals, Any]:
    """What is done now on each signal that ends the process, but for those that are ignored."""
    now = {number: signal.getsignal(number) for number in _DEFERRED}
    return {number: do for number, do in now.items() if do not in (None, signal.SIG_IGN)}


def _is_special(path: Path) -> bool:
    """A device, pipe or socket, /dev/stdout among them; false where there is nothing."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


@contextlib.contextmanager
def _direct(path: Path) -> Iterator[BinaryIO]:
    with open(os.memfd_create("fpnav"), "w+b") as handle:
        yield handle
        handle.seek(0)
        with _translated(path), open(path, "wb") as special:
            shutil.copyfileobj(handle, special)


@contextlib.contextmanager
def _translated(path: Path, *names: str) -> Iterator[None]:
    """Turn the OSErrors of writing ``path`` into FpnavErrors; those that name other files pass."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.filename is not None and Path(error.filename).name not in (path.name, *names):
            raise
        raise FpnavError(
            f"{path}: cannot be written: {os.strerror(error.errno or errno.EIO)}; "
            "the previous file, if any, is untouched"
        ) from error


@contextlib.contextmanager
def _locked(target: Path) -> Iterator[None]:
    """Hold the folder-side lock of one target; the lock file itself is removed at the end."""
    lock, handle = _lock_of(target), -1
    try:
        with signals_deferred():
            handle = _acquire(lock, target)
        os.ftruncate(handle, 0)
        os.pwrite(handle, f"{os.getpid()}\n".encode(), 0)
        yield
    finally:
        if handle >= 0:
            with signals_deferred():
                _release(lock, handle)


def _lock_of(target: Path) -> Path:
    return target.with_name(f".{target.name}.lock")


def _acquire(lock: Path, target: Path) -> int:
    """File descriptor of the held lock; taken anew where its holder removed the file meanwhile."""
    while True:
        handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = os.pread(handle, 32, 0).decode(errors="replace").strip() or "unknown"
            os.close(handle)
            raise FpnavError(f"{target}: process {owner} is writing it; wait for it") from None
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                os.close(handle)
                raise
            return handle  # a share without locks: the rename alone keeps the target whole
        with contextlib.suppress(FileNotFoundError):
            if os.stat(lock).st_ino == os.fstat(handle).st_ino:
                return handle
        os.close(handle)


def _release(lock: Path, handle: int) -> None:
    with contextlib.suppress(OSError):
        lock.unlink()
    with contextlib.suppress(OSError):
        os.close(handle)


def _remove_stale(target: Path) -> None:
    """Remove temps of this target left by processes that are gone."""
    for candidate in target.parent.glob(f".{_escape(target.name)}.*.fptmp"):
        match = _TEMP.fullmatch(candidate.name)
        if match and match["target"] == target.name and not _alive(int(match["pid"])):
            with contextlib.suppress(OSError):
                candidate.unlink()


def _escape(name: str) -> str:
    return re.sub(r"([*?\[])", r"[\1]", name)


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def _sync_folder(target: Path) -> None:
    """Make the replace outlast a power loss, where the file system can promise that."""
    try:
        handle = os.open(target.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError as error:
        if error.errno not in _NO_FOLDER_SYNC:
            raise FpnavError(
                f"{target}: written whole, but its folder cannot be synced: {error.strerror}"
            ) from error
