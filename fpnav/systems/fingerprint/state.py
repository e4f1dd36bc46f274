"""A memory as named arrays and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.systems.base import State
from fpnav.systems.fingerprint import model as models
from fpnav.systems.fingerprint import scoring
from fpnav.systems.fingerprint.mean import Mean
from fpnav.systems.fingerprint.model import Model
from fpnav.systems.fingerprint.symbols import FEATURE

ARRAYS = ("places", "views", "observations", "arcs", "offsets", "features", "current")


def saved_views(views: Mapping[int, list[Mean]], current: int, model: Model) -> State:
    """Every place's views, the mean first, as flat arrays, and the model."""
    places = sorted(views)
    rows = [view for place in places for view in views[place]]
    lengths = [len(row.features) for row in rows]
    return {
        "places": np.array(places, np.int64),
        "views": np.array([len(views[place]) for place in places], np.int64),
        "observations": np.array([row.observations for row in rows], np.int64),
        "arcs": np.array([row.arcs for row in rows]).reshape(-1, scoring.KINDS, 2),
        "offsets": np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
        "features": np.concatenate([np.zeros(0, FEATURE), *(row.features for row in rows)]),
        "current": np.array([current], np.int64),
        **models.saved(model),
    }


def loaded_views(
    saved: Mapping[str, NDArray[Any]],
) -> tuple[dict[int, list[Mean]], int, Model]:
    """Views by place, the present place and the model.

    Raises
    ------
    StoreError
        An array is missing.
    """
    missing = [name for name in (*ARRAYS, *models.STATE) if name not in saved]
    if missing:
        raise StoreError(
            f"the fingerprint memory lacks {', '.join(missing)}; found {', '.join(saved)}; "
            "build the map again"
        )
    offsets = saved["offsets"]
    rows = [
        Mean(np.array(saved["features"][a:b]), np.array(arcs), int(seen))
        for a, b, arcs, seen in zip(
            offsets[:-1], offsets[1:], saved["arcs"], saved["observations"], strict=True
        )
    ]
    stops = np.cumsum(saved["views"])
    views = {
        int(place): rows[stop - count : stop]
        for place, count, stop in zip(saved["places"], saved["views"], stops, strict=True)
    }
    return views, int(saved["current"][0]), models.loaded(saved)
