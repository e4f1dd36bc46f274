"""CRC32 as MCAP has it, by zlib-ng, or by zlib where zlib-ng could not be installed.

The values are the same; zlib-ng takes a tenth of the time, which is most of what reading an
uncompressed log costs.
"""

from __future__ import annotations

from collections.abc import Callable

try:
    from zlib_ng.zlib_ng import crc32 as _crc32
except ImportError:
    from zlib import crc32 as _crc32

crc32: Callable[[bytes | memoryview, int], int] = _crc32
