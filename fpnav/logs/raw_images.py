"""Uncompressed images of sensor_msgs/Image in every encoding of image_encodings.hpp.

16 bit values are scaled to 8 by dropping the low byte; 32FC and 64FC images are stretched from
their least to their largest finite value, NaN is black (REP 118 depth is no picture).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.logs import limits
from fpnav.logs.container import Damaged
from fpnav.logs.images import import_cv2

Pixels = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Layout:
    """How an encoding stores a row: sample type, samples per pixel, and the way to BGR."""

    sample: str
    channels: int
    to_bgr: str


_BASIC = {
    "mono8": Layout("u1", 1, "COLOR_GRAY2BGR"),
    "mono16": Layout("u2", 1, "COLOR_GRAY2BGR"),
    "bgr8": Layout("u1", 3, ""),
    "rgb8": Layout("u1", 3, "COLOR_RGB2BGR"),
    "bgra8": Layout("u1", 4, "COLOR_BGRA2BGR"),
    "rgba8": Layout("u1", 4, "COLOR_RGBA2BGR"),
    "bgr16": Layout("u2", 3, ""),
    "rgb16": Layout("u2", 3, "COLOR_RGB2BGR"),
    "bgra16": Layout("u2", 4, "COLOR_BGRA2BGR"),
    "rgba16": Layout("u2", 4, "COLOR_RGBA2BGR"),
    "uyvy": Layout("u1", 2, "COLOR_YUV2BGR_UYVY"),
    "yuv422": Layout("u1", 2, "COLOR_YUV2BGR_UYVY"),
    "yuyv": Layout("u1", 2, "COLOR_YUV2BGR_YUYV"),
    "yuv422_yuy2": Layout("u1", 2, "COLOR_YUV2BGR_YUYV"),
}
# OpenCV names a Bayer pattern by its second row, ROS by its first.
_BAYER = {"rggb": "BG", "bggr": "RG", "gbrg": "GR", "grbg": "GB"}
_TYPED = {"8U": "u1", "8S": "i1", "16U": "u2", "16S": "i2", "32S": "i4", "32F": "f4", "64F": "f8"}
_TYPED_TO_BGR = {1: "COLOR_GRAY2BGR", 3: "", 4: "COLOR_BGRA2BGR"}
_PLANAR = ("nv12", "nv21", "nv24")

ENCODINGS: dict[str, Layout] = {
    **_BASIC,
    **{
        f"bayer_{pattern}{bits}": Layout(f"u{bits // 8}", 1, f"COLOR_Bayer{name}2BGR")
        for pattern, name in _BAYER.items()
        for bits in (8, 16)
    },
    **{
        f"{depth}C{n}": Layout(sample, n, to_bgr)
        for depth, sample in _TYPED.items()
        for n, to_bgr in _TYPED_TO_BGR.items()
    },
}


@dataclass(frozen=True, slots=True)
class RawShape:
    """Fields of sensor_msgs/Image beside its data."""

    width: int
    height: int
    encoding: str
    step: int
    big_endian: bool = False


def check_raw(shape: RawShape, size: int) -> None:
    """Refuse an image whose fields do not fit its ``size`` bytes of data.

    Raises
    ------
    Damaged
        E401 no pixels, E402 sizes contradict, E403 unknown encoding, E407 over the limit.
    """
    if shape.width < 1 or shape.height < 1 or size == 0:
        raise Damaged("E401", f"image of {shape.width} x {shape.height} pixels, {size} bytes")
    if shape.width * shape.height > limits.IMAGE_PIXELS:
        raise Damaged("E407", f"image of {shape.width} x {shape.height} pixels is over the limit")
    if shape.encoding in _PLANAR:
        _check_planar(shape, size)
        return
    if shape.encoding not in ENCODINGS:
        known = ", ".join(sorted(ENCODINGS) + list(_PLANAR))
        raise Damaged("E403", f"encoding {shape.encoding!r} is none of {known}")
    layout = ENCODINGS[shape.encoding]
    row = shape.width * layout.channels * np.dtype(layout.sample).itemsize
    if shape.step < row or shape.step * shape.height != size:
        raise Damaged(
            "E402",
            f"{shape.width} x {shape.height} {shape.encoding} needs rows of {row} bytes; "
            f"step {shape.step}, data {size}",
        )
    if layout.to_bgr.startswith("COLOR_YUV") and shape.width % 2:
        raise Damaged("E402", f"{shape.encoding} needs an even width, has {shape.width}")


def decode_raw(shape: RawShape, data: bytes) -> Pixels:
    """Pixels (H, W, 3) uint8 BGR; raises Damaged as check_raw."""
    check_raw(shape, len(data))
    if shape.encoding in _PLANAR:
        return _decode_planar(shape, data)
    layout = ENCODINGS[shape.encoding]
    samples = _samples(shape, layout, data)
    return _to_bgr(layout, samples)


def _samples(shape: RawShape, layout: Layout, data: bytes) -> NDArray[np.generic]:
    """(H, W, channels) samples in native byte order, rows without their padding."""
    order = ">" if shape.big_endian else "<"
    dtype = np.dtype(order + layout.sample)
    rows = np.frombuffer(data, np.uint8).reshape(shape.height, shape.step)
    row = shape.width * layout.channels * dtype.itemsize
    samples = np.ascontiguousarray(rows[:, :row]).view(dtype)
    native = samples.astype(dtype.newbyteorder("="), copy=False)
    return native.reshape(shape.height, shape.width, layout.channels)


def _to_bgr(layout: Layout, samples: NDArray[np.generic]) -> Pixels:
    cv2 = import_cv2()
    pixels = _to_bytes(samples)
    if layout.channels == 1:
        pixels = pixels[:, :, 0]
    if layout.to_bgr:
        pixels = cv2.cvtColor(np.ascontiguousarray(pixels), getattr(cv2, layout.to_bgr))
    return np.ascontiguousarray(pixels, dtype=np.uint8)


def _to_bytes(samples: NDArray[np.generic]) -> Pixels:
    if samples.dtype == np.uint8:
        return samples.astype(np.uint8, copy=False)
    if samples.dtype == np.uint16:
        return (samples.astype(np.uint16, copy=False) >> 8).astype(np.uint8)
    values = samples.astype(np.float64)
    finite = np.isfinite(values)
    if not finite.any():
        return np.zeros(values.shape, np.uint8)
    low, high = values[finite].min(), values[finite].max()
    scaled = (np.where(finite, values, low) - low) * (255.0 / max(high - low, 1e-12))
    return np.rint(np.where(finite, scaled, 0.0)).astype(np.uint8)


def _check_planar(shape: RawShape, size: int) -> None:
    step, height = max(shape.step, shape.width), shape.height
    need = step * height * 3 if shape.encoding == "nv24" else step * height * 3 // 2
    odd = shape.encoding != "nv24" and (shape.width % 2 or height % 2)
    if shape.step < shape.width or size != need or odd:
        raise Damaged(
            "E402",
            f"{shape.width} x {height} {shape.encoding} with step {shape.step} needs {need} "
            f"bytes, has {size}",
        )


def _decode_planar(shape: RawShape, data: bytes) -> Pixels:
    """Luma plane followed by interleaved chroma: nv12 U V, nv21 V U, nv24 U V at full size."""
    cv2 = import_cv2()
    plane = np.frombuffer(data, np.uint8).reshape(-1, shape.step)
    if shape.encoding != "nv24":
        code = cv2.COLOR_YUV2BGR_NV12 if shape.encoding == "nv12" else cv2.COLOR_YUV2BGR_NV21
        return np.asarray(cv2.cvtColor(np.ascontiguousarray(plane[:, : shape.width]), code))
    luma = plane[: shape.height, : shape.width]
    chroma = plane[shape.height :].reshape(shape.height, -1)[:, : 2 * shape.width]
    u, v = chroma[:, 0::2].astype(np.float64) - 128.0, chroma[:, 1::2].astype(np.float64) - 128.0
    y = 1.164 * (luma.astype(np.float64) - 16.0)
    bgr = np.stack([y + 2.018 * u, y - 0.391 * u - 0.813 * v, y + 1.596 * v], axis=-1)
    return np.clip(np.rint(bgr), 0, 255).astype(np.uint8)
