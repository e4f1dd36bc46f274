"""What colour a hit has: texture at the right mip level, tint, light map, or the sky.

One pass over the rays in float32. Small compiled functions return tuples of scalars, which the
compiler puts in line; indices are unsigned so that no negative wrap-around is checked.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.sim.jit import compiled
from fpnav.sim.raycast import Float32Array

Scalar = Any
"""A number of a type numba chooses."""

LEVEL_START = np.concatenate([[0], np.cumsum([(256 >> level) ** 2 for level in range(8)])]).astype(
    np.uint32
)
"""First texel of each mip level."""

COARSEST = 8
CLEAR_AIR_M = 1e4
"""Haze thinner than this is not computed."""

UNIT = np.float32(1.0 / 65535.0)
HALF, ONE, FLATTEST = np.float32(0.5), np.float32(1.0), np.float32(0.15)
QUARTER, COARSER = np.float32(0.25), np.float32(2.0)


@compiled
def shade(
    distance: Float32Array,
    triangle: NDArray[np.int32],
    origin: Float32Array,
    directions: Float32Array,
    turn: Float32Array,
    pixel_rad: float,
    owner: NDArray[np.int32],
    real: Float32Array,
    index: NDArray[np.int32],
    textures: NDArray[np.uint16],
    light: Float32Array,
    sky: Float32Array,
    haze_m: float,
    out: Float32Array,
) -> None:
    """Radiance (N, 3) of each ray, linear RGB, written to ``out``.

    ``origin`` (3,), ``directions`` (N, 3) unit, to be turned about the vertical by the angle of
    cosine and sine ``turn`` (2,); ``pixel_rad`` angle a pixel covers; ``light`` (L, 3); ``sky``
    (rows, columns, 3) equirectangular upper half, row 0 at the zenith; ``haze_m`` distance at
    which the air hides 63 %.
    """
    angle = np.float32(pixel_rad)
    for i in range(len(distance)):
        dx = turn[0] * directions[i, 0] - turn[1] * directions[i, 1]
        dy = turn[1] * directions[i, 0] + turn[0] * directions[i, 1]
        dz = directions[i, 2]
        if triangle[i] < 0:
            row, column = _sky_texel(dx, dy, dz, sky)
            for c in range(3):
                out[i, c] = sky[row, column, c]
            continue
        r = np.uint32(owner[np.uint32(triangle[i])])
        far = distance[i]
        s, t, slant = _on_patch(origin, dx, dy, dz, far, real, r)
        level = _level(far * angle * real[r, 17], slant)
        x0, x1, y0, y1, wx, wy = _texture_place(s, t, real, r, level)
        a0, a1, b0, b1, ux, uy = _light_place(s, t, real, index, r)
        w11, v11 = wx * wy, ux * uy
        w10, w01, w00 = wy - w11, wx - w11, ONE - wx - wy + w11
        v10, v01, v00 = uy - v11, ux - v11, ONE - ux - uy + v11
        texture = np.uint32(index[r, 0])
        for c in range(3):
            colour = w00 * textures[texture, y0 + x0, c] + w01 * textures[texture, y0 + x1, c]
            colour += w10 * textures[texture, y1 + x0, c] + w11 * textures[texture, y1 + x1, c]
            lit = v00 * light[b0 + a0, c] + v01 * light[b0 + a1, c]
            lit += v10 * light[b1 + a0, c] + v11 * light[b1 + a1, c]
            out[i, c] = UNIT * colour * real[r, 13 + c] * (lit + real[r, 16])
    if haze_m < CLEAR_AIR_M:
        _veil(distance, triangle, sky, np.float32(haze_m), out)


@compiled
def _on_patch(
    origin: Float32Array,
    dx: Scalar,
    dy: Scalar,
    dz: Scalar,
    far: Scalar,
    real: Float32Array,
    r: Scalar,
) -> tuple[Any, Any, Any]:
    """Metres along s and t of the hit, and the cosine of its incidence."""
    x = origin[0] + far * dx - real[r, 0]
    y = origin[1] + far * dy - real[r, 1]
    z = origin[2] + far * dz - real[r, 2]
    s = x * real[r, 3] + y * real[r, 4] + z * real[r, 5]
    t = x * real[r, 6] + y * real[r, 7] + z * real[r, 8]
    nx = real[r, 4] * real[r, 8] - real[r, 5] * real[r, 7]
    ny = real[r, 5] * real[r, 6] - real[r, 3] * real[r, 8]
    nz = real[r, 3] * real[r, 7] - real[r, 4] * real[r, 6]
    return s, t, abs(nx * dx + ny * dy + nz * dz)


@compiled
def _level(texels: Scalar, slant: Scalar) -> int:
    """Mip level at which a pixel covers about one texel, the slant shared between both axes."""
    square = texels * texels / max(slant, FLATTEST)
    level = 0
    while square > COARSER and level < COARSEST:
        square *= QUARTER
        level += 1
    return level


@compiled
def _texture_place(
    s: Scalar, t: Scalar, real: Float32Array, r: Scalar, level: int
) -> tuple[Any, ...]:
    """Columns, row starts and weights of the four texels about (s, t); wraps."""
    side = 256 >> level
    mask = np.uint32(side - 1)
    fx = (s * real[r, 9] + real[r, 11]) * np.float32(side) - HALF
    fy = -(t * real[r, 10] + real[r, 12]) * np.float32(side) - HALF
    x, y = math.floor(fx), math.floor(fy)
    start = LEVEL_START[level]
    x0, x1 = np.uint32(np.int32(x)) & mask, np.uint32(np.int32(x) + 1) & mask
    y0 = (np.uint32(np.int32(y)) & mask) * np.uint32(side) + start
    y1 = (np.uint32(np.int32(y) + 1) & mask) * np.uint32(side) + start
    return x0, x1, y0, y1, np.float32(fx - x), np.float32(fy - y)


@compiled
def _light_place(
    s: Scalar, t: Scalar, real: Float32Array, index: NDArray[np.int32], r: Scalar
) -> tuple[Any, ...]:
    """Columns, row starts and weights of the four light texels about (s, t); held at the rim."""
    columns, rows = index[r, 2], index[r, 3]
    zero = np.float32(0.0)
    fx = min(max((s - real[r, 18]) * real[r, 21] - HALF, zero), np.float32(columns - 1))
    fy = min(max((t - real[r, 19]) * real[r, 22] - HALF, zero), np.float32(rows - 1))
    a, b = np.int32(fx), np.int32(fy)
    b0 = np.uint32(index[r, 1] + b * columns)
    b1 = np.uint32(index[r, 1] + min(b + 1, rows - 1) * columns)
    a1 = np.uint32(min(a + 1, columns - 1))
    return np.uint32(a), a1, b0, b1, fx - np.float32(a), fy - np.float32(b)


@compiled
def _sky_texel(dx: Scalar, dy: Scalar, dz: Scalar, sky: Float32Array) -> tuple[int, int]:
    rows, columns = sky.shape[0], sky.shape[1]
    up = math.asin(min(max(dz, 0.0), 1.0)) / (0.5 * math.pi)
    around = (math.atan2(dy, dx) + math.pi) / (2.0 * math.pi)
    return min(int((1.0 - up) * rows), rows - 1), min(int(around * columns), columns - 1)


@compiled
def _veil(
    distance: Float32Array,
    triangle: NDArray[np.int32],
    sky: Float32Array,
    haze_m: Scalar,
    out: Float32Array,
) -> None:
    """Mix in the colour of the horizon with distance."""
    last = sky.shape[0] - 1
    for i in range(len(distance)):
        if triangle[i] >= 0:
            clear = np.float32(math.exp(-distance[i] / haze_m))
            for c in range(3):
                out[i, c] = out[i, c] * clear + (ONE - clear) * sky[last, 0, c]
