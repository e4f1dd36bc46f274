"""HDF5 done carefully: written through a latching file object, read as hostile input.

HDF5 crashes the process when a write fails, so it never sees a raw path: it writes to an object
that remembers the first error and answers "ok" until the file is closed. What a signal handler
raises inside HDF5 is swallowed, so signals wait until then too.
"""

from __future__ import annotations

import contextlib
import errno
import io
import json
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.publish import publish, signals_deferred

CHUNK_ROWS = 16384
_EXPANSION = 1000
_FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}
_LAYOUT = ("v110", "v110")
_OPENING = (OSError, RuntimeError)
_READING = (*_OPENING, KeyError, ValueError, TypeError)


class LatchingFile(io.RawIOBase):
    """File object that remembers the first error instead of raising it to HDF5."""

    def __init__(self, stream: BinaryIO) -> None:
        super().__init__()
        self._stream = stream
        self.error: BaseException | None = None
        self._position = 0

    def write(self, data: Any) -> int:
        """Write, or pretend to after an error."""
        size = memoryview(data).nbytes
        self._guard(lambda: self._write_at(data))
        self._position += size
        return size

    def readinto(self, buffer: Any) -> int:
        """Read into a buffer; zeros after an error."""
        view = memoryview(buffer).cast("B")
        view[:] = bytes(len(view))
        self._guard(lambda: self._read_at(view))
        self._position += len(view)
        return len(view)

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move the position."""
        if whence == io.SEEK_END:
            self._guard(self._to_end)
        self._position = offset if whence == io.SEEK_SET else self._position + offset
        return self._position

    def tell(self) -> int:
        """The position."""
        return self._position

    def truncate(self, size: int | None = None) -> int:
        """Set the length."""
        length = self._position if size is None else size
        self._guard(lambda: self._stream.truncate(length))
        return length

    def flush(self) -> None:
        """Flush what can be flushed."""
        self._guard(self._stream.flush)

    def _guard(self, action: Callable[[], object]) -> None:
        if self.error is None:
            try:
                action()
            except BaseException as error:
                self.error = error

    def _write_at(self, data: Any) -> None:
        self._stream.seek(self._position)
        self._stream.write(data)

    def _read_at(self, view: memoryview) -> None:
        self._stream.seek(self._position)
        data = self._stream.read(len(view))
        view[: len(data)] = data

    def _to_end(self) -> None:
        self._position = self._stream.seek(0, io.SEEK_END)


@contextlib.contextmanager
def create(path: Path, *, clobber: bool = True) -> Iterator[h5py.File]:
    """New HDF5 file, published when the block ends well, and reopened before that.

    Raises
    ------
    FpnavError
        It cannot be written; the old file is untouched.
    """
    with publish(path, clobber=clobber, verify=_verify) as stream:
        latch = LatchingFile(stream)
        try:
            with signals_deferred(), latch, h5py.File(latch, "w", libver=_LAYOUT) as file:
                yield file
        except Exception:
            if latch.error is None:
                raise
        if isinstance(latch.error, OSError):
            raise OSError(latch.error.errno or errno.EIO, latch.error.strerror, str(path))
        if latch.error is not None:
            raise latch.error


def _verify(path: Path) -> None:
    try:
        with h5py.File(path, "r") as file:
            list(file)
    except OSError as error:
        raise StoreError(f"{path}: written file does not open again: {error}") from error


@contextlib.contextmanager
def opened(path: Path) -> Iterator[h5py.File]:
    """Existing HDF5 file for reading, foreign exceptions translated.

    Raises
    ------
    StoreError
        Missing, not HDF5, truncated or with a checksum that does not fit.
    """
    if not path.exists():
        raise StoreError(f"{path}: no such file")
    with _translated(str(path)), h5py.File(path, "r", locking=False) as file:
        yield file


@contextlib.contextmanager
def _translated(where: str, foreign: tuple[type[Exception], ...] = _OPENING) -> Iterator[None]:
    """Turn what h5py raises on a damaged file into one StoreError."""
    try:
        yield
    except foreign as error:
        text = str(error).strip("'\"").splitlines() or [type(error).__name__]
        raise StoreError(f"{where}: not sound HDF5: {text[0]}; make the file again") from error


def write_array(group: h5py.Group, name: str, values: NDArray[Any]) -> None:
    """Dataset with checksums; rows are stored in chunks, a single value in the checked header."""
    array = np.asarray(values, order="C")
    if array.ndim == 0:
        _write_scalar(group, name, array)
    elif array.size == 0:
        group.create_dataset(name, data=array)
    else:
        rows = max(1, min(len(array), CHUNK_ROWS * 8 // max(1, array[0].nbytes)))
        group.create_dataset(name, data=array, chunks=(rows, *array.shape[1:]), fletcher32=True)


def _write_scalar(group: h5py.Group, name: str, value: NDArray[Any]) -> None:
    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_layout(h5py.h5d.COMPACT)
    layout.set_obj_track_times(False)
    kind, space = h5py.h5t.py_create(value.dtype, logical=True), h5py.h5s.create(h5py.h5s.SCALAR)
    dataset = h5py.h5d.create(group.id, name.encode(), kind, space, layout)
    dataset.write(h5py.h5s.ALL, h5py.h5s.ALL, value)


def read_array(
    group: h5py.Group, name: str, dtype: np.dtype[Any] | None = None, *, ndim: int | None = 1
) -> NDArray[Any]:
    """Dataset of that name, whole; only plain datasets inside the file are followed.

    Parameters
    ----------
    dtype, ndim : what it must be; None = anything

    Raises
    ------
    StoreError
        Absent, damaged, a link out of the file, another type or shape than expected, larger than
        the file can hold.
    """
    where = f"{group.file.filename}: {group.name.rstrip('/')}/{name}"
    with _translated(where, _READING):
        dataset = _inside(group, name, where)
        if not isinstance(dataset, h5py.Dataset) or dataset.shape is None:
            raise StoreError(f"{where}: expected a dataset")
        _check_dataset(dataset, where)
        if dtype is not None and dataset.dtype != dtype:
            raise StoreError(f"{where}: type {dataset.dtype}, expected {dtype}")
        if ndim is not None and dataset.ndim != ndim:
            raise StoreError(f"{where}: shape {dataset.shape}, expected {ndim} dimensions")
        return np.asarray(dataset[()], dtype=dataset.dtype)


def read_number(group: h5py.Group, name: str) -> float:
    """The one value of a dataset that holds one; raises StoreError where it does not."""
    values = read_array(group, name, np.dtype(np.float64))
    if len(values) != 1:
        raise StoreError(f"{group.file.filename}: {name}: {len(values)} values, expected one")
    return float(values[0])


def read_group(group: h5py.Group, name: str) -> h5py.Group:
    """Group of that name inside the file; raises StoreError where it is not one."""
    where = f"{group.file.filename}: {group.name.rstrip('/')}/{name}"
    with _translated(where, _READING):
        found = _inside(group, name, where)
    if not isinstance(found, h5py.Group):
        raise StoreError(f"{where}: expected a group")
    return found


def has(group: h5py.Group, name: str) -> bool:
    """Whether the group has a member of that name; links are not followed."""
    return group.get(name, getlink=True) is not None


def _inside(group: h5py.Group, name: str, where: str) -> Any:
    """Member of a group that is stored in this file."""
    link = group.get(name, getlink=True)
    if link is None:
        raise StoreError(f"{where}: missing")
    if not isinstance(link, h5py.HardLink):
        raise StoreError(f"{where}: a link is refused, expected the data itself")
    return group[name]


def _check_dataset(dataset: h5py.Dataset, where: str) -> None:
    if dataset.external or dataset.is_virtual or dataset.dtype.hasobject:
        raise StoreError(f"{where}: data outside the file or of object type is refused")
    plist = dataset.id.get_create_plist()
    filters = {plist.get_filter(number)[0] for number in range(plist.get_nfilters())}
    if not filters <= _FILTERS:
        raise StoreError(f"{where}: filter {min(filters - _FILTERS)} is refused")
    size = math.prod(dataset.shape) * dataset.dtype.itemsize
    if size > _EXPANSION * Path(dataset.file.filename).stat().st_size:
        raise StoreError(f"{where}: claims {size} bytes, more than the file can hold")


def write_json(group: h5py.Group, name: str, value: Mapping[str, Any]) -> None:
    """JSON object as a checksummed byte dataset: attributes are bounded in size, this is not."""
    text = json.dumps(value, sort_keys=True, allow_nan=False, separators=(",", ":"))
    write_array(group, name, np.frombuffer(text.encode(), dtype=np.uint8))


def read_json(group: h5py.Group, name: str) -> dict[str, Any]:
    """JSON object written by ``write_json``; raises StoreError where it is not one."""
    try:
        value = json.loads(read_array(group, name, np.dtype(np.uint8)).tobytes())
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{group.file.filename}: {name} is not JSON: {error}") from error
    if not isinstance(value, dict):
        raise StoreError(f"{group.file.filename}: {name} is not a JSON object")
    return value
