"""Descriptors from a network file: what it computes, what is said where it cannot."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import tiny_onnx

from fpnav.errors import UsageError
from fpnav.systems.registry import system_class


def system(**settings: Any) -> Any:
    kind = system_class("onnx")
    return kind(kind.PARAMS(**settings))


def pixels() -> np.ndarray[Any, np.dtype[np.uint8]]:
    rng = np.random.default_rng(0)
    return rng.integers(0, 255, (224, 224, 3), dtype=np.uint8)


def test_the_output_is_the_networks_of_length_one(tmp_path: Path) -> None:
    file = tiny_onnx.write(tmp_path / "pool.onnx")
    found = system(file=str(file)).vector(pixels(), circular=False)
    scaled = (pixels()[:, :, ::-1].astype(np.float64) - 127.5) / 127.5
    pooled = scaled.reshape(8, 28, 8, 28, 3).mean(axis=(1, 3)).transpose(2, 0, 1).ravel()
    assert found == pytest.approx(pooled / np.linalg.norm(pooled), abs=1e-4)


def test_a_file_of_another_digest_is_refused_and_the_right_one_taken(tmp_path: Path) -> None:
    file = tiny_onnx.write(tmp_path / "pool.onnx")
    digest = hashlib.sha256(tiny_onnx.network()).hexdigest()
    assert system(file=str(file), sha256=digest).vector(pixels(), circular=False).shape == (192,)
    with pytest.raises(UsageError, match="sha256"):
        system(file=str(file), sha256="0" * 64).vector(pixels(), circular=False)


def test_no_file_a_missing_one_and_one_that_is_no_network_are_told(tmp_path: Path) -> None:
    broken = tmp_path / "broken.onnx"
    broken.write_bytes(b"not a network")
    for file, said in (("", "onnx.file"), ("nowhere.onnx", "no such"), (str(broken), "OpenCV")):
        with pytest.raises(UsageError, match=said):
            system(file=file).vector(pixels(), circular=False)
