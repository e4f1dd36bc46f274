"""Visual place cells: the system and its parameter block."""

from fpnav.systems.placecell.params import PlacecellParams
from fpnav.systems.placecell.system import Placecell

__all__ = ["Placecell", "PlacecellParams"]
