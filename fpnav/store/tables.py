"""Values as columns: what signature, map and result files hold, in memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray, Pose2, Reference, Signature

REFERENCE = np.dtype(
    [
        ("index", "<i8"),
        ("stamp_ns", "<i8"),
        ("session", "<i4"),
        ("travelled_m", "<f8"),
        ("odometry", "<f8", (3,)),
        ("truth", "<f8", (3,)),
        ("heading_rad", "<f8"),
        ("label", "S64"),
    ]
)
"""One row per signature: values.Reference as a table row, NaN where a pose is unknown."""

EDGE = np.dtype(
    [
        ("source", "<i8"),
        ("target", "<i8"),
        ("length_m", "<f8"),
        ("bearing_out_rad", "<f8"),
        ("bearing_in_rad", "<f8"),
        ("count", "<i8"),
    ]
)
"""One row per directed edge of a map, one edge per travelled direction."""

ACTION = np.dtype(
    [
        ("trip", "<i4"),
        ("stamp_ns", "<i8"),
        ("truth", "<f8", (3,)),
        ("place", "<i8"),
        ("activity", "<f8"),
        ("wanted_rad", "<f8"),
        ("bumped", "?"),
    ]
)
"""One row per decision of a policy: where the robot was, the winning place (-1 none), the bearing
it wanted to go in the robot's frame (NaN none), whether it touched something since the last."""

NO_POSE = (np.nan, np.nan, np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class Ragged:
    """Rows of unequal length: row i is ``flat[offsets[i]:offsets[i + 1]]``."""

    flat: NDArray[Any]
    offsets: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __getitem__(self, row: int) -> NDArray[Any]:
        return self.flat[self.offsets[row] : self.offsets[row + 1]]

    @staticmethod
    def of(rows: Sequence[NDArray[Any]], dtype: np.dtype[Any]) -> Ragged:
        """Ragged table of the given rows, in order."""
        lengths = [len(row) for row in rows]
        flat = np.concatenate([np.zeros(0, dtype), *rows]).astype(dtype, copy=False)
        return Ragged(flat, np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64))


@dataclass(frozen=True, slots=True, eq=False)
class SignatureTable(Sequence[Signature]):
    """All signatures of a run as columns; a row is a Signature made when asked for."""

    references: NDArray[Any]
    records: NDArray[Any]
    parts: Mapping[str, Ragged]

    def __len__(self) -> int:
        return len(self.references)

    @overload
    def __getitem__(self, row: int) -> Signature: ...

    @overload
    def __getitem__(self, row: slice) -> list[Signature]: ...

    def __getitem__(self, row: int | slice) -> Signature | list[Signature]:
        if isinstance(row, slice):
            return [self[i] for i in range(*row.indices(len(self)))]
        if row < 0:
            row += len(self)
        if not 0 <= row < len(self):
            raise IndexError(row)
        return Signature(
            reference_of(self.references[row]),
            self.records[row],
            {name: part[row] for name, part in self.parts.items()},
        )

    def __iter__(self) -> Iterator[Signature]:
        return (self[row] for row in range(len(self)))


@dataclass(frozen=True, slots=True, eq=False)
class MapView:
    """What a report draws of a map; empty arrays where there is no map.

    ``place_ids`` (P,); ``place_pose`` (P, 3) drawn at the truth of the middle member where known,
    else its odometry; ``extent_m`` (P,); ``edges`` (E,) EDGE; ``novelty`` (R,) dissimilarity of
    each mapping signature to its predecessor's place, ``threshold`` what it was compared with;
    ``strips`` one text per place (the readable signature), empty where the system has none.
    """

    place_ids: NDArray[np.int64]
    place_pose: FloatArray
    extent_m: FloatArray
    edges: NDArray[Any]
    novelty: FloatArray
    threshold: float
    strips: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Accepted:
    """Truth of a result.

    ``kind`` : ``poses`` (truth columns of queries and references), ``pairs`` (``pairs[i]`` are the
    accepted reference rows of query row i) or ``none``. ``source`` says where it is from.
    """

    kind: str
    source: str
    pairs: Ragged | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """Outcome of ``localize`` or ``recognize``: everything a report needs.

    Q queries, R reference signatures (of the map, or of the reference run), P places, ranking
    depth k. ``header`` is the file's header (see store.header). ``owner`` (R,) is the place that
    owns each reference signature; for ``recognize`` every reference row is its own place.
    ``places``, ``members``, ``scores``, ``headings_rad`` (Q, k): the ranking, best first, -1 and
    -inf padded; members are reference rows. Headings turn from the member where one is named, else
    from the place's frame, to the query. ``decision`` (Q,) place id or -1 = not localized.
    ``stated`` (Q,) probability stated for the best answer, NaN where none; ``entropy`` (Q,) nats.
    ``belief`` (Q, P) float32 over ``view.place_ids``, or (Q, 0). ``candidates`` (Q,): the query
    could be matched with reference rows 0 .. candidates - 1 only (one run against its own past;
    R otherwise). ``relative`` (Q, 3) pose of the query as seen from the best member, NaN unknown;
    ``covariance`` (Q, 3, 3). ``actions`` (A,) ACTION, the decisions of a policy, none elsewhere.
    """

    header: Mapping[str, Any]
    queries: NDArray[Any]
    references: NDArray[Any]
    owner: NDArray[np.int64]
    candidates: NDArray[np.int64]
    places: NDArray[np.int64]
    members: NDArray[np.int64]
    scores: FloatArray
    headings_rad: FloatArray
    decision: NDArray[np.int64]
    stated: FloatArray
    entropy: FloatArray
    belief: NDArray[np.float32]
    relative: FloatArray
    covariance: FloatArray
    truth: Accepted
    view: MapView
    query_strips: tuple[str, ...] = field(default=())
    actions: NDArray[Any] = field(default_factory=lambda: np.zeros(0, ACTION))


def label_bytes(label: str) -> bytes:
    """Label in UTF-8, cut between characters to the 64 bytes a table row holds."""
    return label.encode()[:64].decode(errors="ignore").encode()


def reference_row(reference: Reference) -> tuple[Any, ...]:
    """A Reference as a row of dtype REFERENCE."""

    def pose(value: Pose2 | None) -> tuple[float, float, float]:
        return NO_POSE if value is None else (value.x_m, value.y_m, value.heading_rad)

    return (
        reference.index,
        reference.stamp_ns,
        reference.session,
        reference.travelled_m,
        pose(reference.odometry),
        pose(reference.truth),
        reference.heading_rad,
        label_bytes(reference.label),
    )


def reference_of(row: Any) -> Reference:
    """A row of dtype REFERENCE as a Reference."""

    def pose(values: FloatArray) -> Pose2 | None:
        return None if np.isnan(values).any() else Pose2(*(float(value) for value in values))

    return Reference(
        index=int(row["index"]),
        stamp_ns=int(row["stamp_ns"]),
        session=int(row["session"]),
        travelled_m=float(row["travelled_m"]),
        odometry=pose(row["odometry"]),
        truth=pose(row["truth"]),
        heading_rad=float(row["heading_rad"]),
        label=bytes(row["label"]).decode(errors="replace"),
    )
