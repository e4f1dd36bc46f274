"""Which topic plays which role: by type first, by name where several could."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from fpnav.errors import LogError, UsageError
from fpnav.logs import messages
from fpnav.logs.ledger import BY_OPTION, Ledger
from fpnav.logs.topics import Topic
from fpnav.values import ROLES

IMAGE_ROLES = ("panorama", "omni", "camera", "camera_offset")

_IMAGES = (messages.COMPRESSED_IMAGE, messages.IMAGE)
_POSES = (messages.POSE, messages.ODOMETRY, messages.POSE_COVARIANCE)
_TRUE = r"truth|(^|[/_])gt($|[/_])|vicon|mocap|optitrack|groundtruth"
_DEPTH = r"depth|disparity|infra|(^|/)ir/|mask|segment|costmap"
_PANORAMA = r"pano|unwrap|equirect|spherical|360"
_OMNI = r"omni|cata|fisheye"
_OFFSET = r"offset|(^|[/_])right($|[/_])"


@dataclass(frozen=True, slots=True)
class Rule:
    """Types that can play a role; names that are preferred, avoided, needed, or excluded.

    ``prefers`` : the better names first. ``by_name`` : types that can play it too, but only where
    the name is one that is preferred.
    """

    types: tuple[str, ...]
    standard: str
    prefers: tuple[str, ...] = ()
    avoids: str = ""
    needs: str = ""
    excludes: str = ""
    by_name: tuple[str, ...] = ()


RULES: dict[str, Rule] = {
    "panorama": Rule(_IMAGES, "/panorama", needs=_PANORAMA, excludes=_DEPTH),
    "omni": Rule(_IMAGES, "/omni", needs=_OMNI, excludes=f"{_DEPTH}|{_PANORAMA}"),
    "camera_offset": Rule(_IMAGES, "/camera_offset", needs=_OFFSET, excludes=_DEPTH),
    "camera": Rule(
        _IMAGES,
        "/camera",
        prefers=("front", "left", "color|rgb", "image"),
        avoids="right|rear|back",
        excludes=f"{_DEPTH}|{_PANORAMA}|{_OMNI}|offset",
    ),
    "scan": Rule((messages.LASER_SCAN,), "/scan", prefers=("scan|front|base",)),
    "sonar": Rule((messages.RANGE,), "/sonar/0", excludes="cliff|infra|(^|/)ir"),
    "odometry": Rule(
        (messages.ODOMETRY,),
        "/odom",
        prefers=("odom|wheel",),
        excludes=f"{_TRUE}|imu|gps",
        by_name=(messages.POSE, messages.POSE_COVARIANCE),
    ),
    "truth": Rule(_POSES, "/truth", needs=_TRUE),
    "heading": Rule((messages.IMU,), "/compass", prefers=("compass|heading|mag",)),
    "pan": Rule((messages.JOINT_STATE,), "/pan"),
    "label": Rule((messages.STRING,), "/label", needs="label|room|place"),
}


SENSORS = ("camera", "scan", "sonar")
"""Roles a user is offered for a topic whose name says nothing."""

Chosen = dict[str, tuple[str, ...]]
"""Role -> its topics; a sonar ring has several."""


def assign(topics: Mapping[str, Topic], wanted: Mapping[str, str], role: str = "") -> Chosen:
    """Topics of every role that has any, in the order of values.ROLES.

    ``wanted`` maps a role to a topic of the user's choice (several sonar topics separated by
    commas; empty = leave the role out). ``role`` says what the images are, where one topic has
    them.

    Raises
    ------
    UsageError
        A role that does not exist.
    LogError
        A wanted topic is absent or of another type.
    """
    for name in wanted:
        if name not in RULES:
            raise UsageError(f"--topic {name}=...: no such role; roles are {', '.join(ROLES)}")
    chosen: Chosen = {}
    for name in ROLES:
        names = _wanted(topics, name, wanted[name]) if name in wanted else _found(topics, name)
        if names:
            chosen[name] = names
    _pair(chosen, candidates(topics, "camera_offset"), wanted)
    return _renamed(chosen, role, wanted) if role else chosen


def _pair(chosen: Chosen, offsets: list[str], wanted: Mapping[str, str]) -> None:
    """The offset camera is the one that belongs to the camera; the camera itself is none.

    Where several could be it, theirs is the name with ``right`` for the camera's ``left``.
    """
    camera = chosen.get("camera", ("",))[0]
    if "camera_offset" in wanted or "camera_offset" not in chosen:
        return
    others = [name for name in offsets if name != camera]
    pairs = [name for name in others if name.lower().replace("right", "left") == camera.lower()]
    standard = [name for name in others if name == RULES["camera_offset"].standard]
    found = standard or pairs or (others if len(others) == 1 else [])
    if found:
        chosen["camera_offset"] = (found[0],)
    else:
        del chosen["camera_offset"]


def _renamed(chosen: Chosen, role: str, wanted: Mapping[str, str]) -> Chosen:
    """The one image topic that was found plays the role the user names."""
    if role not in IMAGE_ROLES:
        raise UsageError(f"--role {role}: images can be {', '.join(IMAGE_ROLES)}")
    found = [name for name in IMAGE_ROLES if name in chosen and name not in wanted]
    if role in wanted or len(found) != 1:
        return chosen
    return {role if name == found[0] else name: topics for name, topics in chosen.items()}


def candidates(topics: Mapping[str, Topic], role: str) -> list[str]:
    """Topics that could play a role, best first."""
    rule = RULES[role]
    usable = (t for t in topics.values() if len(t.rows) and not t.problem)
    allowed = (t for t in usable if _fits(rule, t.name, t.type_name))
    return [topic.name for topic in sorted(allowed, key=lambda topic: _rank(rule, topic))]


def _found(topics: Mapping[str, Topic], role: str) -> tuple[str, ...]:
    names = candidates(topics, role)
    if role == "sonar":
        return _ring(names)
    return tuple(names[:1])


def by_type(topics: Mapping[str, Topic], role: str) -> list[str]:
    """Topics a user may name for a role, though their names do not suggest it."""
    rule = RULES[role]
    fitting = (t for t in topics.values() if t.type_name in rule.types + rule.by_name)
    return sorted(topic.name for topic in fitting if len(topic.rows) and not topic.problem)


def _fits(rule: Rule, name: str, type_name: str) -> bool:
    """Whether a topic can play a role by its type and its name."""
    if type_name in rule.by_name and not _preference(rule, name):
        return False
    if type_name not in rule.types + rule.by_name:
        return False
    if name == rule.standard:
        return True
    if rule.excludes and re.search(rule.excludes, name.lower()):
        return False
    return not rule.needs or re.search(rule.needs, name.lower()) is not None


def _rank(rule: Rule, topic: Topic) -> tuple[bool, bool, int, int, str]:
    avoided = bool(rule.avoids and re.search(rule.avoids, topic.name.lower()))
    preference = _preference(rule, topic.name)
    return topic.name != rule.standard, avoided, -preference, -len(topic.rows), topic.name


def _preference(rule: Rule, name: str) -> int:
    """How good a name is for a role: 0 is not one of those preferred."""
    places = (i for i, words in enumerate(rule.prefers) if re.search(words, name.lower()))
    return len(rule.prefers) - next(places, len(rule.prefers))


def _ring(names: Iterable[str]) -> tuple[str, ...]:
    """All topics of the ring, in the order of their numbers: /sonar/2 before /sonar/10."""
    return tuple(sorted(names, key=natural))


def natural(name: str) -> tuple[tuple[int, str], ...]:
    """Sorting key that takes digits as numbers."""
    parts = re.split(r"(\d+)", name)
    return tuple((int(part), "") if part.isdigit() else (-1, part) for part in parts)


def _wanted(topics: Mapping[str, Topic], role: str, text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    if len(names) > 1 and role != "sonar":
        raise UsageError(f"--topic {role}={text}: one topic plays a role, only a ring has several")
    for name in names:
        topic = topics.get(name)
        if topic is None:
            known = ", ".join(sorted(topics)) or "none"
            raise LogError(f"--topic {role}={name}: no such topic; the log has {known}")
        if topic.type_name not in RULES[role].types + RULES[role].by_name:
            raise LogError(
                f"--topic {role}={name}: carries {topic.type_name or 'no type'}, a {role} needs "
                f"{' or '.join(RULES[role].types)}"
            )
        if topic.problem:
            raise LogError(f"--topic {role}={name}: {topic.problem}")
    return names


def places(chosen: Chosen) -> dict[str, tuple[str, int]]:
    """Topic -> the role it plays and its number within a ring."""
    return {
        topic: (role, number)
        for role, names in chosen.items()
        for number, topic in enumerate(names)
    }


def merge(files: Iterable[Mapping[str, Topic]]) -> dict[str, Topic]:
    """Topics over all files of a recording; of each name the one with most messages."""
    merged: dict[str, Topic] = {}
    for topics in files:
        for name, topic in topics.items():
            if name not in merged or len(topic.rows) > len(merged[name].rows):
                merged[name] = topic
    return merged


def count_topics(topics: Mapping[str, Topic], chosen: Chosen, ledger: Ledger) -> None:
    """Start the ledger's counts of a file; what no role needs is unused by option."""
    needed = {name for names in chosen.values() for name in names}
    for name, topic in topics.items():
        helps = topic.type_name in (messages.CAMERA_INFO, messages.TRANSFORMS)
        if name not in needed and (topic.problem or not helps):
            topic.count.unuse()
        ledger.add(name, topic.count)


def note_unusable(topics: Mapping[str, Topic], ledger: Ledger) -> None:
    """Note topics whose type plays a role, and of which no message can be used."""
    types = {name for rule in RULES.values() for name in rule.types + rule.by_name}
    for topic in topics.values():
        code, _, reason = topic.problem.partition(" ")
        if code.startswith("E") and (topic.type_name in types or code in ("E118", "E119")):
            ledger.note(code, f"{topic.name}: {reason}")
        elif topic.type_name in types and not len(topic.rows) and topic.count.lost:
            codes = ", ".join(sorted(set(topic.count.skipped) - BY_OPTION)) or "unread"
            topic.problem = f"{codes} none of {topic.count.in_file} messages can be used"
            ledger.note(codes.partition(",")[0], f"{topic.name}: no message can be used")


def camera_info(topics: Mapping[str, Topic], image_topic: str) -> Any:
    """First CameraInfo beside an image topic: below it, or next to it as image_transport does."""
    bases = [image_topic]
    while "/" in image_topic.strip("/"):
        image_topic = image_topic.rsplit("/", 1)[0]
        bases.append(image_topic)
    for base in bases:
        topic = topics.get(f"{base}/camera_info")
        if topic is not None and topic.objects:
            return topic.objects[0]
    return None
