"""Checks of the file and of what can be read of it."""

from __future__ import annotations

from collections.abc import Iterator

from fpnav.logs import messages, roles
from fpnav.logs.checks.finding import Finding, fail, loss, note, ok, warn
from fpnav.logs.frames import Log
from fpnav.logs.ledger import BY_OPTION, Budget
from fpnav.values import PRIMARY_ROLES

_EXTRA = (messages.IMU, messages.JOINT_STATE)
"""Types that most recordings have without what a role needs of them."""


def container(log: Log, budget: Budget) -> Iterator[Finding]:
    """The file is whole and its CRCs hold."""
    facts = log.file.contents.facts
    code = facts.damage.partition(" ")[0]
    if facts.damage:
        fix = "stages use what is whole with --allow-truncated"
        found = warn if budget.allow_truncated else loss
        yield found("container", code, facts.damage.partition(" ")[2], fix)
    elif facts.integrity == "damaged":
        yield warn(
            "container", "E110", "damaged in parts, what was lost is counted", _see("losses")
        )
    elif facts.integrity == "unverified":
        yield note("container", "A11", "whole, but nothing verifies it: no CRC in the file")
    else:
        yield ok("container", "whole, every message covered by a CRC that holds")


def losses(log: Log, budget: Budget) -> Iterator[Finding]:
    """Every message of a used topic can be read."""
    lossless = True
    for name, count in sorted(log.ledger.topics.items()):
        if not count.needed or not count.lost:
            continue
        lossless = False
        faults = {code: n for code, n in count.skipped.items() if code not in BY_OPTION}
        reasons = ", ".join(f"{n} {code}" for code, n in sorted(faults.items()))
        unread = f"{count.unread} unread" if count.unread else ""
        parts = "; ".join(part for part in (reasons, unread) if part)
        message = f"{name}: {count.lost} of {count.in_file} messages lost ({parts})"
        over = count.fraction > budget.share
        found = loss if over else warn
        yield found("losses", next(iter(faults), "E102"), message, f"allowed is {budget.share:.2%}")
    if lossless:
        yield ok("losses", "every message of the topics used can be read")


def roles_present(log: Log, budget: Budget) -> Iterator[Finding]:
    """There is a sensor frames can stand on, and a pose to go by."""
    if not log.primary:
        fix = f"name a topic with --topic ROLE=/name ({', '.join(PRIMARY_ROLES)})"
        yield fail("roles", "E206", "no topic a frame can stand on", fix)
        return
    yield ok("roles", f"frames stand on {log.primary}; present: {', '.join(log.roles)}")
    if not log.travelled_from:
        message = "no odometry and no truth: no path length, no thinning, no --exclude-path"
        yield warn("roles", "E206", message, "give truth with --truth FILE.tum, or log odometry")


def decodable(log: Log, budget: Budget) -> Iterator[Finding]:
    """Topics of types that could play a role can be decoded."""
    known = {name for rule in roles.RULES.values() for name in rule.types}
    spoiled = [topic for topic in log.topics.values() if topic.problem and topic.name]
    bad = [t for t in spoiled if t.type_name in known or t.problem.startswith(("E118", "E119"))]
    for topic in sorted(bad, key=lambda topic: topic.name):
        code, _, reason = topic.problem.partition(" ")
        found = note if topic.type_name in _EXTRA else warn
        fix = "record it as a standard type" if code.startswith("E30") else ""
        yield found("decodable", code, f"{topic.name}: {reason}", fix)
    unused = sum(topic.problem.startswith("not used") for topic in spoiled)
    if not bad:
        others = f"; {unused} of other types are left alone" if unused else ""
        yield ok("decodable", f"all topics of types that are used{others}")


def definitions(log: Log, budget: Budget) -> Iterator[Finding]:
    """Types are defined in the log."""
    if log.ledger.notes["C2"]:
        yield note("definitions", "C2", log.ledger.remarks["C2"])
    else:
        yield ok("definitions", "all types used are defined in the log")


def choices(log: Log, budget: Budget) -> Iterator[Finding]:
    """Each role has one topic that could play it."""
    several = False
    for role in roles.RULES:
        names = [] if role == "sonar" else roles.candidates(log.topics, role)
        if role in log.roles and len(names) > 1:
            several = True
            used = log.roles[role].topics[0]
            others = ", ".join(name for name in names if name != used)
            yield note("choices", "E119", f"{role} is {used}; {others} could play it too",
                       f"--topic {role}=/name")  # fmt: skip
    if not several:
        yield ok("choices", "one topic for every role")


def labels(log: Log, budget: Budget) -> Iterator[Finding]:
    """Labels, where there are any, hold from the first frame on."""
    if "label" not in log.roles:
        yield note("labels", "", "none: guided training (--labels guided) is not possible")
        return
    named = [reference.label for reference in log.references()] if log.primary else []
    missing = sum(not label for label in named)
    kinds = len(set(named) - {""})
    if missing:
        message = f"{missing} of {len(named)} frames come before the first label"
        yield note("labels", "", message)
    else:
        yield ok("labels", f"{kinds} labels, every frame has one")


def _see(check: str) -> str:
    return f"see check {check}"
