"""A full disk never crashes the process, and a foreign file is read as hostile."""

from __future__ import annotations

import io
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
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
from helpers.stores import edited, flips, truncations
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from fpnav.errors import FpnavError, StoreError
from fpnav.store.hdf5 import (
    CHUNK_ROWS,
    LatchingFile,
    create,
    has,
    opened,
    read_array,
    read_group,
    read_json,
    read_number,
    write_array,
    write_json,
)

VALUES = np.arange(3000.0)
ARRAYS = [
    np.arange(5), np.array([], dtype=np.float32), np.zeros((0, 3)), np.zeros((3, 0)),
    np.float32([[1, 2], [3, np.nan]]), np.array(0.5), np.array([True, False]),
    np.arange(CHUNK_ROWS * 3), np.ones((3, 50_000)), np.arange(24).reshape(2, 3, 4)[:, ::-1],
    np.array([(1, 2.5, b"ab")], dtype=[("a", "<i8"), ("b", "<f8", ()), ("c", "S4")]),
]  # fmt: skip


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "x.h5"


def write(path: Path, values: np.ndarray = VALUES) -> None:  # type: ignore[type-arg]
    with create(path) as file:
        write_json(file, "header", {"a": 1})
        write_array(file.create_group("group"), "values", values)


def read(path: Path) -> np.ndarray:  # type: ignore[type-arg]
    with opened(path) as file:
        return read_array(read_group(file, "group"), "values", VALUES.dtype)


def refused(path: Path) -> str:
    with pytest.raises(StoreError) as caught:
        read(path)
    return str(caught.value)


@pytest.mark.parametrize("values", ARRAYS, ids=str)
def test_arrays_come_back_as_they_were(path: Path, values: np.ndarray) -> None:  # type: ignore[type-arg]
    write(path, values)
    with opened(path) as file:
        found = read_array(file["group"], "values", values.dtype, ndim=values.ndim)
    assert found.dtype == values.dtype
    np.testing.assert_array_equal(found, values)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
@given(
    hnp.arrays(
        st.sampled_from([np.dtype(t) for t in ("<f8", "<f4", "<i8", "u1", "S5", "?", "<u2")]),
        hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=5),
    )
)
def test_any_array_comes_back_as_it_was(path: Path, values: np.ndarray) -> None:  # type: ignore[type-arg]
    write(path, values)
    with opened(path) as file:
        found = read_array(file["group"], "values", values.dtype, ndim=None)
    assert found.shape == values.shape
    assert found.tobytes() == values.tobytes()


def test_the_same_input_gives_the_same_bytes_a_second_later(path: Path) -> None:
    def everything() -> bytes:
        with create(path) as file:
            write_json(file, "header", {"a": 1})
            for number, values in enumerate(ARRAYS):
                write_array(file.require_group(f"group{number % 2}"), str(number), values)
        return path.read_bytes()

    first = everything()
    time.sleep(1.01)
    assert everything() == first


def test_json_comes_back_and_is_written_in_one_way_only(path: Path) -> None:
    value = {"b": [1, 2.5, None, "ä\x00"], "a": {"nested": True}}
    with create(path) as file:
        write_json(file, "header", value)
    with opened(path) as file:
        assert read_json(file, "header") == value
        assert bytes(file["header"][()]).startswith(b'{"a":{"nested":true},"b":[1,')


def test_json_never_holds_what_is_not_json(path: Path) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"), create(path) as file:
        write_json(file, "header", {"a": float("nan")})
    assert not path.exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"[1]", "is not a JSON object"),
        (b"{", "is not JSON"),
        (b"\xff", "is not JSON"),
        (b"[" * 100_000, "is not JSON"),
        (b"1" * 5000, "is not JSON"),
    ],
    ids=["list", "cut", "not-utf8", "nested", "long-number"],
)
def test_json_that_is_none_is_refused(path: Path, text: bytes, said: str) -> None:
    with create(path) as file:
        write_array(file, "header", np.frombuffer(text, dtype=np.uint8))
    with opened(path) as file, pytest.raises(StoreError, match=said):
        read_json(file, "header")


def test_a_number_is_one_value(path: Path) -> None:
    with create(path) as file:
        write_array(file, "one", np.array([0.5]))
        write_array(file, "two", np.array([0.5, 1.5]))
    with opened(path) as file:
        assert read_number(file, "one") == 0.5
        with pytest.raises(StoreError, match="two: 2 values, expected one"):
            read_number(file, "two")


def test_killed_at_any_step_leaves_the_old_file_or_the_new(path: Path) -> None:
    write(path, VALUES[:10])
    old = path.read_bytes()
    steps = count_steps(lambda: write(path))
    new = path.read_bytes()
    for step, name in enumerate(steps, start=1):
        path.write_bytes(old)
        assert in_child(disturbed(step, die, lambda: write(path))) == KILLED
        assert path.read_bytes() == (new if "replace" in steps[: step - 1] else old), name
        for left in leftovers(path.parent):
            path.with_name(left).unlink()
    write(path)
    assert path.read_bytes() == new
    assert leftovers(path.parent) == []


