"""Giovannangeli, Gaussier, Desilles: robust mapless outdoor vision-based navigation (IROS 2006)."""

from fpnav.experiments.giovannangeli.study import STUDY

__all__ = ["STUDY"]
