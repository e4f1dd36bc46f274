"""Tapus, Battaglia, Siegwart: topological maps from fingerprints of places (IAS-9, 2006)."""

from fpnav.experiments.tapus.study import STUDY

__all__ = ["STUDY"]
