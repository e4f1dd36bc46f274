"""Images: told by their bytes, bounded before they are decoded, every raw encoding the same."""

from __future__ import annotations

import os
import struct
import zlib

import cv2
import numpy as np
import pytest
from helpers.logs import jpeg
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.logs.container import Damaged
from fpnav.logs.decode import EncodedImage, UncompressedImage
from fpnav.logs.images import decode_encoded, encode_png, encoded_size, format_of
from fpnav.logs.raw_images import ENCODINGS, RawShape, decode_raw


def encoded(suffix: str, width: int = 20, height: int = 10) -> bytes:
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, :5] = (255, 0, 0)
    done, data = cv2.imencode(suffix, pixels)
    assert done
    return bytes(data)


@pytest.mark.parametrize(("suffix", "name"), [(".jpg", "jpeg"), (".png", "png"), (".webp", "webp")])
def test_each_format_is_told_measured_and_decoded(suffix: str, name: str) -> None:
    data = encoded(suffix)
    assert format_of(data) == name
    assert encoded_size(data) == (20, 10)
    pixels = decode_encoded(data)
    assert pixels.shape == (10, 20, 3)
    assert pixels[5, 1, 0] > 200
    assert pixels[5, 15].max() < 60


@pytest.mark.parametrize("quality", [cv2.IMWRITE_WEBP_QUALITY])
def test_a_lossless_webp_is_measured(quality: int) -> None:
    done, data = cv2.imencode(".webp", np.zeros((7, 33, 3), np.uint8), [quality, 101])
    assert done
    assert encoded_size(bytes(data)) == (33, 7)


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".webp"])
def test_an_image_cut_anywhere_is_refused(suffix: str) -> None:
    data = encoded(suffix)
    for cut in range(0, len(data) - 1, 3):
        with pytest.raises(Damaged) as caught:
            decode_encoded(data[:cut])
        assert caught.value.code in ("E401", "E403", "E406"), cut


def test_a_jpeg_needs_its_end_marker_and_may_have_padding_behind_it() -> None:
    data = jpeg()
    assert encoded_size(data + b"\x00" * 9) == (32, 16)
    with pytest.raises(Damaged, match="JPEG has no end marker"):
        encoded_size(data[:-2])


@pytest.mark.parametrize("data", [b"GIF89a....", b"\x76\x2f\x31\x01exr", b"<svg/>", b"BM12"])
def test_other_formats_are_refused_with_their_first_bytes(data: bytes) -> None:
    with pytest.raises(Damaged, match="not JPEG, PNG or WebP") as caught:
        encoded_size(data)
    assert caught.value.code == "E403"


def png_header(width: int, height: int) -> bytes:
    body = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + body + struct.pack(">I", zlib.crc32(body))


def test_a_bomb_is_refused_by_its_header() -> None:
    with pytest.raises(Damaged, match="over the limit") as caught:
        decode_encoded(png_header(20_000, 20_000))
    assert caught.value.code == "E407"
    with pytest.raises(Damaged, match="0 x 5") as caught:
        encoded_size(png_header(0, 5))
    assert caught.value.code == "E401"


def test_decoders_keep_their_remarks_to_themselves(capfd: pytest.CaptureFixture[str]) -> None:
    data = bytearray(jpeg(200, 100))
    data[len(data) // 2] ^= 0xFF
    for _ in range(3):
        try:
            decode_encoded(bytes(data))
        except Damaged:
            continue
    assert capfd.readouterr().err == ""
    os.write(2, b"heard")
    assert capfd.readouterr().err == "heard"


def test_payloads_raise_one_line_where_they_are_damaged() -> None:
    with pytest.raises(LogError, match=r"a\.mcap /camera message 7: E403 not JPEG"):
        EncodedImage(b"nothing", "a.mcap /camera message 7").decode()
    with pytest.raises(LogError, match="E403 encoding 'huh' is none of"):
        UncompressedImage(b"abc", RawShape(1, 1, "huh", 3), "x").decode()


def test_png_is_lossless() -> None:
    pixels = np.random.default_rng(1).integers(0, 255, (9, 11, 3), dtype=np.uint8)
    assert np.array_equal(decode_encoded(encode_png(pixels)), pixels)


BLUE = np.array([230, 40, 20], np.uint8)
RED = np.array([20, 40, 230], np.uint8)


def target() -> NDArray[np.uint8]:
    """A painted target: left half blue, right half red."""
    pixels = np.empty((8, 8, 3), np.uint8)
    pixels[:, :4], pixels[:, 4:] = BLUE, RED
    return pixels


def grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY))


