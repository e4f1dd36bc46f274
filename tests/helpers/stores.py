"""Small files of every kind, and ways to damage them."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from helpers.toy_system import RECORD, Toy, drive, mixed, signature_of

from fpnav.mapping.build import build_map
from fpnav.store.header import MAP, RESULT, SIGNATURES, make_header
from fpnav.store.maps import BuiltMap
from fpnav.store.signatures import collect
from fpnav.store.tables import EDGE, Accepted, MapView, Ragged, Result, SignatureTable
from fpnav.values import Pose2, Reference, Signature

PARTS = Toy.PARTS


def header(kind: str, **facts: Any) -> dict[str, Any]:
    source = {"name": "drive.mcap", "sha256": "ab" * 32, "bytes": 1234}
    return make_header(
        kind, system="toy", preset="default", params={"theta": 0.5}, sources=[source], **facts
    )


SIGNATURES_HEADER, MAP_HEADER = header(SIGNATURES), header(MAP, chain=[header(SIGNATURES)])
RESULT_HEADER = header(RESULT, method="filter")


def signatures() -> list[Signature]:
    """Signatures whose parts differ in length, one of them empty, some facts unknown."""
    full = Reference(
        index=7,
        stamp_ns=1_700_000_000_123_456_789,
        session=1,
        travelled_m=2.5,
        odometry=Pose2(1.0, -2.0, 3.0),
        truth=Pose2(1.5, -2.5, -3.0),
        heading_rad=0.25,
        label="Küche",
    )
    return [
        signature_of(Reference(0, 0), [0.25, 0.75], detail=3.0),
        signature_of(Reference(3, -5, travelled_m=1.0), []),
        signature_of(full, [1.0, 0.0, 0.0]),
    ]


def table() -> SignatureTable:
    return collect(signatures(), RECORD, PARTS)


def built_map() -> BuiltMap:
    """Three places in two sessions, with labels, edges and what the toy memory learned."""
    rows = drive([0, 0, 1, 1, 1], labels=["hall"] * 5) + drive([2, 2], session=1)
    rows.append(signature_of(Reference(9, 9, 1, 7.0), mixed(2, 3, 0.1)))
    found = build_map(Toy(), rows, advance=lambda done: None)
    state = found.memory.save()
    return BuiltMap(
        found.topomap, collect(rows, RECORD, PARTS), found.novelty, found.threshold, state
    )


def result(*, pairs: bool = False) -> Result:
    """Two queries, three references, two places, ranks cut at two; NaN and -inf where allowed."""
    rows = table().references
    view = MapView(
        place_ids=np.array([4, 9]),
        place_pose=np.array([[0.0, 1.0, 2.0], [3.0, np.nan, 5.0]]),
        extent_m=np.array([1.0, 0.0]),
        edges=np.array([(4, 9, 1.5, 0.1, np.nan, 2)], dtype=EDGE),
        novelty=np.array([np.nan, 0.25, 0.5]),
        threshold=np.nan,
        strips=("ab", "ä→\x00"),
    )
    accepted = Ragged(np.array([2, 0, 1]), np.array([0, 1, 3])) if pairs else None
    return Result(
        header=RESULT_HEADER,
        queries=rows[:2],
        references=rows,
        owner=np.array([4, 4, 9]),
        candidates=np.array([3, 3]),
        places=np.array([[9, 4], [4, -1]]),
        members=np.array([[2, -1], [-1, -1]]),
        scores=np.array([[0.75, 0.5], [0.25, -np.inf]]),
        headings_rad=np.array([[0.5, np.nan], [np.nan, np.nan]]),
        decision=np.array([9, -1]),
        stated=np.array([0.75, np.nan]),
        entropy=np.array([0.5, np.nan]),
        belief=np.array([[0.25, 0.75], [0.5, 0.5]], dtype=np.float32),
        relative=np.array([[0.5, 0.0, -0.5], [np.nan] * 3]),
        covariance=np.full((2, 3, 3), 0.5),
        truth=Accepted("pairs" if pairs else "poses", "truth topic", accepted),
        view=view,
        query_strips=("", "x"),
    )


def edited(path: Path, edit: Callable[[h5py.File], object]) -> Path:
    """The file after an edit through plain h5py."""
    with h5py.File(path, "r+") as file:
        edit(file)
    return path


def replaced(path: Path, name: str, values: Any, **options: Any) -> Path:
    """The file with one dataset replaced."""

    def edit(file: h5py.File) -> None:
        del file[name]
        file.create_dataset(name, data=values, **options)

    return edited(path, edit)


def flips(path: Path, count: int, *, seed: int = 1) -> Iterator[int]:
    """Flip one bit after the other, each alone, and give its position while it is flipped."""
    sound = path.read_bytes()
    rng = random.Random(seed)
    for _ in range(count):
        at, bit = rng.randrange(len(sound)), 1 << rng.randrange(8)
        damaged = bytearray(sound)
        damaged[at] ^= bit
        path.write_bytes(damaged)
        yield at
    path.write_bytes(sound)


def truncations(path: Path, every: int) -> Iterator[int]:
    """Cut the file at one length after the other."""
    sound = path.read_bytes()
    for length in range(0, len(sound), every):
        path.write_bytes(sound[:length])
        yield length
    path.write_bytes(sound)


def contents(value: Any) -> Any:
    """Any stored value as something that compares equal where it is equal, NaN included."""
    if isinstance(value, np.ndarray):
        fields = value.dtype.names or ()
        kinds = [(name, value.dtype[name].str, value.dtype[name].shape) for name in fields]
        return (value.dtype.str, kinds, value.shape, value.tobytes())
    if isinstance(value, dict):
        return {key: contents(member) for key, member in value.items()}
    if isinstance(value, SignatureTable | Ragged | MapView | Result | BuiltMap | Accepted):
        return {name: contents(getattr(value, name)) for name in type(value).__slots__}
    if isinstance(value, tuple | list):
        return tuple(contents(member) for member in value)
    if hasattr(value, "graph"):
        return (repr(value.places), repr(value.edges))
    return repr(value)
