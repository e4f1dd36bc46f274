"""Fingerprints of places: the system and its parameter block."""

from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.system import Fingerprint

__all__ = ["Fingerprint", "FingerprintParams"]
