"""CSV: of a map one row per place, of a result one row per query."""

from __future__ import annotations

import numpy as np

from fpnav.evaluation.evaluate import evaluate
from fpnav.evaluation.sheets import query_sheet, sheet
from fpnav.export.subject import Subject

_HEAD = ["place", "x_m", "y_m", "heading_rad", "extent_m", "observations", "label", "signature"]


def write(subject: Subject) -> bytes:
    """The rows; text that a spreadsheet would take for a formula is quoted."""
    if subject.result is not None:
        return query_sheet(evaluate(subject.result))
    view = subject.view
    rows: list[list[object]] = [list(_HEAD)]
    for row, place in enumerate(view.place_ids.tolist()):
        members = int((subject.owner == place).sum())
        pose = np.asarray(view.place_pose[row]).tolist()
        extent = float(view.extent_m[row])
        rows.append([place, *pose, extent, members, subject.labels[row], subject.strip(row)])
    return sheet(rows)
