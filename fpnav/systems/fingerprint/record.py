"""The scalar record of a fingerprint, and what stands beside its symbols."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.values import FloatArray, Signature

RECORD = np.dtype(
    [
        ("laser_centre_rad", "<f8"),
        ("laser_width_rad", "<f8"),
        ("camera_centre_rad", "<f8"),
        ("camera_width_rad", "<f8"),
        ("laser_x_m", "<f8"),
        ("laser_y_m", "<f8"),
        ("features", "<i4"),
        ("corners", "<i4"),
        ("edges", "<i4"),
        ("colours", "<i4"),
        ("correspondences", "<i4"),
        ("empty", "<i4"),
    ]
)
"""What the sensors covered around the robot (width 0 = missing), where the laser stands on it, and
counts of symbols."""

LASER_ARC, CAMERA_ARC = 0, 1

_ARCS = RECORD.names[:4] if RECORD.names else ()


def record_of(
    arcs: FloatArray, letters: bytes, mount_m: Sequence[float] | FloatArray = (0.0, 0.0)
) -> np.void:
    """Record of a fingerprint from its arcs (2, 2), the laser's place (2,) and its string."""
    counts = [letters.count(letter) for letter in b"cvfn"]
    colours = len(letters) - sum(counts)
    c, v, f, n = counts
    row = np.array([(*arcs.ravel(), *mount_m, c + v + colours, c, v, colours, f, n)], RECORD)
    value: np.void = row[0]
    return value


def arcs_of(signature: Signature) -> FloatArray:
    """Centre and width of what laser and camera covered, (2, 2)."""
    return np.array([float(signature.record[name]) for name in _ARCS]).reshape(2, 2)


def insertion(params: FingerprintParams) -> dict[str, float]:
    """How f and n are put between features."""
    return {
        "pair_rad": float(np.deg2rad(params.pair_deg)) if params.use_f else -1.0,
        "delta_rad": float(np.deg2rad(params.delta_n_deg)),
        "certainty_n": params.certainty_n,
    }
