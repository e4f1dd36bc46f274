"""Bounds on what an untrusted log may ask for (faults.md 1.7)."""

from __future__ import annotations

RECORD_BYTES = 2**30
CHUNK_BYTES = 256 * 2**20
MESSAGE_BYTES = 256 * 2**20
IMAGE_PIXELS = 2**26
SCHEMA_BYTES = 2**20
BEAMS = 1_000_000
LINE_BYTES = 2**20
TEXT_BYTES = 2**30
ATTACHMENT_BYTES = 64 * 2**20
CACHE_BYTES = 64 * 2**20
