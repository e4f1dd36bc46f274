"""fpnav: topological maps of places from recorded robot logs."""

__version__ = "0.1.0"
