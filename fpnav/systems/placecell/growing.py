"""Arrays that grow at their end without being copied every time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class Growing:
    """Rows of one dtype and trailing shape; ``rows`` is a view that later growth leaves alone."""

    def __init__(self, dtype: Any, width: int = 0) -> None:
        self._shape = (width,) if width else ()
        self._buffer: NDArray[Any] = np.zeros((0, *self._shape), dtype)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def rows(self) -> NDArray[Any]:
        """All rows so far."""
        return self._buffer[: self._count]

    def extend(self, rows: NDArray[Any]) -> None:
        """Add rows at the end."""
        need = self._count + len(rows)
        if need > len(self._buffer):
            grown = np.zeros((max(need, 2 * len(self._buffer)), *self._shape), self._buffer.dtype)
            grown[: self._count] = self.rows
            self._buffer = grown
        self._buffer[self._count : need] = rows
        self._count = need

    def replace(self, rows: NDArray[Any]) -> None:
        """Hold these rows instead."""
        self._buffer = np.array(rows, self._buffer.dtype).reshape(-1, *self._shape)
        self._count = len(self._buffer)
