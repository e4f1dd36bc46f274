"""Nearest patches: exact whatever is pruned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.matching import patches as module
from fpnav.matching.patches import NEVER, Nearest, Patches, nearest, nearest_pruned, nearest_whole


def brute(
    views: np.ndarray, store: np.ndarray, count: int, limit: int, allowed: np.ndarray | None = None
) -> tuple[list[list[int]], list[list[int]]]:
    rows, sads = [], []
    for view in views.astype(int):
        sad = np.abs(store.astype(int) - view).sum(axis=1)
        near = [r for r in range(len(store)) if sad[r] < limit and (allowed is None or allowed[r])]
        near.sort(key=lambda row: (sad[row], row))
        near = near[:count]
        rows.append(near + [-1] * (count - len(near)))
        sads.append([int(sad[row]) for row in near] + [NEVER] * (count - len(near)))
    return rows, sads


def patches(pixels: np.ndarray, rows: int, columns: int) -> Patches:
    return Patches.of(pixels.astype(np.uint8), rows, columns)


def assert_same(found: Nearest, wanted: tuple[list[list[int]], list[list[int]]]) -> None:
    assert found.rows.tolist() == wanted[0]
    assert found.sads.tolist() == wanted[1]


CASES = st.tuples(
    st.integers(0, 2**32 - 1),
    st.sampled_from([(4, 4), (8, 4), (5, 7), (1, 9), (16, 16)]),
    st.integers(0, 4),
    st.integers(0, 30),
    st.integers(1, 6),
    st.floats(0.0, 1.0),
    st.sampled_from([2, 30, 255]),
)


@pytest.mark.parametrize("search", [nearest_whole, nearest_pruned, nearest])
@given(case=CASES)
@settings(max_examples=60)
def test_every_way_finds_what_a_plain_loop_finds(search: object, case: tuple) -> None:
    seed, (rows, columns), views, store, count, share, contrast = case
    rng = np.random.default_rng(seed)
    a = rng.integers(0, contrast + 1, (views, rows * columns))
    b = rng.integers(0, contrast + 1, (store, rows * columns))
    allowed = rng.random(store) < 0.7 if seed % 2 else None
    limit = int(share * contrast * rows * columns) + 1
    found = search(patches(a, rows, columns), patches(b, rows, columns), count, limit, allowed)
    assert_same(found, brute(a, b, count, limit, allowed))


def test_pruning_is_exact_over_more_than_one_tile() -> None:
    rng = np.random.default_rng(5)
    store = np.repeat(rng.integers(0, 255, (3000, 16)), 3, axis=0)
    views = store[[10, 4000, 8999]] + rng.integers(0, 1, (3, 16))
    first, second = patches(views, 4, 4), patches(store, 4, 4)
    whole = nearest_whole(first, second, 5, 800)
    assert_same(nearest_pruned(first, second, 5, 800), (whole.rows.tolist(), whole.sads.tolist()))
    assert whole.rows[1, :3].tolist() == [3999, 4000, 4001]


def test_whole_comparison_is_exact_over_more_than_one_tile(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "TILE_BYTES", 64)
    rng = np.random.default_rng(6)
    store, views = rng.integers(0, 4, (50, 16)), rng.integers(0, 4, (6, 16))
    found = nearest_whole(patches(views, 4, 4), patches(store, 4, 4), 4, 40)
    assert_same(found, brute(views, store, 4, 40))


def test_large_stores_are_pruned(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(7)
    store, views = rng.integers(0, 9, (40, 16)), rng.integers(0, 9, (3, 16))
    wanted = brute(views, store, 3, 100)
    monkeypatch.setattr(module, "LARGE_BYTES", 1)
    monkeypatch.setattr(module, "nearest_whole", None)
    assert_same(nearest(patches(views, 4, 4), patches(store, 4, 4), 3, 100), wanted)


def test_equal_patches_are_ordered_by_row() -> None:
    store = np.tile(np.arange(16), (6, 1))
    found = nearest(patches(store[:1], 4, 4), patches(store, 4, 4), 4, 1)
    assert found.rows.tolist() == [[0, 1, 2, 3]]


def test_the_limit_itself_is_no_match() -> None:
    store = np.full((1, 16), 10)
    view = np.full((1, 16), 12)
    for search in (nearest_whole, nearest_pruned):
        assert search(patches(view, 4, 4), patches(store, 4, 4), 1, 32).rows.tolist() == [[-1]]
        assert search(patches(view, 4, 4), patches(store, 4, 4), 1, 33).rows.tolist() == [[0]]


def test_means_are_rounded_means_of_whole_blocks() -> None:
    pixels = np.arange(64).reshape(1, 64)
    made = patches(pixels, 8, 8)
    assert made.per_block == 16
    assert made.means.tolist() == [[14, 18, 46, 50]]
    assert patches(np.arange(30).reshape(1, 30), 5, 6).means.shape == (1, 1)


@given(st.integers(0, 2**32 - 1))
def test_block_means_bound_the_difference_from_below(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pair = patches(rng.integers(0, 256, (2, 64)), 8, 8)
    apart = np.abs(pair.means[0].astype(int) - pair.means[1]).sum()
    bound = max(0, (apart - pair.means.shape[1]) * pair.per_block)
    assert bound <= np.abs(pair.pixels[0].astype(int) - pair.pixels[1]).sum()
