"""index.html: one page that carries everything with it and runs nothing."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup


def render(context: Mapping[str, Any], template: str = "page.html.jinja") -> bytes:
    """The page of a context (fpnav.report.context). Every value is escaped; names from logs are
    values, never templates."""
    environment = Environment(
        autoescape=True,
        loader=FunctionLoader(_resource),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    css = Markup(_resource("page.css"))
    return environment.get_template(template).render(css=css, **context).encode()


def _resource(name: str) -> str:
    return (files("fpnav.report") / name).read_text(encoding="utf-8")
