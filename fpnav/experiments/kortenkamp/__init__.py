"""Kortenkamp, Weymouth: topological mapping for mobile robots using a combination of sonar and
vision sensing (AAAI 1994)."""

from fpnav.experiments.kortenkamp.study import STUDY

__all__ = ["STUDY"]
