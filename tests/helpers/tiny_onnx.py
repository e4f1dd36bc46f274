"""An ONNX network of one pooling layer, written byte by byte: no weights, no onnx package."""

from __future__ import annotations

from pathlib import Path

SIDE, POOL = 224, 28


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def _number(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _bytes(field: int, value: bytes) -> bytes:
    return _varint(field << 3 | 2) + _varint(len(value)) + value


def _tensor(name: str, shape: tuple[int, ...]) -> bytes:
    dims = b"".join(_bytes(1, _number(1, size)) for size in shape)
    kind = _bytes(1, _number(1, 1) + _bytes(2, dims))
    return _bytes(1, name.encode()) + _bytes(2, kind)


def _sizes(name: str) -> bytes:
    return _bytes(5, _bytes(1, name.encode()) + _number(8, POOL) * 2 + _number(20, 7))


def network() -> bytes:
    """AveragePool over squares of POOL pixels: (1, 3, SIDE, SIDE) -> (1, 3, 8, 8)."""
    node = _bytes(1, b"x") + _bytes(2, b"y") + _bytes(4, b"AveragePool")
    node += _sizes("kernel_shape") + _sizes("strides")
    graph = _bytes(1, node) + _bytes(2, b"pool")
    graph += _bytes(11, _tensor("x", (1, 3, SIDE, SIDE)))
    graph += _bytes(12, _tensor("y", (1, 3, SIDE // POOL, SIDE // POOL)))
    opset = _bytes(8, _bytes(1, b"") + _number(2, 13))
    return _number(1, 8) + _bytes(7, graph) + opset


def write(path: Path) -> Path:
    """The network as a file."""
    path.write_bytes(network())
    return path