def yuv_planes(pixels: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Luma (H, W) and chroma (H, W, 2) in video range."""
    b, g, r = (pixels[..., i].astype(float) for i in range(3))
    y = 16 + 0.257 * r + 0.504 * g + 0.098 * b
    u = 128 - 0.148 * r - 0.291 * g + 0.439 * b
    v = 128 + 0.439 * r - 0.368 * g - 0.071 * b
    return np.rint(y).astype(np.uint8), np.rint(np.stack([u, v], -1)).astype(np.uint8)


def interleaved(pixels: NDArray[np.uint8], *, luma_first: bool) -> NDArray[np.uint8]:
    y, uv = yuv_planes(pixels)
    chroma = np.empty_like(y)
    chroma[:, 0::2], chroma[:, 1::2] = uv[:, 0::2, 0], uv[:, 0::2, 1]
    pair = (y, chroma) if luma_first else (chroma, y)
    return np.stack(pair, axis=-1).reshape(y.shape[0], -1)


def mosaic(pixels: NDArray[np.uint8], pattern: str) -> NDArray[np.uint8]:
    channel = {"b": 0, "g": 1, "r": 2}
    out = np.empty(pixels.shape[:2], np.uint8)
    for i, letter in enumerate(pattern):
        out[i // 2 :: 2, i % 2 :: 2] = pixels[i // 2 :: 2, i % 2 :: 2, channel[letter]]
    return out


def planar(pixels: NDArray[np.uint8], encoding: str) -> NDArray[np.uint8]:
    y, uv = yuv_planes(pixels)
    if encoding == "nv24":
        return np.concatenate([y.ravel(), uv.ravel()])
    uv = uv[0::2, 0::2]
    if encoding == "nv21":
        uv = uv[..., ::-1]
    return np.concatenate([y.ravel(), uv.ravel()])


def raw(encoding: str) -> tuple[NDArray[np.generic], NDArray[np.uint8]]:
    """Data of the target in an encoding, and what it must decode to."""
    pixels = target()
    shown = np.repeat(grey(pixels)[..., None], 3, axis=-1)
    wide = pixels.astype("<u2") * 256 + 77
    alpha = np.full((8, 8, 1), 255, np.uint8)
    cases: dict[str, tuple[NDArray[np.generic], NDArray[np.uint8]]] = {
        "mono8": (grey(pixels), shown),
        "mono16": (grey(pixels).astype("<u2") * 256, shown),
        "bgr8": (pixels, pixels),
        "rgb8": (pixels[..., ::-1], pixels),
        "bgra8": (np.concatenate([pixels, alpha], -1), pixels),
        "rgba8": (np.concatenate([pixels[..., ::-1], alpha], -1), pixels),
        "bgr16": (wide, pixels),
        "rgb16": (wide[..., ::-1], pixels),
        "bgra16": (np.concatenate([wide, alpha.astype("<u2")], -1), pixels),
        "rgba16": (np.concatenate([wide[..., ::-1], alpha.astype("<u2")], -1), pixels),
        "uyvy": (interleaved(pixels, luma_first=False), pixels),
        "yuv422": (interleaved(pixels, luma_first=False), pixels),
        "yuyv": (interleaved(pixels, luma_first=True), pixels),
        "yuv422_yuy2": (interleaved(pixels, luma_first=True), pixels),
        "8UC1": (grey(pixels), shown),
        "8UC3": (pixels, pixels),
        "8UC4": (np.concatenate([pixels, alpha], -1), pixels),
        "16UC1": (grey(pixels).astype("<u2") * 256, shown),
        **{name: (planar(pixels, name), pixels) for name in ("nv12", "nv21", "nv24")},
        **{
            f"bayer_{pattern}8": (mosaic(pixels, pattern), pixels)
            for pattern in ("rggb", "bggr", "gbrg", "grbg")
        },
        **{
            f"bayer_{pattern}16": (mosaic(pixels, pattern).astype("<u2") * 256, pixels)
            for pattern in ("rggb", "bggr", "gbrg", "grbg")
        },
    }
    return cases[encoding]


PAINTED = [
    "mono8", "mono16", "bgr8", "rgb8", "bgra8", "rgba8", "bgr16", "rgb16", "bgra16", "rgba16",
    "uyvy", "yuv422", "yuyv", "yuv422_yuy2", "8UC1", "8UC3", "8UC4", "16UC1",
    "nv12", "nv21", "nv24",
    *(f"bayer_{p}{bits}" for p in ("rggb", "bggr", "gbrg", "grbg") for bits in (8, 16)),
]  # fmt: skip


@pytest.mark.parametrize("encoding", PAINTED)
def test_a_painted_target_keeps_its_colours(encoding: str) -> None:
    data, expected = raw(encoding)
    content = np.ascontiguousarray(data).tobytes()
    step = 8 if encoding.startswith("nv") else len(content) // 8
    pixels = decode_raw(RawShape(8, 8, encoding, step), content)
    inner = (slice(2, 6), [1, 2, 5, 6])
    assert pixels.shape == (8, 8, 3)
    assert np.abs(pixels[inner].astype(int) - expected[inner].astype(int)).max() <= 4


@pytest.mark.parametrize("encoding", ["32FC1", "64FC1", "32SC1", "16SC1", "8SC1"])
def test_measurements_are_stretched_to_grey(encoding: str) -> None:
    dtype = np.dtype("<" + ENCODINGS[encoding].sample)
    values = np.array([[0, 40, 100]], dtype=dtype)
    pixels = decode_raw(RawShape(3, 1, encoding, 3 * dtype.itemsize), values.tobytes())
    assert pixels[0, :, 0].tolist() == [0, 102, 255]


def test_unknown_depth_is_black() -> None:
    values = np.array([[np.nan, 1.0, np.inf, 3.0]], "<f4").tobytes()
    pixels = decode_raw(RawShape(4, 1, "32FC1", 16), values)
    assert pixels[0, :, 0].tolist() == [0, 0, 0, 255]
    nothing = np.full((1, 4), np.nan, "<f4").tobytes()
    assert not decode_raw(RawShape(4, 1, "32FC1", 16), nothing).any()


def test_padded_rows_and_big_endian_samples_are_read() -> None:
    pixels = target()
    rows = np.zeros((8, 32), np.uint8)
    rows[:, :24] = pixels.reshape(8, 24)
    assert np.array_equal(decode_raw(RawShape(8, 8, "bgr8", 32), rows.tobytes()), pixels)
    big = (grey(pixels).astype("u2") * 256).astype(">u2").tobytes()
    decoded = decode_raw(RawShape(8, 8, "mono16", 16, big_endian=True), big)
    assert np.array_equal(decoded[..., 0], grey(pixels))


@pytest.mark.parametrize(
    ("code", "shape", "size"),
    [
        ("E401", RawShape(0, 8, "bgr8", 24), 192),
        ("E401", RawShape(8, 8, "bgr8", 24), 0),
        ("E402", RawShape(8, 8, "bgr8", 23), 184),
        ("E402", RawShape(8, 8, "bgr8", 24), 191),
        ("E402", RawShape(7, 8, "yuyv", 14), 112),
        ("E402", RawShape(8, 8, "nv12", 8), 95),
        ("E402", RawShape(7, 8, "nv21", 7), 84),
        ("E403", RawShape(8, 8, "BGR8", 24), 192),
        ("E403", RawShape(8, 8, "", 24), 192),
        ("E407", RawShape(10_000, 10_000, "mono8", 10_000), 10**8),
    ],
)
def test_fields_that_contradict_are_refused(code: str, shape: RawShape, size: int) -> None:
    with pytest.raises(Damaged) as caught:
        UncompressedImage(b"\0" * min(size, 200), shape).check()
    assert caught.value.code == code or size > 200
    if size <= 200:
        return
    from fpnav.logs.raw_images import check_raw

    with pytest.raises(Damaged) as caught:
        check_raw(shape, size)
    assert caught.value.code == code
