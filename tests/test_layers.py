"""The house keeps its order: who may import whom, who may write, who may know a system's name."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

from fpnav.systems.registry import SYSTEMS

ROOT = Path(__file__).resolve().parents[1]
HOUSE = ROOT / "fpnav"

ROOMS = (
    "values", "errors", "params", "geometry", "publish", "logs", "sensing", "matching", "systems",
    "topomap", "store", "localization", "mapping", "navigation", "evaluation", "execution",
    "export", "report", "sim", "experiments", "cli",
)  # fmt: skip
"""A room imports only rooms listed above it, and its own files (docs: design)."""

ONE_ROOM = {
    "mcap": "logs", "rosbags": "logs", "lz4": "logs", "zstandard": "logs", "h5py": "store",
    "matplotlib": "report", "jinja2": "report", "click": "cli", "rich": "cli",
    "dask": "execution", "distributed": "execution", "trimesh": "sim", "embreex": "sim",
    "foxglove": "export", "markupsafe": "report", "google": "logs", "mcap_protobuf": "logs",
    "zlib_ng": "logs",
}  # fmt: skip
"""Libraries that are named in one room only."""

BRINGS = {
    "opencv_python_headless": {"cv2"}, "jinja2": {"jinja2", "markupsafe"},
    "foxglove_sdk": {"foxglove"}, "distributed": {"distributed", "dask"},
    "mcap_protobuf_support": {"mcap_protobuf", "google"},
}  # fmt: skip
"""What is imported of a dependency, where that is not its own name."""

EVERYWHERE = {"numpy", "msgspec", "networkx", "cv2", "numba"}
SIBLINGS = {
    "fpnav.systems": {"base", "descriptors", "images", "lasers", "calibration"},
    "fpnav.logs.sources": {"base"},
    "fpnav.export": {"subject", "graph", "scene_parts"},
}
"""Folders of equals, and what they stand on together."""

NAMES = {*SYSTEMS, "fingerprint", "placecell", "gateway"}
FILES = sorted(HOUSE.rglob("*.py"))


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in FILES}


@cache
def nodes_of(module: str) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))))


def room_of(module: str) -> str:
    """The room a module stands in; none for the package itself."""
    return {"fpnav": "", "fpnav.__main__": "cli"}.get(module) or (*module.split("."), "")[1]


@cache
def imports_of(module: str) -> frozenset[str]:
    """Every module a module imports, wherever in it the import stands."""
    return frozenset(_imports(module))


def _imports(module: str) -> Iterator[str]:
    for node in nodes_of(module):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = absolute(module, node)
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                yield inner if inner in MODULES else base


def absolute(module: str, node: ast.ImportFrom) -> str:
    if node.level == 0:
        return node.module or ""
    is_package = MODULES[module].name == "__init__.py"
    parts = module.split(".")
    kept = parts[: len(parts) - node.level + is_package]
    return ".".join([*kept, node.module] if node.module else kept)


def own_imports(module: str) -> set[str]:
    return {target for target in imports_of(module) if target.split(".")[0] == "fpnav"} - {"fpnav"}


def foreign_imports(module: str) -> set[str]:
    tops = {target.split(".")[0] for target in imports_of(module)}
    return tops - set(sys.stdlib_module_names) - {"fpnav", ""}


def wrong(found: Iterator[str]) -> None:
    problems = sorted(set(found))
    assert not problems, "\n" + "\n".join(problems)


def test_every_file_stands_in_a_room_that_is_listed() -> None:
    wrong(f"{module}: no room" for module in MODULES if room_of(module) not in (*ROOMS, ""))


def test_the_walk_sees_imports_hidden_in_functions_and_relative_ones() -> None:
    assert "fpnav.systems.registry" in imports_of("fpnav.cli.systems")
    node = ast.parse("from ..base import x").body[0]
    assert isinstance(node, ast.ImportFrom)
    assert absolute("fpnav.systems.registry", node) == "fpnav.base"
    assert absolute("fpnav.systems", node) == "fpnav.base"


def test_rooms_import_only_rooms_above_them() -> None:
    wrong(
        f"{module} imports {target}"
        for module in MODULES
        for target in own_imports(module)
        if room_of(module) and ROOMS.index(room_of(target)) > ROOMS.index(room_of(module))
    )


def test_no_imports_go_in_a_circle_not_even_hidden_ones() -> None:
    graph = nx.DiGraph()
    graph.add_edges_from(
        (module, target) for module in MODULES for target in own_imports(module) if target != module
    )
    wrong(
        " -> ".join(sorted(knot))
        for knot in nx.strongly_connected_components(graph)
        if knot and len(knot) > 1
    )


def child(module: str, folder: str) -> str:
    """The member of a folder that a module is or belongs to; none where it stands outside."""
    inside = module.startswith(folder + ".")
    return module.removeprefix(folder + ".").split(".")[0] if inside else ""


def test_siblings_do_not_import_each_other() -> None:
    wrong(
        f"{module} imports {target}"
        for folder, shared in SIBLINGS.items()
        for module in MODULES
        if child(module, folder) not in ("", "registry")
        for target in own_imports(module)
        if child(target, folder) not in ("", child(module, folder), *shared)
    )


def test_libraries_are_named_in_their_one_room() -> None:
    wrong(
        f"{module} imports {library}"
        for module in MODULES
        for library in foreign_imports(module)
        if library not in EVERYWHERE and ONE_ROOM.get(library) != room_of(module)
    )


def test_only_declared_dependencies_are_imported() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    lines = [
        *project["dependencies"],
        *(line for name in extras if name != "dev" for line in extras[name]),
    ]
    names = {re.split(r"[>\[=<;~ ]", line)[0].replace("-", "_").lower() for line in lines}
    known = {library for name in names for library in BRINGS.get(name, {name})}
    wrong(
        f"{module} imports {library}, which no dependency brings"
        for module in MODULES
        for library in foreign_imports(module) - known
    )


def test_tests_and_benchmarks_are_not_imported() -> None:
    wrong(
        f"{module} imports {target}"
        for module in MODULES
        for target in imports_of(module)
        if target.split(".")[0] in ("tests", "helpers", "benchmarks", "pytest", "hypothesis")
    )


def knows_systems(module: str) -> bool:
    """A system's own files, the registry and the experiments name systems; nobody else does."""
    inside = module.removeprefix("fpnav.systems.").split(".")[0]
    return inside in {*NAMES, "registry"} or room_of(module) == "experiments"