@pytest.mark.parametrize("number", FULL_DISK)
def test_a_disk_that_is_full_at_any_step_is_one_error(path: Path, number: int) -> None:
    write(path, VALUES[:10])
    old = path.read_bytes()
    steps = count_steps(lambda: write(path))
    new = path.read_bytes()
    for step in range(1, len(steps) + 1):
        path.write_bytes(old)
        code = in_child(disturbed(step, fail_with(number), lambda: write(path)))
        assert path.read_bytes() == (old if code == REFUSED and step < len(steps) - 5 else new)


@pytest.mark.parametrize("size", range(0, 32_000, 800))
def test_a_file_size_limit_never_ends_in_a_signal(path: Path, size: int) -> None:
    code = in_child(limited_to(size, lambda: write(path)))
    assert code == (DONE if path.exists() else REFUSED)
    if path.exists():
        np.testing.assert_array_equal(read(path), VALUES)
    assert leftovers(path.parent) == []


def test_the_error_of_a_full_disk_names_the_file_and_the_reason(path: Path) -> None:
    steps = count_steps(lambda: write(path))
    at = steps.index("write") + 1
    with pytest.raises(FpnavError, match=r"x\.h5: cannot be written: No space left on device"):
        disturbed(at, fail_with(FULL_DISK[0]), lambda: write(path))()


