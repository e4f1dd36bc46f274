"""The errors fpnav raises on purpose.

Raised low, where the facts are known, with the file, what was found and what was expected;
turned into exit codes by ``fpnav.cli.main`` alone. Anything that is not one of these is a bug.
"""

from __future__ import annotations


class FpnavError(Exception):
    """Root of all expected failures: one line for the user, exit code 1."""

    exit_code = 1


class UsageError(FpnavError):
    """The request itself is wrong: an unknown parameter, an output that equals an input."""

    exit_code = 2


class LogError(FpnavError):
    """A log cannot be used: not a log, damaged, lacking a role."""


class StoreError(FpnavError):
    """A signature, map or result file cannot be used, or does not fit its partner."""


class TruthError(FpnavError):
    """Ground truth cannot be read or does not fit the run."""


class LossError(FpnavError):
    """More data was lost than the budget allows; nothing was published."""

    exit_code = 3


class GateError(FpnavError):
    """A gate the user set (``--fail-under``) was not met."""

    exit_code = 4