def test_nobody_else_names_a_system() -> None:
    wrong(
        f"{module}:{node.lineno} names {node.value!r}"
        for module in MODULES
        if not knows_systems(module)
        for node in nodes_of(module)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in NAMES
    )


def test_nobody_else_imports_a_system() -> None:
    wrong(
        f"{module} imports {target}"
        for module in MODULES
        if not knows_systems(module)
        for target in own_imports(module)
        if target.startswith("fpnav.systems.") and target.split(".")[2] in NAMES
    )


WRITERS = {
    "write_text", "write_bytes", "touch", "mkstemp", "NamedTemporaryFile", "memmap", "symlink_to",
    "hardlink_to", "imwrite", "savefig", "savetxt", "tofile", "to_csv",
}  # fmt: skip
BUFFERED = {"save", "savez", "savez_compressed", "savefig", "imwrite"}
MOVERS = {("os", name) for name in ("replace", "rename", "truncate", "link", "symlink")}
MOVERS |= {("shutil", name) for name in ("move", "copy", "copy2", "copyfile")}
OPENERS = {"", "io", "gzip", "bz2", "lzma", "codecs"}
"""Where ``open`` takes the path first and the mode second; elsewhere it is a method of a path."""


def writes(node: ast.Call) -> bool:
    """Whether a call may write a file; into a buffer in memory it does not."""
    name, owner = called(node)
    first = node.args[0] if node.args else None
    if name in BUFFERED and isinstance(first, ast.Name) and first.id in ("buffer", "stream"):
        return False
    if name == "open" and owner == "os":
        return not (isinstance(first, ast.Attribute) and first.attr == "devnull")
    if name == "open":
        return any(set(mode) & set("wax+") for mode in modes(node, owner))
    return (
        name in WRITERS
        or (owner, name) in MOVERS
        or (name in BUFFERED and owner in ("np", "numpy"))
    )


