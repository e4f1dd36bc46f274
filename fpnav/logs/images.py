"""Images as they stand in messages, decoded to BGR within bounds.

Compressed: JPEG, PNG and WebP, told by their magic, never by what the message calls them. The
size is read from the image's own header before anything is decoded; EXIF rotation is ignored.
"""

from __future__ import annotations

import contextlib
import os
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.logs import limits
from fpnav.logs.container import Damaged

_PNG = b"\x89PNG\r\n\x1a\n"
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_JPEG_BARE = frozenset({0x01, *range(0xD0, 0xD9)})


def encoded_size(data: bytes) -> tuple[int, int]:
    """(width, height) of a JPEG, PNG or WebP image from its header.

    Raises
    ------
    Damaged
        E401 empty, E403 another format, E406 cut off, E407 more pixels than the limit.
    """
    if not data:
        raise Damaged("E401", "empty image")
    try:
        width, height = _size(data)
    except (struct.error, IndexError):
        raise Damaged("E406", "image ends within its header") from None
    if width < 1 or height < 1:
        raise Damaged("E401", f"image of {width} x {height} pixels")
    if width * height > limits.IMAGE_PIXELS:
        raise Damaged("E407", f"image of {width} x {height} pixels is over the limit")
    return width, height


def format_of(data: bytes) -> str:
    """jpeg, png or webp, by the magic; empty for anything else."""
    if data.startswith(b"\xff\xd8\xff"):
        return "jpeg"
    if data.startswith(_PNG):
        return "png"
    return "webp" if data.startswith(b"RIFF") and data[8:12] == b"WEBP" else ""


def _size(data: bytes) -> tuple[int, int]:
    kind = format_of(data)
    if kind == "jpeg":
        return _jpeg_size(data)
    if kind == "png":
        width, height = struct.unpack_from(">II", data, 16)
        return int(width), int(height)
    if kind == "webp":
        return _webp_size(data)
    raise Damaged("E403", f"not JPEG, PNG or WebP (starts with {data[:8].hex(' ')})")


def _jpeg_size(data: bytes) -> tuple[int, int]:
    """Size from the frame header; the image must also have its end marker after the scan."""
    at = 2
    size: tuple[int, int] | None = None
    while True:
        if data[at] != 0xFF:
            raise Damaged("E406", "JPEG marker expected")
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
            continue
        if marker in _JPEG_BARE:
            at += 2
            continue
        if marker == 0xDA:
            break
        if marker in _JPEG_FRAMES:
            height, width = struct.unpack_from(">HH", data, at + 5)
            size = (width, height)
        at += 2 + int(struct.unpack_from(">H", data, at + 2)[0])
    if size is None or data.rfind(b"\xff\xd9", at) < 0:
        raise Damaged("E406", "JPEG has no end marker")
    return size


def _webp_size(data: bytes) -> tuple[int, int]:
    if struct.unpack_from("<I", data, 4)[0] + 8 > len(data):
        raise Damaged("E406", "WebP is cut off")
    kind = data[12:16]
    if kind == b"VP8X":
        width = 1 + int.from_bytes(data[24:27], "little")
        return width, 1 + int.from_bytes(data[27:30], "little")
    if kind == b"VP8L":
        (bits,) = struct.unpack_from("<I", data, 21)
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    width, height = struct.unpack_from("<HH", data, 26)
    return width & 0x3FFF, height & 0x3FFF


def decode_encoded(data: bytes) -> NDArray[np.uint8]:
    """Pixels (H, W, 3) uint8 BGR of a JPEG, PNG or WebP image; raises Damaged as encoded_size."""
    encoded_size(data)
    cv2 = import_cv2()
    with _silence():
        try:
            flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
            pixels = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
        except cv2.error as error:
            raise Damaged("E406", f"image cannot be decoded: {error}".strip()) from None
    if pixels is None:
        raise Damaged("E406", "image cannot be decoded")
    return np.asarray(pixels, dtype=np.uint8)


def encode_png(pixels: NDArray[np.uint8]) -> bytes:
    """PNG bytes of an image, (H, W, 3) BGR or (H, W) grey; lossless."""
    cv2 = import_cv2()
    done, data = cv2.imencode(".png", pixels)
    if not done:
        raise Damaged("E406", "image cannot be encoded")
    return bytes(data)


def import_cv2() -> Any:
    """OpenCV with its own pixel limit set before it is first imported."""
    os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(limits.IMAGE_PIXELS))
    import cv2

    return cv2


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep the C decoders' remarks on damaged images off the terminal (fd 2)."""
    kept = os.dup(2)
    sink = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(sink, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(sink)
        os.close(kept)
