"""From radiance to pixels: optics, exposure, noise, tone."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import angular_distance, column_bearings
from fpnav.params import Params
from fpnav.sim.jit import compiled
from fpnav.sim.raycast import Float32Array

SHOULDER = 1.35
"""Highlights are compressed by value / (1 + (SHOULDER - 1) value)."""

TONES = 4096
NOISE = 1 << 18


class Film(Params, frozen=True):
    """Faults of a camera. ``exposure``: how much of a change of light the camera evens out."""

    exposure: float = 0.85
    level: float = 0.2
    exposure_spread: float = 0.08
    vignette: float = 0.25
    blur_px: float = 0.55
    shutter_s: float = 0.012
    shot_noise: float = 0.006
    read_noise: float = 0.004
    rolling: float = 0.03
    quality: int = 80


class Mask(Params, frozen=True):
    """Something hung over part of the panorama from a share of the run on.

    ``share`` of the columns is hidden, the middle of them at bearing ``centre_deg``.
    """

    share: float = 0.0
    from_share: float = 0.5
    centre_deg: float = 90.0
    grey: int = 90


def hide(pixels: NDArray[np.uint8], mask: Mask, progress: float) -> NDArray[np.uint8]:
    """The panorama with the mask over it, once the run has come that far."""
    if mask.share <= 0.0 or progress < mask.from_share:
        return pixels
    bearings = column_bearings(pixels.shape[1])
    away = angular_distance(bearings, np.radians(mask.centre_deg))
    out = pixels.copy()
    out[:, away < math.pi * mask.share] = mask.grey
    return out


def develop(
    radiance: Float32Array,
    film: Film,
    rng: np.random.Generator,
    smear_px: float,
    *,
    around: bool,
    grain: np.random.Generator | None = None,
) -> NDArray[np.uint8]:
    """BGR pixels (H, W, 3) of radiance (H, W, 3) linear RGB.

    ``smear_px`` : columns the view moved while the shutter was open; ``around`` : the left edge
    borders on the right one; ``grain`` : chance of the noise, where it is not that of the rest.
    """
    light = _optics(radiance, film, smear_px, around)
    gain = film.level * film.level ** (film.exposure - 1.0) / _level(light) ** film.exposure
    gain *= float(np.exp(film.exposure_spread * rng.standard_normal()))
    rows = _row_gains(light.shape[0], film, rng) * gain
    columns = np.ones(light.shape[1]) if around else _falloff(light.shape[1], film)
    own = grain or rng
    start, stride = int(own.integers(NOISE)), int(own.integers(NOISE // 2)) * 2 + 1
    out = np.empty(light.shape, dtype=np.uint8)
    _expose(
        light,
        rows.astype(np.float32),
        columns.astype(np.float32),
        film.shot_noise,
        film.read_noise,
        _grain(),
        start,
        stride,
        _tones(),
        out,
    )
    return out


def _optics(
    radiance: Float32Array, film: Film, smear_px: float, around: bool
) -> NDArray[np.float32]:
    pad = 8 + int(abs(smear_px))
    border = cv2.BORDER_WRAP if around else cv2.BORDER_REPLICATE
    wide = cv2.copyMakeBorder(radiance, 0, 0, pad, pad, border)
    if abs(smear_px) >= 1.5:
        wide = cv2.blur(wide, (round(abs(smear_px)), 1))
    if film.blur_px > 0.0:
        wide = cv2.GaussianBlur(wide, (0, 0), film.blur_px)
    return np.ascontiguousarray(wide[:, pad:-pad])


def _level(light: NDArray[np.float32]) -> float:
    """Mean brightness as a meter sees it: highlights count for no more than four times the mean."""
    grey = light[::4, ::4].mean(axis=2)
    mean = max(float(grey.mean()), 1e-4)
    return max(float(np.minimum(grey, 4.0 * mean).mean()), 1e-4)


def _falloff(count: int, film: Film) -> NDArray[np.float64]:
    """Vignetting along one axis of the image."""
    return np.asarray(1.0 - film.vignette * np.linspace(-1.0, 1.0, count) ** 2)


def _row_gains(rows: int, film: Film, rng: np.random.Generator) -> NDArray[np.float64]:
    """Vignetting towards the rim and the bands of flickering lamps."""
    height = np.linspace(-1.0, 1.0, rows)
    bands = np.sin(2 * np.pi * (rng.uniform(0.5, 2.0) * height + rng.random()))
    return np.asarray(_falloff(rows, film) * (1.0 + film.rolling * bands))


_CACHE: dict[str, NDArray[np.float32] | NDArray[np.uint8]] = {}


def _grain() -> NDArray[np.float32]:
    """Normal noise, the same for everybody; frames read it from their own start and stride."""
    if "grain" not in _CACHE:
        rng = np.random.Generator(np.random.PCG64(20060101))
        _CACHE["grain"] = rng.standard_normal(NOISE, dtype=np.float32)
    return np.asarray(_CACHE["grain"], dtype=np.float32)


def _tones() -> NDArray[np.uint8]:
    """Linear light in 1 / TONES steps to sRGB bytes."""
    if "tones" not in _CACHE:
        linear = (np.arange(TONES) + 0.5) / TONES
        _CACHE["tones"] = np.round(255.0 * linear ** (1.0 / 2.2)).astype(np.uint8)
    return np.asarray(_CACHE["tones"], dtype=np.uint8)


@compiled
def _expose(
    light: Float32Array,
    rows: Float32Array,
    columns: Float32Array,
    shot: float,
    read: float,
    grain: Float32Array,
    start: int,
    stride: int,
    tones: NDArray[np.uint8],
    out: NDArray[np.uint8],
) -> None:
    height, width = light.shape[0], light.shape[1]
    photons, floor = np.float32(shot * shot), np.float32(read * read)
    scale, last = np.float32(SHOULDER * TONES), np.float32(TONES - 1)
    bend, one, zero = np.float32(SHOULDER - 1.0), np.float32(1.0), np.float32(0.0)
    at, step, mask = np.uint32(start), np.uint32(stride), np.uint32(NOISE - 1)
    for y in range(height):
        for x in range(width):
            for c in range(3):
                value = light[y, x, c] * rows[y] * columns[x]
                at = (at + step) & mask
                value += grain[at] * math.sqrt(photons * value + floor)
                value = max(value, zero)
                tone = min(scale * value / (one + bend * value), last)
                out[y, x, 2 - c] = tones[np.uint32(tone)]


def encode(pixels: NDArray[np.uint8], quality: int) -> bytes:
    """JPEG bytes."""
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return bytes(data)


def decode(data: bytes) -> NDArray[np.uint8]:
    """BGR pixels of JPEG bytes made by ``encode``."""
    pixels = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR)
    return np.asarray(pixels, dtype=np.uint8)
