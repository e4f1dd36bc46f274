"""Fixtures every test may use."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]

# A shell starts background jobs with SIGINT ignored, nohup with SIGHUP; children inherit that, and
# what the tests send to them would be lost.
if threading.current_thread() is threading.main_thread():
    for _number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        if signal.getsignal(_number) is signal.SIG_IGN:
            signal.signal(_number, signal.SIG_DFL)


# A kernel that compiles on its first call, or a busy machine, is no failure of an example.
settings.register_profile("fpnav", deadline=None)
settings.load_profile("fpnav")


@pytest.fixture(scope="session")
def data() -> Path:
    """Folder of real recordings, from FPNAV_DATA (relative to the checkout, as make has it); tests
    that need it skip where it is absent."""
    folder = (ROOT / os.environ.get("FPNAV_DATA", "../shared/data")).resolve()
    if not folder.is_dir():
        pytest.skip(f"no recordings: FPNAV_DATA or {folder.name}/ is absent")
    return folder


@pytest.fixture(scope="session")
def root() -> Path:
    """The checkout."""
    return ROOT
