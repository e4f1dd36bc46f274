"""A log as frames: what every sensor said around each stamp of the primary role.

``open_log`` reads a file once, from front to back, and keeps an index, the poses and the small
messages; images and scans are loaded block by block when frames are asked for.
"""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.geometry import path_length, wrap
from fpnav.logs import decode, roles, timing
from fpnav.logs import streams as joins
from fpnav.logs.containers import open_container
from fpnav.logs.contents import Container
from fpnav.logs.index import index_log
from fpnav.logs.joining import Joining
from fpnav.logs.ledger import Budget, Ledger
from fpnav.logs.payloads import Fitting
from fpnav.logs.streams import Stream
from fpnav.logs.topics import Topic
from fpnav.logs.transforms import NO_MOUNT, transform_tree
from fpnav.values import (
    PRIMARY_ROLES,
    Calibration,
    FloatArray,
    Frame,
    Pose2,
    Reference,
)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Poses over time: ``stamps_ns`` (n,) strictly increasing, ``poses`` (n, 3) x, y, heading."""

    stamps_ns: NDArray[np.int64]
    poses: FloatArray


@dataclass(frozen=True, slots=True)
class RoleFacts:
    """Who plays a role and how often; ``period_s`` is the median, NaN below two messages."""

    topics: tuple[str, ...]
    messages: int
    first_ns: int
    last_ns: int
    period_s: float
    gaps: int
    longest_gap_s: float


class Log:
    """One recorded log, open; a context manager.

    Attributes
    ----------
    name, sha256, size, integrity : facts of the file, for the header chain
    file : the file as it was read: blocks, attachments, compressions
    roles : facts of every role that is present
    primary : the role whose stamps the frames stand at, empty where there is none
    calibrations : by camera role
    travelled_from : ``odometry``, ``truth`` or empty: what path lengths and thinning go by
    streams, tree : the messages of every role in time order; where sensors stand
    ledger : what became of every message; after ``frames`` was read to its end, of that reading
    """

    def __init__(
        self,
        file: Container,
        topics: Mapping[str, Topic],
        streams: Mapping[str, list[Stream]],
        ledger: Ledger,
        *,
        session: int,
        budget: Budget,
        tolerance_s: float | None,
        frames_on: Sequence[str],
    ) -> None:
        self.file = file
        self.streams = streams
        self._session = session
        self._budget = budget
        self._tolerance_s = tolerance_s
        self.topics = topics
        self.ledger = ledger
        self.name = file.path.name
        self.size = file.contents.facts.size
        self.sha256 = file.contents.facts.sha256
        self.integrity = file.contents.facts.integrity
        self.roles = {role: _facts(found) for role, found in streams.items()}
        self.primary = next((role for role in frames_on if role in streams), "")
        self.travelled_from = next((r for r in ("odometry", "truth") if r in streams), "")
        self.tree = transform_tree([topics])
        self.calibrations = self._find_calibrations()
        self._base = copy.deepcopy(ledger)

    def __enter__(self) -> Log:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    @property
    def world(self) -> dict[str, Any] | None:
        """What the attachment ``world.json`` says, None where the log has none."""
        data = self.attachment("world.json")
        if data is None:
            return None
        try:
            world: dict[str, Any] = json.loads(data)
        except (ValueError, RecursionError) as error:
            raise LogError(f"{self.name}: world.json cannot be read: {error}") from None
        return world

    def attachment(self, name: str) -> bytes | None:
        """Bytes of an attachment, None where the log has none of this name."""
        return self.file.attachment(name, self.ledger)

    @property
    def metadata(self) -> Mapping[str, Mapping[str, str]]:
        """Named tables of strings the log carries."""
        return self.file.contents.metadata

    def track(self, role: str) -> Track | None:
        """All poses of ``odometry`` or ``truth``, None where the log has none."""
        if role not in self.streams:
            return None
        stream = self.streams[role][0]
        stamps, first = np.unique(stream.stamps, return_index=True)
        return Track(stamps, stream.columns[first])

    def references(self) -> list[Reference]:
        """Where and when every frame is: before thinning, without its payloads."""
        main = self._main()
        odometry, truth, heading = (
            joins.states(self.streams.get(role, []), main.stamps)
            for role in ("odometry", "truth", "heading")
        )
        travelled = np.full(len(main), np.nan)
        if self.travelled_from:
            travelled = path_length(odometry if self.travelled_from == "odometry" else truth)
        labels = self._labels(main)
        return [
            Reference(
                index=int(main.ordinals[i]),
                stamp_ns=int(main.stamps[i]),
                session=self._session,
                travelled_m=float(travelled[i]),
                odometry=_pose(odometry[i]),
                truth=_pose(truth[i]),
                heading_rad=float(heading[i, 2]),
                label=labels[i],
            )
            for i in range(len(main))
        ]

    def frames(self, step_m: float = 0.0, step_heading_rad: float = 0.0) -> Iterator[Frame]:
        """Frames in order, thinned by travel since the last one kept (0, 0 = every frame).

        A frame is kept where it lies ``step_m`` away from the last one or is turned by
        ``step_heading_rad``, whichever comes first; a criterion of 0 does not count.

        Raises
        ------
        LogError
            The log has no role a frame can stand on (E206), or two roles never meet (E205).
        LossError
            At the end, where more was lost than the budget allows.
        """
        main = self._main()
        ledger = copy.deepcopy(self._base)
        references = self.references()
        kept = _thin(references, self.travelled_from, step_m, step_heading_rad)
        joining = self._joining(main, kept, ledger)
        joining.count_unused(self.primary, thinned=len(kept) < len(main))
        yield from self._delivered(joining, references, kept)
        self.ledger = ledger
        ledger.settle(self._budget)

    def sample(self, count: int) -> Iterator[Frame]:
        """At most ``count`` frames spread evenly over the log; nothing is counted."""
        main = self._main()
        rows = np.unique(np.linspace(0, len(main) - 1, min(count, len(main))).astype(np.int64))
        yield from self.at(main.ordinals[rows].tolist())

    def at(self, ordinals: Sequence[int]) -> Iterator[Frame]:
        """The frames whose references have these indices, in order; nothing is counted."""
        main = self._main()
        kept = np.flatnonzero(np.isin(main.ordinals, np.asarray(ordinals, dtype=np.int64)))
        joining = self._joining(main, kept, copy.deepcopy(self._base))
        yield from self._delivered(joining, self.references(), kept)

    def _joining(self, main: Stream, kept: NDArray[np.int64], ledger: Ledger) -> Joining:
        fitting = Fitting(self.name, self.tree, self.calibrations)
        return Joining(self.file, self.streams, main, kept, fitting, ledger, self._tolerance_s)

    def _delivered(
        self, joining: Joining, references: list[Reference], kept: NDArray[np.int64]
    ) -> Iterator[Frame]:
        """Frames whose primary message can be used."""
        for place, index in enumerate(kept.tolist()):
            payloads = joining.payloads(place)
            if self.primary in payloads:
                yield Frame(references[index], payloads)

    def _main(self) -> Stream:
        """The stream the frames stand on: of a ring, its fullest transducer."""
        if not self.primary:
            held = sorted({t.type_name or "messages without a type" for t in self.topics.values()})
            raise LogError(
                f"{self.name}: E206 nothing a frame can stand on: no {', '.join(PRIMARY_ROLES)}; "
                f"the log holds {', '.join(held) or 'no messages'}"
            )
        return max(self.streams[self.primary], key=len)

    def _labels(self, main: Stream) -> list[str]:
        """Label that holds at each message of the main stream, by log time."""
        if "label" not in self.streams:
            return [""] * len(main)
        stream = self.streams["label"][0]
        rows = timing.holding(stream.stamps, main.log_ns)
        return [str(stream.objects[row].data) if row >= 0 else "" for row in rows.tolist()]

    def _find_calibrations(self) -> dict[str, Calibration]:
        """Calibration of each camera role: the first CameraInfo beside its topic."""
        found: dict[str, Calibration] = {}
        for role in roles.IMAGE_ROLES:
            if role in self.streams:
                stream = self.streams[role][0]
                info = roles.camera_info(self.topics, stream.topic)
                mount, _ = self.tree.mount(stream.frame_id) or NO_MOUNT
                if info is not None:
                    found[role] = decode.calibration_from(info, mount)
        return found


def open_log(
    path: Path | str,
    topics: Mapping[str, str] | None = None,
    *,
    session: int = 0,
    max_loss: float = 0.01,
    strict: bool = False,
    allow_truncated: bool = False,
    tolerance_s: float | None = None,
    frames_on: Sequence[str] = PRIMARY_ROLES,
    digest: bool = True,
) -> Log:
    """Open an MCAP log: one pass over the file, then frames on demand.

    Parameters
    ----------
    topics : role -> topic where the one found is not the one wanted; empty leaves the role out
    session : number that goes into the references
    max_loss : share of a used topic's messages that may be lost; ``strict`` = none
    allow_truncated : use what is whole of a file whose loss cannot be counted
    tolerance_s : largest time between a frame and a joined message; None = half the slower
        role's median period, within 1 ms .. 1 s
    frames_on : roles a frame may stand on, the first present wins
    digest : compute the file's sha256

    Raises
    ------
    LogError
        Not an MCAP log, or a wanted topic is absent.
    LossError
        More was lost than the budget allows.
    """
    budget = Budget(max_loss, strict, allow_truncated)
    file = open_container(Path(path))
    try:
        ledger = Ledger()
        found = index_log(file, ledger, digest=digest)
        chosen = roles.assign(found, topics or {})
        roles.count_topics(found, chosen, ledger)
        roles.note_unusable(found, ledger)
        streams = joins.build_streams(found, chosen, ledger)
        ledger.settle(budget)
        return Log(
            file,
            found,
            streams,
            ledger,
            session=session,
            budget=budget,
            tolerance_s=tolerance_s,
            frames_on=frames_on,
        )
    except BaseException:
        file.close()
        raise


def _facts(streams: list[Stream]) -> RoleFacts:
    main = max(streams, key=len)
    pauses, longest = timing.gaps(main.stamps)
    return RoleFacts(
        topics=tuple(stream.topic for stream in streams),
        messages=sum(len(stream) for stream in streams),
        first_ns=int(main.stamps[0]),
        last_ns=int(main.stamps[-1]),
        period_s=main.period_ns / 1e9,
        gaps=pauses,
        longest_gap_s=longest,
    )


def _pose(row: FloatArray) -> Pose2 | None:
    x, y, heading = (float(value) for value in row)
    return None if math.isnan(x) else Pose2(x, y, heading)


def _thin(
    references: list[Reference], source: str, step_m: float, step_heading_rad: float
) -> NDArray[np.int64]:
    """Indices of the references that are kept; all where there is no pose to thin by."""
    if (step_m <= 0.0 and step_heading_rad <= 0.0) or not source:
        return np.arange(len(references), dtype=np.int64)
    kept: list[int] = []
    last: Reference | None = None
    for index, reference in enumerate(references):
        if getattr(reference, source) is None:
            continue
        if last is None or _moved(last, reference, source, step_m, step_heading_rad):
            kept.append(index)
            last = reference
    return np.array(kept, dtype=np.int64)


def _moved(
    last: Reference, now: Reference, source: str, step_m: float, step_heading_rad: float
) -> bool:
    """Whether the path since the last frame, or the turn since it, is a step."""
    if step_m > 0.0 and now.travelled_m - last.travelled_m >= step_m:
        return True
    turn = abs(wrap(getattr(now, source).heading_rad - getattr(last, source).heading_rad))
    return step_heading_rad > 0.0 and turn >= step_heading_rad