def test_an_exception_of_the_writer_passes_and_publishes_nothing(path: Path) -> None:
    with pytest.raises(ZeroDivisionError), create(path) as file:
        write_array(file, "values", VALUES / (1 // len(file)))
    assert list(path.parent.iterdir()) == []


class Asked(BaseException):
    pass


def test_a_signal_waits_until_hdf5_is_done_and_then_nothing_is_published(
    path: Path,
) -> None:
    def ask(number: int, frame: object) -> None:
        raise Asked

    done = []

    def write_asked() -> None:
        with create(path) as file:
            os.kill(os.getpid(), signal.SIGTERM)
            write_array(file, "values", VALUES)
            done.append(True)

    before = signal.signal(signal.SIGTERM, ask)
    try:
        with pytest.raises(Asked):
            write_asked()
    finally:
        signal.signal(signal.SIGTERM, before)
    assert done == [True]
    assert list(path.parent.iterdir()) == []


class Failing(io.BytesIO):
    """A stream whose calls fail from the Nth on."""

    def __init__(self, sound: int) -> None:
        super().__init__()
        self.left = sound

    def _count(self) -> None:
        self.left -= 1
        if self.left < 0:
            raise OSError(28, os.strerror(28))

    def write(self, data: object) -> int:
        self._count()
        return super().write(data)  # type: ignore[arg-type]

    def seek(self, offset: int, whence: int = 0) -> int:
        self._count()
        return super().seek(offset, whence)


@pytest.mark.parametrize("sound", range(12))
def test_the_latch_answers_as_if_nothing_had_happened(sound: int) -> None:
    latch = LatchingFile(Failing(sound))
    assert latch.write(b"abcd") == 4
    assert latch.seek(1) == 1
    assert latch.write(b"xy") == 2
    assert latch.tell() == 3
    assert latch.seek(0, io.SEEK_CUR) == 3
    end = latch.seek(0, io.SEEK_END)
    assert latch.seek(0) == 0
    assert latch.readinto(bytearray(end)) == end
    assert latch.truncate(2) == 2
    assert (latch.error is None) == (sound >= 6)


def test_the_latch_keeps_the_first_error_of_any_kind() -> None:
    class Interrupted(io.BytesIO):
        def write(self, data: object) -> int:
            raise KeyboardInterrupt

    latch = LatchingFile(Interrupted())
    assert latch.write(b"ab") == 2
    assert latch.write(b"ab") == 2
    assert isinstance(latch.error, KeyboardInterrupt)


def test_reading_beyond_the_end_gives_zeros() -> None:
    latch = LatchingFile(io.BytesIO(b"ab"))
    buffer = bytearray(b"1234")
    assert latch.readinto(buffer) == 4
    assert buffer == b"ab\0\0"


def test_missing_and_foreign_files_are_refused(path: Path) -> None:
    assert refused(path) == f"{path}: no such file"
    path.write_bytes(b"")
    assert "not sound HDF5" in refused(path)
    path.write_bytes(b"\x89MCAP0\r\n" * 100)
    assert "not sound HDF5" in refused(path)
    assert "not sound HDF5" in refused(path.parent)


def test_a_file_cut_anywhere_is_refused(path: Path) -> None:
    write(path, VALUES[:200])
    for _ in truncations(path, 41):
        assert "x.h5: " in refused(path)


def test_no_flipped_bit_is_read_as_another_value(path: Path) -> None:
    write(path, VALUES[:200])
    assert _silent(path, 400) == []


@pytest.mark.slow
def test_none_of_many_flipped_bits_is_read_as_another_value(path: Path) -> None:
    write(path, VALUES)
    assert _silent(path, 6000) == []


def _silent(path: Path, count: int) -> list[int]:
    def content() -> tuple[object, bytes]:
        with opened(path) as file:
            values = read_array(read_group(file, "group"), "values", VALUES.dtype)
            return read_json(file, "header"), values.tobytes()

    def differs() -> bool:
        try:
            return content() != sound
        except StoreError:
            return False

    sound = content()
    return [at for at in flips(path, count) if differs()]


def test_a_flipped_bit_of_a_single_value_is_detected(path: Path) -> None:
    with create(path) as file:
        write_array(file, "values", np.array(0.5))

    def differs() -> Iterator[bool]:
        for _ in flips(path, 300):
            try:
                with opened(path) as file:
                    yield float(read_array(file, "values", ndim=0)) != 0.5
            except StoreError:
                yield False

    assert not any(differs())


def hostile(path: Path, edit: Callable[[h5py.Group], object]) -> str:
    """What is said of a file whose values were put there by someone else."""
    write(path)

    def replace_values(file: h5py.File) -> None:
        del file["group/values"]
        edit(file["group"])

    return refused(edited(path, replace_values))


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    path = tmp_path / "secret.h5"
    with h5py.File(path, "w") as file:
        file["values"] = VALUES
    return path


def test_links_out_of_the_file_are_not_followed(path: Path, secret: Path) -> None:
    def external(group: h5py.Group) -> None:
        group["values"] = h5py.ExternalLink(str(secret), "/values")

    def soft(group: h5py.Group) -> None:
        group["values"] = h5py.SoftLink("/header")

    def loop(group: h5py.Group) -> None:
        group["values"] = h5py.SoftLink("/group/values")

    for link in (external, soft, loop):
        assert "group/values: a link is refused" in hostile(path, link)


def test_a_group_behind_a_link_is_not_entered(path: Path, secret: Path) -> None:
    def edit(file: h5py.File) -> None:
        del file["group"]
        file["group"] = h5py.ExternalLink(str(secret), "/")

    write(path)
    assert "/group: a link is refused" in refused(edited(path, edit))
    with opened(path) as file:
        assert has(file, "group")
        assert not has(file, "absent")


def test_data_outside_the_file_are_not_read(path: Path, secret: Path) -> None:
    def external(group: h5py.Group) -> None:
        outside = [(str(secret), 0, VALUES.nbytes)]
        group.create_dataset("values", VALUES.shape, VALUES.dtype, external=outside)

    def virtual(group: h5py.Group) -> None:
        layout = h5py.VirtualLayout(VALUES.shape, VALUES.dtype)
        layout[:] = h5py.VirtualSource(str(secret), "values", VALUES.shape, VALUES.dtype)
        group.create_virtual_dataset("values", layout)

    for edit in (external, virtual):
        assert "data outside the file or of object type is refused" in hostile(path, edit)


@pytest.mark.parametrize("shape", [(10**9,), (2**32, 2**32), (2**62,)], ids=str)
def test_claims_beyond_what_the_file_can_hold_are_refused(
    path: Path, shape: tuple[int, ...]
) -> None:
    def edit(group: h5py.Group) -> None:
        chunks = tuple(min(length, 100) for length in shape)
        group.create_dataset("values", shape, VALUES.dtype, chunks=chunks)

    said = hostile(path, edit)
    assert "more than the file can hold" in said
    assert str(int(np.prod([float(n) for n in shape]) * 8))[:3] in said


def test_other_types_shapes_filters_and_objects_are_refused(path: Path) -> None:
    def with_values(values: object, **options: object) -> str:
        return hostile(path, lambda group: group.create_dataset("values", data=values, **options))

    assert "type float32, expected float64" in with_values(np.float32([1]))
    assert "type >f8, expected float64" in with_values(np.array([1.0], dtype=">f8"))
    assert "shape (1, 1), expected 1 dimensions" in with_values(np.zeros((1, 1)))
    assert "shape (), expected 1 dimensions" in with_values(0.5)
    assert "of object type is refused" in with_values(["text"])
    assert "expected a dataset" in with_values(h5py.Empty("f8"))
    assert "filter 32000 is refused" in with_values(VALUES, compression="lzf")
    assert "expected a dataset" in hostile(path, lambda group: group.create_group("values"))


def test_what_is_missing_or_not_a_group_is_named(path: Path) -> None:
    assert "/group/values: missing" in hostile(path, lambda group: None)
    with opened(path) as file:
        with pytest.raises(StoreError, match=r"x\.h5: /header: expected a group"):
            read_group(file, "header")
        with pytest.raises(StoreError, match=r"x\.h5: /absent: missing"):
            read_group(file, "absent")


def test_a_file_that_was_compressed_by_another_tool_is_read(path: Path) -> None:
    write(path)

    def compress(file: h5py.File) -> None:
        del file["group/values"]
        file["group"].create_dataset("values", data=VALUES, compression="gzip", shuffle=True)

    np.testing.assert_array_equal(read(edited(path, compress)), VALUES)
