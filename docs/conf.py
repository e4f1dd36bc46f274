"""Sphinx configuration: MyST pages, command reference from the click objects themselves."""

from __future__ import annotations

import fpnav

project = "fpnav"
author = "The fpnav developers"
version = release = fpnav.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click"]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "fpnav"
autodoc_typehints = "description"
exclude_patterns = ["_build"]
nitpicky = False
