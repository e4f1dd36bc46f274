"""Values as columns and back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.stores import signatures, table
from hypothesis import given
from hypothesis import strategies as st

from fpnav.store.tables import REFERENCE, Ragged, label_bytes, reference_of, reference_row
from fpnav.values import Pose2, Reference

finite = st.floats(-1e6, 1e6)
poses = st.none() | st.builds(Pose2, finite, finite, finite)
references = st.builds(
    Reference,
    index=st.integers(0, 2**40),
    stamp_ns=st.integers(-(2**62), 2**62),
    session=st.integers(0, 1000),
    travelled_m=finite,
    odometry=poses,
    truth=poses,
    heading_rad=finite,
    label=st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=12),
)


@given(references)
def test_a_reference_becomes_a_row_and_comes_back(reference: Reference) -> None:
    assert reference_of(np.array([reference_row(reference)], REFERENCE)[0]) == reference


def test_what_is_unknown_stays_unknown() -> None:
    found = reference_of(np.array([reference_row(Reference(1, 2))], REFERENCE)[0])
    assert found.odometry is None
    assert found.truth is None
    assert math.isnan(found.travelled_m)
    assert math.isnan(found.heading_rad)


@given(st.text(max_size=80))
def test_long_labels_are_cut_between_characters(label: str) -> None:
    label = label.encode(errors="ignore").decode()
    cut = label_bytes(label)
    assert len(cut) <= 64
    assert label.startswith(cut.decode())
    assert label_bytes(cut.decode()) == cut


def test_rows_of_unequal_length_keep_their_order() -> None:
    rows = [np.array([1, 2]), np.array([], dtype=np.int64), np.array([3])]
    ragged = Ragged.of(rows, np.dtype(np.int64))
    assert [ragged[row].tolist() for row in range(len(ragged))] == [[1, 2], [], [3]]
    assert ragged.offsets.tolist() == [0, 2, 2, 3]
    assert len(Ragged.of([], np.dtype("f4"))) == 0


def test_a_table_is_a_sequence_of_the_signatures_it_was_made_of() -> None:
    columns = table()
    assert len(columns) == 3
    for found, given_ in zip(columns, signatures(), strict=True):
        assert repr(found.reference) == repr(given_.reference)
        assert found.record == given_.record
        assert found.parts["bins"].tolist() == given_.parts["bins"].tolist()
    assert columns[-1].reference.label == "Küche"
    assert [row.reference.index for row in columns[1:]] == [3, 7]
    assert [row.reference.index for row in columns[::-1]] == [7, 3, 0]


def test_rows_beyond_a_table_are_refused() -> None:
    with pytest.raises(IndexError):
        table()[3]
    with pytest.raises(IndexError):
        table()[-4]
