"""Global descriptors from a network a user names: any ONNX file, run by OpenCV's dnn.

For instance a net trained for place recognition, or the front of one trained for something else
(N. Suenderhauf et al.: On the performance of ConvNet features for place recognition, IROS 2015).
No weights come with fpnav; the file's digest stands in every result made with it.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import UsageError
from fpnav.params import Params, Pixels
from fpnav.publish import file_digest
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector, cosine, no_turns
from fpnav.values import FloatArray


class OnnxParams(ImageParams, frozen=True):
    """``file`` of the network; ``sha256`` it must have, where given; ``width_px``, ``height_px`` of
    its input; ``mean`` subtracted of every channel and ``scale`` multiplied, ``rgb`` order;
    ``output`` layer, empty = the last."""

    file: str = ""
    sha256: str = ""
    width_px: Pixels = 224
    height_px: Pixels = 224
    mean: float = 127.5
    scale: float = 1.0 / 127.5
    rgb: bool = True
    output: str = ""


class Onnx(ImageSystem):
    """The output of a network, of length 1."""

    NAME: ClassVar[str] = "onnx"
    SUMMARY: ClassVar[str] = "global descriptors from an ONNX file, --set onnx.file=NET.onnx"
    PARAMS: ClassVar[type[Params]] = OnnxParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE
    PRESETS: ClassVar[Mapping[str, Params]] = {"paper": OnnxParams(), "default": OnnxParams()}

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """The output for an image.

        Raises
        ------
        UsageError
            No file was named, or OpenCV cannot run it.
        """
        p = self._params
        blob = cv2.dnn.blobFromImage(
            pixels, p.scale, (p.width_px, p.height_px), (p.mean,) * 3, swapRB=p.rgb
        )
        try:
            net = _network(p.file, p.sha256)
            net.setInput(blob)
            found = net.forward(p.output) if p.output else net.forward()
        except cv2.error as error:
            said = str(error).strip().splitlines()[-1]
            raise UsageError(f"{p.file}: OpenCV cannot run this network: {said}") from error
        flat = np.asarray(found, np.float32).ravel()
        return np.asarray(flat / max(float(np.linalg.norm(flat)), 1e-9), np.float32)

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Cosines."""
        return no_turns(np.asarray(members @ query, np.float64))

    def alike(self, first: Vector, second: Vector) -> float:
        """Cosine."""
        return cosine(first, second)


@functools.cache
def _network(file: str, sha256: str) -> Any:
    """The network of a file, read once a process."""
    if not file:
        raise UsageError("onnx needs a network: --set onnx.file=NET.onnx")
    if not Path(file).is_file():
        raise UsageError(f"{file}: no such network file")
    digest = file_digest(Path(file))
    if sha256 and digest != sha256:
        raise UsageError(f"{file}: sha256 is {digest}, expected {sha256}")
    return cv2.dnn.readNetFromONNX(file)
