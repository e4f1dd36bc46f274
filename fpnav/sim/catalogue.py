"""The worlds there are, and their parameters: TOML file, ``--set``, then the generator."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from importlib import resources
from typing import Any

from fpnav.errors import UsageError
from fpnav.params import Params, Tables, resolve
from fpnav.sim.world import Route, World

WORLDS: dict[str, tuple[str, ...]] = {
    "office": ("map", "test", "loop-1", "loop-2", "loop-3", "loop-4", "loop-5"),
    "room": ("line", "homing"),
    "outdoor": ("line",),
    "suburb": ("loop", "street"),
    "gateways": ("route-1", "route-2", "route-3"),
    "gateway_types": tuple(f"type-{number:02d}" for number in range(1, 26)),
    "campus": ("tour",),
}
"""Name of a world (module of fpnav.sim.worlds) and its routes."""


@dataclass(frozen=True)
class Setting:
    """Which world, as it is on which run, with which parameters in place of the file's."""

    name: str
    seed: int = 1
    run: int = 1
    overrides: tuple[tuple[str, Any], ...] = ()

    def make(self) -> World:
        """The world itself.

        Raises
        ------
        UsageError
            No such world, or a parameter it does not have.
        """
        file_params = default_params(self.name)
        module: Any = importlib.import_module(f"fpnav.sim.worlds.{self.name}")
        params = resolve("world", file_params, {"world": dict(self.overrides)})
        world: World = module.make(params, self.seed, self.run)
        return world


def overrides_in(tables: Tables) -> tuple[tuple[str, Any], ...]:
    """The world's own parameters among the tables, in a form that can be a key."""
    table = tables.get("world", {})
    return tuple((key, _frozen(table[key])) for key in sorted(table))


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value


def world_file(name: str) -> dict[str, Any]:
    """The TOML file of a world: ``sensors``, its ``world`` block and what it sets of a rig."""
    import tomllib

    if name not in WORLDS:
        raise UsageError(f"no world {name!r}; known: {', '.join(WORLDS)}")
    text = (resources.files("fpnav.sim.worlds") / f"{name}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def default_params(name: str) -> Params:
    """The parameters of a world's TOML file."""
    import msgspec

    values = world_file(name)["world"]
    module: Any = importlib.import_module(f"fpnav.sim.worlds.{name}")
    block: Params = msgspec.convert(values, module.PARAMS)
    return block


def default_rig(name: str) -> tuple[list[str], Tables]:
    """The roles a world is recorded with, and the rig's values it sets."""
    file = world_file(name)
    return file["sensors"], {key: file[key] for key in file if key not in ("sensors", "world")}


def route_of(world: World, name: str) -> Route:
    """The named route of a world.

    Raises
    ------
    UsageError
        The world has no such route.
    """
    if name not in world.routes:
        raise UsageError(f"{world.name} has no route {name!r}; it has {', '.join(world.routes)}")
    return world.routes[name]
