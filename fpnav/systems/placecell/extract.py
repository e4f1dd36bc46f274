"""From a frame to local views: what the camera sees around its focus points, and where."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.focus import DogFilter, Region, focus_points
from fpnav.sensing.gradient import FloatImage, deriche_radius, gradient_magnitude
from fpnav.sensing.logpolar import local_views, standardised
from fpnav.sensing.sight import (
    Sight,
    camera_sight,
    hidden_columns,
    omni_sight,
    panorama_sight,
)
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.values import Frame

VIEW = np.dtype(
    [
        ("bearing_rad", "<f4"),
        ("elevation_rad", "<f4"),
        ("strength", "<f4"),
        ("image", "<i4"),
    ]
)
"""A local view: direction in the robot's frame, DoG response, images back (0 = the newest)."""

CAMERA_ROLES = ("panorama", "omni", "camera")


def features_of_frame(frame: Frame, params: PlacecellParams) -> dict[str, NDArray[Any]]:
    """Views of a frame: ``views`` VIEW, ``pixels`` flat, ``panned`` whether the camera pans."""
    sight = sight_of(frame, params.width)
    if sight is None:
        rows, pixels = np.zeros(0, VIEW), np.zeros((0, params.pixels), np.uint8)
    else:
        rows, pixels = views_of(sight, params)
    panned = sight is not None and not sight.circular and frame.pan_rad is not None
    return {"views": rows, "pixels": pixels.ravel(), "panned": np.array([panned])}


def sight_of(frame: Frame, width_px: int) -> Sight | None:
    """What the first camera a frame has sees, or None."""
    if frame.panorama is not None:
        return panorama_sight(frame.panorama, width_px)
    if frame.omni is not None:
        return omni_sight(frame.omni, width_px)
    if frame.camera is not None:
        return camera_sight(frame.camera, width_px, frame.pan_rad or 0.0)
    return None


def views_of(sight: Sight, params: PlacecellParams) -> tuple[NDArray[Any], NDArray[np.uint8]]:
    """Local views of an image, strongest first: rows of VIEW (n,) and pixels (n, D)."""
    dog = DogFilter.of_size(
        params.dog_sigma1, params.dog_sigma2, params.dog_size, half=params.dog_size_is_half
    )
    pad = _padding(sight, dog, params)
    border = cv2.copyMakeBorder(sight.pixels, 0, 0, pad, pad, cv2.BORDER_WRAP)
    image = np.asarray(border, dtype=np.uint8)
    gradient = gradient_magnitude(image, params.deriche, pad)
    points, strength = focus_points(
        dog.response(gradient),
        dog.reach_px,
        params.focus if sight.circular else params.focus_image,
        _region(image, pad, params),
        params.focus_spacing * params.radius,
    )
    pixels = _pixels(image, gradient, points, params)
    rows = np.zeros(len(points), VIEW)
    rows["bearing_rad"], rows["elevation_rad"] = sight.directions(points - np.array([pad, 0]))
    rows["strength"] = strength
    return rows, pixels


def _padding(sight: Sight, dog: DogFilter, params: PlacecellParams) -> int:
    """Columns of the other edge that filters and discs at a seam reach into."""
    if not sight.circular:
        return 0
    reach = deriche_radius(params.deriche) + dog.half_px + dog.reach_px
    return int(min(max(reach, math.ceil(params.radius)) + 1, sight.pixels.shape[1]))


def _region(image: NDArray[np.uint8], pad: int, params: PlacecellParams) -> Region:
    """Points whose disc stays in the image and clear of what is hidden.

    A panorama, padded by the columns of its other edge, has no left and right border.
    """
    height, width = image.shape[0], image.shape[1] - 2 * pad
    margin = math.ceil(params.focus_margin * params.radius)
    shut = hidden_columns(image, math.ceil(params.radius)) if params.drop_hidden else None
    if pad:
        return Region(pad, pad + width, margin, height - margin, width, shut)
    return Region(margin, width - margin, margin, height - margin, 0, shut)


def _pixels(
    image: NDArray[np.uint8],
    gradient: FloatImage,
    points: NDArray[np.int64],
    params: PlacecellParams,
) -> NDArray[np.uint8]:
    if params.patch_source == "gradient":
        image = np.round(gradient * np.float32(255.0)).astype(np.uint8)
    views = local_views(image, points, params.radius, params.patch_columns, params.patch_rows)
    return standardised(views) if params.patch_norm == "meanstd" else views
