"""What a file looks like, from its first bytes."""

from __future__ import annotations

from fpnav.logs.container import MAGIC

_SIGNS = (
    (MAGIC, "an MCAP log"),
    (b"#ROSBAG V", "a ROS 1 bag"),
    (b"SQLite format 3\x00", "a SQLite file, perhaps a ROS 2 db3 bag"),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file"),
    (b"\x1f\x8b", "a gzip file"),
    (b"PK\x03\x04", "a zip file"),
    (b"\x28\xb5\x2f\xfd", "a zstd file"),
    (b"\x04\x22\x4d\x18", "an lz4 file"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"\x89PNG", "a PNG image"),
    (b"%PDF", "a PDF file"),
    (b"version https://git-lfs", "a Git LFS pointer: fetch the file itself"),
)


def looks_like(head: bytes) -> str:
    """A few words for the user."""
    for sign, words in _SIGNS:
        if head.startswith(sign):
            return words
    text = head[:256].lstrip().lower()
    if text.startswith((b"<!doctype html", b"<html")):
        return "a web page"
    if head and not any(head.strip(b"\x00")):
        return "all zeros"
    printable = sum(byte in b"\t\r\n" or 32 <= byte < 127 for byte in head)
    if head and printable >= 0.95 * len(head):
        return "a text file"
    return "no format known here"
