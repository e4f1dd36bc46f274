"""The old target or the new one, never a mix, whatever happens while it is written."""

from __future__ import annotations

import errno
import fcntl
import multiprocessing
import os
import signal
import stat
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from helpers.faults import (
    DONE,
    FULL_DISK,
    KILLED,
    REFUSED,
    count_steps,
    die,
    disturbed,
    fail_with,
    in_child,
    leftovers,
    limited_to,
)

from fpnav.errors import FpnavError, UsageError
from fpnav.publish import check_output, file_digest, publish, publish_bytes, publish_once

OLD, NEW = b"old and whole", b"new " * 5000
DEAD = 2**22 + 1
"""A process id beyond the kernel's largest."""


@pytest.fixture
def target(tmp_path: Path) -> Path:
    path = tmp_path / "map.h5"
    path.write_bytes(OLD)
    return path


def write_then(path: Path, act: Callable[[], object]) -> None:
    with publish(path) as handle:
        handle.write(NEW)
        act()


def raise_(error: BaseException) -> None:
    raise error


def write_new(path: Path) -> Callable[[], None]:
    def write() -> None:
        with publish(path) as handle:
            for start in range(0, len(NEW), 4096):
                handle.write(NEW[start : start + 4096])

    return write


def test_a_block_that_ends_well_replaces_the_target(target: Path) -> None:
    publish_bytes(target, NEW)
    assert target.read_bytes() == NEW
    assert leftovers(target.parent) == []


def test_nothing_stands_under_the_final_name_while_the_block_runs(tmp_path: Path) -> None:
    target = tmp_path / "new.h5"
    with publish(target) as handle:
        handle.write(NEW)
        assert not target.exists()
    assert target.read_bytes() == NEW


