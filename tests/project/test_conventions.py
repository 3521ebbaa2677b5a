"""What the source must hold to: one-way imports, small files, docstrings, a light
`import hefting`."""

import ast
import importlib
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import hefting
from hefting.estimators import METHODS

ROOT = Path(hefting.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
LAYERS = [
    {"core"},
    {"jobs", "logs", "robots", "shapes", "motion"},
    {"estimators", "export"},
    {"torques", "ingest"},
    {"identification", "prediction"},
    {"online"},
    {"sources"},
    {"inspection", "request"},
    {"batches"},
    {"scene"},
    {"planning"},
    {"plots", "page"},
    {"dashboards", "notebook"},
    {"viewer"},
    {"simulation"},
    {"reproduction"},
    {"cli"},
]
"""Data flows one way: a part imports from layers above its own in this list, never from
below or beside."""
EDGE = {
    "simulation",
    "reproduction",
    "plots",
    "page",
    "dashboards",
    "notebook",
    "viewer",
    "cli",
}
HEIGHT = {name: height for height, layer in enumerate(LAYERS) for name in layer}
NEVER = {"estimators": {"logs", "motion", "export"}}
HEAVY = {
    "trimesh",
    "pyarrow",
    "matplotlib",
    "pinocchio",
    "mujoco",
    "viser",
    "plotly",
    "distributed",
    "foxglove",
    "rosbags",
    "rich",
}


def part(path: Path) -> str:
    """The module or package right under `hefting` a file belongs to; empty for
    `hefting` itself."""
    relative = path.relative_to(ROOT)
    name = relative.parts[0].removesuffix(".py")
    return "" if name == "__init__" else name


FILES_OF: dict[str, list[Path]] = {}
"""The files of each part."""
for file in FILES:
    FILES_OF.setdefault(part(file), []).append(file)


@cache
def tree_of(path: Path) -> ast.Module:
    """A file of the source as parsed."""
    return ast.parse(path.read_text())


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Those of a module at its top or anywhere inside. Imports are of them: to look into
    expressions as well takes several times as long."""
    for node in ast.iter_child_nodes(tree):
        if not isinstance(node, ast.expr):
            yield node
            yield from statements(node)


def imported(tree: ast.AST) -> set[str]:
    """Parts of `hefting` that a module imports, at its top or anywhere inside."""
    names = set()
    for node in statements(tree):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: imports are absolute"
            modules = (
                [f"{node.module}.{alias.name}" for alias in node.names]
                if node.module == "hefting"
                else [node.module]
            )
        elif isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        else:
            continue
        names |= {
            module.split(".")[1]
            for module in modules
            if module and module.startswith("hefting.")
        }
    return names - {"__version__"}


def test_the_list_of_layers_names_each_part_once():
    assert len(HEIGHT) == sum(len(layer) for layer in LAYERS)
    assert {part(path) for path in FILES} - {"", "__main__"} <= set(HEIGHT), (
        "place new parts in LAYERS"
    )


@pytest.mark.parametrize("own", sorted(HEIGHT))
def test_imports_point_one_way(own):
    for path in FILES_OF[own]:
        for name in imported(tree_of(path)) - {own}:
            assert HEIGHT[name] < HEIGHT[own], f"{path} imports {name}: not above it"
            assert own in EDGE or name not in EDGE, f"{path} imports {name} of the edge"
            assert name not in NEVER.get(own, ()), f"{path} must not know {name}"


def test_imports_of_every_kind_are_seen():
    """The check itself: nested, plain, and from-imports all count."""
    source = (
        "import hefting.logs\nfrom hefting import demo\n"
        "def f():\n    from hefting.cli.app import x\n    import numpy\n"
    )
    assert imported(ast.parse(source)) == {"logs", "demo", "cli"}


def public(body: list[ast.stmt], prefix: str = ""):
    """Every class, function and method whose name does not start with an underscore."""
    for node in body:
        if isinstance(
            node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
        ) and not node.name.startswith("_"):
            yield f"{prefix}{node.name}", node
            if isinstance(node, ast.ClassDef) and not any(
                getattr(b, "id", None) == "Protocol" for b in node.bases
            ):
                yield from public(node.body, f"{node.name}.")


@pytest.mark.parametrize("own", sorted(FILES_OF))
def test_everything_public_is_documented_and_files_are_small(own):
    for path in FILES_OF[own]:
        tree = tree_of(path)
        assert ast.get_docstring(tree), f"{path} has no docstring"
        bare = [name for name, node in public(tree.body) if not ast.get_docstring(node)]
        assert not bare, path
        assert len(path.read_text().splitlines()) <= 400, path


def defined(node: ast.stmt) -> set[str]:
    """Names that a statement of a file defines."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return (
            set()
            if "overload" in map(ast.unparse, node.decorator_list)
            else {node.name}
        )
    targets = getattr(node, "targets", [getattr(node, "target", node)])
    each = (name for target in targets for name in ast.walk(target))
    return {
        name.id
        for name in (each if isinstance(node, ast.Assign | ast.AnnAssign) else ())
        if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)
    }


