"""A folder of images: images.csv (stamp_s,file) and, where the way is known, truth.tum.

What the images are is said with ``role``: camera (the default), panorama or omni. images.csv
names files of its own folder only.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath

from fpnav.errors import LogError, UsageError
from fpnav.logs import limits
from fpnav.logs.container import Damaged
from fpnav.logs.images import encoded_size, format_of
from fpnav.logs.ledger import Ledger
from fpnav.logs.sources.base import Item, Picture, SourceOptions
from fpnav.logs.text import lines, text_facts
from fpnav.logs.tum import read_poses

SUMMARY = "folder of images with images.csv (stamp_s,file) and truth.tum"

LIST = "images.csv"
TRUTH = "truth.tum"
_ROLES = ("camera", "panorama", "omni", "camera_offset")


def recognises(path: Path, head: bytes) -> bool:
    """A folder with images.csv, or that file itself."""
    return (path / LIST).is_file() or path.name == LIST


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Images and true poses of one folder after another, merged in time."""
    role = options.role or "camera"
    if role not in _ROLES:
        raise UsageError(f"--role {role}: images can be {', '.join(_ROLES)}")
    for path in paths:
        folder = path if path.is_dir() else path.parent
        ledger.inputs.append(text_facts(folder / LIST))
        items = [*_pictures(folder, role, options, ledger), *_truth(folder, ledger)]
        if not any(item.role == role for item in items):
            raise LogError(f"{folder / LIST}: E206 names no image that can be read")
        for item in sorted(items, key=lambda item: item.stamp_ns):
            yield _loaded(folder, item)


def _pictures(folder: Path, role: str, options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """One item per image that is whole, its value still a file name; calibration first."""
    calibrated = False
    for number, stamp_ns, name in _rows(folder / LIST):
        count = ledger.topic(f"/{role}")
        try:
            width, height = encoded_size(_bytes(folder, number, name))
        except Damaged as damage:
            count.skipped[damage.code] += 1
            ledger.note(damage.code, f"{name}: {damage.reason}")
            continue
        if not calibrated:
            calibrated = True
            yield Item(f"calibration:{role}", stamp_ns, options.calibration_for(width, height))
        count.used += 1
        yield Item(role, stamp_ns, name)


def _rows(path: Path) -> Iterator[tuple[int, int, str]]:
    """(line number, stamp, file name) of every row of images.csv."""
    numbered = lines(path)
    header = [word.strip() for word in next(numbered, (0, ""))[1].split(",")]
    if "stamp_s" not in header or "file" not in header:
        raise LogError(f"{path}: first line is {','.join(header)!r}, expected stamp_s,file")
    at, name_at = header.index("stamp_s"), header.index("file")
    for number, text in numbered:
        if not text.strip():
            continue
        row = next(csv.reader([text]))
        try:
            yield number, round(float(row[at]) * 1e9), row[name_at].strip()
        except (ValueError, IndexError, OverflowError):
            raise LogError(f"{path} line {number}: {text!r}, expected stamp_s,file") from None


def _bytes(folder: Path, number: int, name: str) -> bytes:
    """An image file's bytes; the list may not lead out of its folder."""
    parts = PurePosixPath(name).parts
    if not parts or ".." in parts or PurePosixPath(name).is_absolute() or "\x00" in name:
        raise LogError(f"{folder / LIST} line {number}: {name!r} is not a file of the folder")
    path = folder / name
    try:
        if path.stat().st_size > limits.MESSAGE_BYTES:
            raise Damaged("E407", f"{name} is over the size limit")
        return path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}") from error


def _truth(folder: Path, ledger: Ledger) -> Iterator[Item]:
    path = folder / TRUTH
    if not path.is_file():
        return
    ledger.inputs.append(text_facts(path))
    for stamp_ns, pose in read_poses(path, ledger):
        ledger.topic("/truth").used += 1
        yield Item("truth", stamp_ns, pose)


def _loaded(folder: Path, item: Item) -> Item:
    """The item with its picture's bytes in place of the file name."""
    if not isinstance(item.value, str):
        return item
    data = _bytes(folder, 0, item.value)
    return Item(item.role, item.stamp_ns, Picture(data, format_of(data)))
