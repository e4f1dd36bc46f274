"""Navigation: homing (figure 6), the loop (figure 8), and being carried off."""

from __future__ import annotations