@pytest.mark.parametrize("own", sorted(FILES_OF))
def test_no_name_of_a_file_stands_for_two_things(own):
    """The second would replace the first, unless it is made from it."""
    for path in FILES_OF[own]:
        seen: set[str] = set()
        for node in tree_of(path).body:
            used = {
                n.id
                for n in ast.walk(node)
                if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)
            }
            twice = (defined(node) & seen) - used
            assert not twice, path
            seen |= defined(node)


def run(code: str) -> str:
    return subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout


def test_importing_hefting_imports_nothing():
    code = "import sys; import hefting; print(*{m.split('.')[0] for m in sys.modules})"
    assert not {"numpy", "scipy", *HEAVY} & set(run(code).split())


def test_the_estimators_need_nothing_heavy():
    code = (
        "import sys; from hefting import PMD, OLS, Measurements, Shape, Estimate; "
        "print(*{m.split('.')[0] for m in sys.modules})"
    )
    loaded = set(run(code).split())
    assert "numpy" in loaded
    assert not HEAVY & loaded


def public_names() -> set[str]:
    return set(dir(hefting)) - {"__version__"}


def test_public_names_exist_and_are_those_of_the_stub():
    for name in public_names():
        assert getattr(hefting, name) is not None
    stub = ast.parse((ROOT / "__init__.pyi").read_text())
    named = [
        (node.module, a.name)
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for a in node.names
    ]
    typed = {(f"{module}.{name}", name) for module, name in named if name != "*"}
    assert [module for module, name in named if name == "*"] == [
        "hefting.estimators.methods"
    ]
    typed |= {(f"hefting.estimators.methods.{name}", name) for name in METHODS}
    assert {name for _, name in typed} == public_names()
    for path, name in typed:  # the stub takes each from where it is
        module, attribute = path.rsplit(".", 1)
        assert getattr(importlib.import_module(module), attribute) is getattr(
            hefting, name
        )
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        hefting.nothing  # type: ignore[attr-defined]  # noqa: B018


def test_public_names_are_found_by_the_star_and_submodules_cost_nothing_else():
    assert set(hefting.__all__) == public_names()
    code = "import sys; from hefting import cli; assert not hasattr(cli, 'x'); hasattr({}); print(*sys.modules)"
    assert "numpy" not in run(code.format("sys.modules['hefting'], 'wrapped'")).split()


def test_public_names_do_not_depend_on_what_was_imported_before():
    """A name that is also a submodule's would be the module once something has imported
    that."""
    assert not {part(path) for path in FILES} & public_names()


def modules() -> dict[str, set[str]]:
    """Every module, and those of the package that it imports anywhere inside."""
    names = {
        ".".join(
            ("hefting", *path.relative_to(ROOT).with_suffix("").parts)
        ).removesuffix(".__init__"): path
        for path in FILES
    }
    found = {}
    for name, path in names.items():
        wanted = set()
        for node in statements(tree_of(path)):
            if isinstance(node, ast.Import):
                wanted |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    inner = f"{node.module}.{alias.name}"
                    wanted.add(inner if inner in names else node.module)
        found[name] = wanted & set(names) - {name, "hefting"}
    return found


def test_no_files_import_each_other_in_a_circle():
    """Imports inside functions count: they hide a circle, and do not undo it."""
    left = modules()
    while free := {name for name, wanted in left.items() if not wanted & set(left)}:
        left = {name: wanted for name, wanted in left.items() if name not in free}
    assert not left