def test_an_exception_in_the_block_leaves_the_old_target(target: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        write_then(target, lambda: raise_(ZeroDivisionError()))
    assert target.read_bytes() == OLD
    assert leftovers(target.parent) == []


def test_a_keyboard_interrupt_leaves_the_old_target_and_no_temp(target: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        write_then(target, lambda: raise_(KeyboardInterrupt()))
    assert target.read_bytes() == OLD
    assert leftovers(target.parent) == []


def test_a_verification_that_refuses_leaves_the_old_target(target: Path) -> None:
    seen = []

    def refuse(temp: Path) -> None:
        seen.append(temp.read_bytes())
        raise FpnavError("does not open again")

    with pytest.raises(FpnavError, match="open again"), publish(target, verify=refuse) as handle:
        handle.write(NEW)
    assert seen == [NEW]
    assert target.read_bytes() == OLD
    assert leftovers(target.parent) == []


def test_killed_at_any_step_leaves_old_or_new_and_the_next_run_completes(target: Path) -> None:
    write = write_new(target)
    steps = count_steps(write)
    assert steps.count("write") > 1
    assert steps.count("fsync") == 2
    for step in range(1, len(steps) + 1):
        target.write_bytes(OLD)
        assert in_child(disturbed(step, die, write)) == KILLED
        replaced = "replace" in steps[: step - 1]
        assert target.read_bytes() == (NEW if replaced else OLD), steps[step - 1]
        write()
        assert target.read_bytes() == NEW
        assert leftovers(target.parent) == [], steps[step - 1]


@pytest.mark.parametrize("number", FULL_DISK)
def test_an_error_at_any_step_is_refused_with_the_old_target_whole(
    target: Path, number: int
) -> None:
    write = write_new(target)
    steps = count_steps(write)
    for step, name in enumerate(steps, start=1):
        target.write_bytes(OLD)
        said = message_of(disturbed(step, fail_with(number), write))
        assert os.strerror(number) in said or (name in ("unlink", "close") and not said)
        assert target.read_bytes() == (OLD if "untouched" in said else NEW), name


def message_of(action: Callable[[], None]) -> str:
    try:
        action()
    except FpnavError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("number", FULL_DISK)
def test_after_an_error_the_next_run_completes(target: Path, number: int) -> None:
    for step in range(1, len(count_steps(write_new(target))) + 1):
        in_child(disturbed(step, fail_with(number), write_new(target)))
        publish_bytes(target, NEW)
        assert leftovers(target.parent) == []


@pytest.mark.parametrize("size", range(0, len(NEW) + 1000, 1000))
def test_a_file_size_limit_ends_in_one_error_and_no_signal(target: Path, size: int) -> None:
    code = in_child(limited_to(size, write_new(target)))
    assert code == (DONE if size >= len(NEW) else REFUSED)
    assert target.read_bytes() == (NEW if code == DONE else OLD)
    assert leftovers(target.parent) == []


def test_real_kills_at_odd_moments_leave_a_whole_file(target: Path) -> None:
    _kill_rounds(target, 12)


@pytest.mark.slow
def test_many_real_kills_leave_a_whole_file(target: Path) -> None:
    _kill_rounds(target, 200)


def _kill_rounds(target: Path, rounds: int) -> None:
    for number in range(rounds):
        child = multiprocessing.get_context("fork").Process(target=_write_for_ever, args=(target,))
        child.start()
        time.sleep(0.002 + 0.0013 * (number % 12))
        os.kill(child.pid or 0, signal.SIGKILL)
        child.join()
        assert target.read_bytes() in (OLD, NEW, NEW[::-1])
    publish_bytes(target, OLD)
    assert leftovers(target.parent) == []


def _write_for_ever(target: Path) -> None:
    while True:
        publish_bytes(target, NEW)
        publish_bytes(target, NEW[::-1])


def test_temps_of_processes_that_are_gone_are_removed(target: Path) -> None:
    stale = target.with_name(f".map.h5.{DEAD}.fptmp")
    huge = target.with_name(f".map.h5.{10**30}.fptmp")
    for path in (stale, huge):
        path.write_bytes(b"half")
    publish_bytes(target, NEW)
    assert leftovers(target.parent) == []


def test_temps_of_living_processes_and_of_other_targets_stay(target: Path) -> None:
    living = target.with_name(f".map.h5.{os.getppid()}.fptmp")
    other = target.with_name(f".other.map.h5.{DEAD}.fptmp")
    for path in (living, other):
        path.write_bytes(b"half")
    publish_bytes(target, NEW)
    assert leftovers(target.parent) == sorted([living.name, other.name])


@pytest.mark.parametrize("name", ["a*b.h5", "a[1]?.h5", "-x.h5", "line\nfeed.h5", "ä ö.h5"])
def test_odd_names_are_written_and_cleaned_like_any_other(tmp_path: Path, name: str) -> None:
    target = tmp_path / name
    target.with_name(f".{name}.{DEAD}.fptmp").write_bytes(b"half")
    publish_bytes(target, NEW)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_names_that_are_not_utf8_are_written(tmp_path: Path) -> None:
    target = tmp_path / os.fsdecode(b"\xff\xfe.h5")
    publish_bytes(target, NEW)
    assert target.read_bytes() == NEW


def test_the_second_writer_of_a_target_is_refused_and_told_who_writes(target: Path) -> None:
    with publish(target) as handle:
        handle.write(NEW)
        with (
            pytest.raises(FpnavError, match=f"process {os.getpid()} is writing it"),
            publish(target),
        ):
            pass
        assert in_child(write_new(target)) == REFUSED
    assert target.read_bytes() == NEW


def test_of_many_writers_at_once_every_one_wins_or_is_refused(target: Path) -> None:
    context = multiprocessing.get_context("fork")
    children = [context.Process(target=in_child, args=(write_new(target),)) for _ in range(8)]
    for child in children:
        child.start()
    reads = set()
    while any(child.is_alive() for child in children):
        reads.add(target.read_bytes())
    for child in children:
        child.join()
        assert child.exitcode == 0
    assert reads <= {OLD, NEW}
    publish_bytes(target, OLD)
    assert leftovers(target.parent) == []


def test_a_lock_removed_by_its_holder_is_taken_anew(target: Path) -> None:
    lock = target.with_name(".map.h5.lock")
    held = os.open(lock, os.O_RDWR | os.O_CREAT)
    fcntl.flock(held, fcntl.LOCK_EX)
    lock.unlink()
    publish_bytes(target, NEW)
    os.close(held)
    assert target.read_bytes() == NEW


def test_a_share_without_locks_is_written_all_the_same(
    target: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_locks(handle: int, operation: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", no_locks)
    publish_bytes(target, NEW)
    assert target.read_bytes() == NEW
    assert leftovers(target.parent) == []


def test_a_symlink_is_followed_and_stays_a_symlink(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    real = tmp_path / "store" / "real.h5"
    link = tmp_path / "link.h5"
    link.symlink_to(real)
    publish_bytes(link, NEW)
    assert link.is_symlink()
    assert real.read_bytes() == NEW
    assert leftovers(tmp_path) == leftovers(real.parent) == []


def test_an_error_behind_a_symlink_names_what_was_asked_for(tmp_path: Path) -> None:
    link = tmp_path / "link.h5"
    link.symlink_to(tmp_path / "real.h5")
    with pytest.raises(FpnavError, match=r"link\.h5: cannot be written: Is a directory"):
        write_then(link, (tmp_path / "real.h5").mkdir)
    assert leftovers(tmp_path) == []


def test_a_name_too_long_for_a_temp_is_one_error(tmp_path: Path) -> None:
    with pytest.raises(FpnavError, match="File name too long"):
        publish_bytes(tmp_path / ("n" * 250), NEW)
    assert list(tmp_path.iterdir()) == []


def test_errors_of_other_files_pass_as_they_are(target: Path) -> None:
    with pytest.raises(FileNotFoundError), publish(target) as handle:
        handle.write(target.with_name("absent").read_bytes())
    assert target.read_bytes() == OLD


def test_a_pipe_gets_all_bytes_and_stays_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    with publish(pipe) as handle:
        handle.seek(len(NEW) - 4)
        handle.write(NEW[-4:])
        handle.seek(0)
        handle.write(NEW[:-4])
    reader.join()
    assert got == [NEW]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert leftovers(tmp_path) == []


def test_a_device_is_written_and_never_replaced() -> None:
    check_output(Path("/dev/null"), clobber=False)
    publish_bytes(Path("/dev/null"), NEW)
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


def test_a_full_device_is_one_error() -> None:
    with pytest.raises(FpnavError, match="/dev/full: cannot be written: No space left"):
        publish_bytes(Path("/dev/full"), NEW)


def test_no_clobber_refuses_an_existing_target_before_the_block_runs(target: Path) -> None:
    with pytest.raises(UsageError, match="exists and --no-clobber"), publish(target, clobber=False):
        pytest.fail("the block ran")
    publish_bytes(target.with_name("fresh.h5"), NEW, clobber=False)
    assert target.read_bytes() == OLD


def test_an_output_that_is_an_input_is_refused_by_inode(target: Path) -> None:
    link, hard = target.with_name("link.h5"), target.with_name("hard.h5")
    link.symlink_to(target)
    hard.hardlink_to(target)
    for other in (target, link, hard):
        with pytest.raises(UsageError, match="output is also an input"):
            check_output(other, inputs=[target.with_name("absent"), target])
    check_output(target.with_name("new.h5"), inputs=[target])


def test_impossible_outputs_are_refused_before_the_work(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="folder nowhere does not exist"):
        check_output(tmp_path / "nowhere" / "map.h5")
    with pytest.raises(UsageError, match="is a folder"):
        check_output(tmp_path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write to read-only folders")
def test_a_read_only_folder_is_refused_before_the_work(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    try:
        with pytest.raises(FpnavError, match="folder is not writable"):
            check_output(tmp_path / "map.h5")
    finally:
        tmp_path.chmod(0o755)


def test_a_digest_is_that_of_the_bytes(tmp_path: Path) -> None:
    path = tmp_path / "abc"
    path.write_bytes(b"abc")
    assert file_digest(path).startswith("ba7816bf8f01cfea414140de5dae2223")


def test_workers_that_share_a_file_make_it_once(tmp_path: Path) -> None:
    path, made = tmp_path / "log", list[str]()

    def make(name: str) -> None:
        made.append(name)
        time.sleep(0.2)
        path.write_text(name)

    workers = [
        threading.Thread(target=publish_once, args=(path, partial(make, name))) for name in "ab"
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert made == [path.read_text()]
    assert [entry.name for entry in tmp_path.iterdir()] == ["log"]