def called(node: ast.Call) -> tuple[str, str]:
    if isinstance(node.func, ast.Name):
        return node.func.id, ""
    if isinstance(node.func, ast.Attribute):
        owner = node.func.value
        return node.func.attr, owner.id if isinstance(owner, ast.Name) else "?"
    return "", ""


def modes(node: ast.Call, owner: str) -> list[str]:
    """Modes a file may be opened with; what cannot be read off counts as writing."""
    given = node.args[1:2] if owner in OPENERS else node.args[:1]
    given += [keyword.value for keyword in node.keywords if keyword.arg == "mode"]
    read = [mode.value for mode in given if isinstance(mode, ast.Constant)]
    unknown = "w" if len(read) < len(given) and owner in OPENERS else "r"
    return [unknown, *(mode for mode in read if isinstance(mode, str))]


def calls(module: str) -> Iterator[ast.Call]:
    return (node for node in nodes_of(module) if isinstance(node, ast.Call))


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("open(path)", False), ("open(path, 'rb')", False), ("open(path, 'wb')", True),
        ("path.open()", False), ("path.open('rb')", False), ("path.open('a')", True),
        ("open(path, mode=mode)", True), ("gzip.open(path, 'rt')", False),
        ("gzip.open(path, 'wb')", True), ("archive.open(names[0])", False),
        ("os.open(os.devnull, os.O_WRONLY)", False), ("os.open(path, flags)", True),
        ("path.write_text(x)", True), ("np.save(path, x)", True), ("np.savez(buffer, x)", False),
        ("figure.savefig(buffer)", False), ("figure.savefig(path)", True),
        ("os.replace(a, b)", True), ("text.replace(a, b)", False), ("memory.save()", False),
    ],
)  # fmt: skip
def test_the_walk_knows_what_writes(line: str, expected: bool) -> None:
    node = ast.parse(line, mode="eval").body
    assert isinstance(node, ast.Call)
    assert writes(node) == expected


def test_files_are_written_through_publish_alone() -> None:
    wrong(
        f"{module}:{node.lineno} {ast.unparse(node)[:60]}"
        for module in MODULES
        if module != "fpnav.publish"
        for node in calls(module)
        if writes(node)
    )


def test_nothing_asks_the_clock_or_rolls_unseeded_dice() -> None:
    clocks = {
        ("time", "time"), ("time", "time_ns"), ("datetime", "now"), ("datetime", "today"),
        ("date", "today"), ("datetime", "utcnow"), ("os", "urandom"), ("os", "getrandom"),
    }  # fmt: skip
    wrong(
        f"{module}:{node.lineno} {ast.unparse(node)[:60]}"
        for module in MODULES
        for node in calls(module)
        if called(node)[::-1] in clocks or (called(node)[0] == "default_rng" and not node.args)
    )
    wrong(
        f"{module} imports {target}"
        for module in MODULES
        for target in imports_of(module)
        if target.split(".")[0] in ("random", "uuid", "secrets")
    )


def test_no_check_is_an_assert_that_python_o_takes_away() -> None:
    wrong(
        f"{module}:{node.lineno} {ast.unparse(node)[:60]}"
        for module in MODULES
        for node in nodes_of(module)
        if isinstance(node, ast.Assert)
    )


def test_nothing_loads_pickles_or_runs_text() -> None:
    wrong(
        f"{module}:{node.lineno} {ast.unparse(node)[:60]}"
        for module in MODULES
        for node in calls(module)
        if called(node)[0] in ("eval", "exec") or called(node)[::-1] in
        {("pickle", "load"), ("pickle", "loads"), ("yaml", "load"), ("marshal", "loads")}
    )  # fmt: skip


def test_files_and_functions_keep_their_size() -> None:
    wrong(
        f"{module}: {length} lines"
        for module, path in MODULES.items()
        if (length := len(path.read_text(encoding="utf-8").splitlines())) > 400
    )
    wrong(
        f"{module}.{node.name}: {length} lines"
        for module in MODULES
        for node in nodes_of(module)
        if isinstance(node, ast.FunctionDef) and (length := lines_of(node)) > 60
    )


def lines_of(function: ast.FunctionDef) -> int:
    """Lines of a function without its docstring."""
    length = (function.end_lineno or 0) - function.lineno + 1
    first = function.body[0]
    if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
        length -= (first.end_lineno or 0) - first.lineno + 1
    return length
