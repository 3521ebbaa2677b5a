"""The table of every message in docs/messages.md, read from the source.

`python tests/project/message_table.py` prints it.
"""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "hefting"
MAKERS = {
    "note": "note",
    "warning": "warning",
    "error": "error",
    "Explanation": "warning or error",
    "Undone": "warning or error",
    "say": "warning or error",
}
"""Functions that make messages, and their severity."""
RETURNED = re.compile(r"[a-z]+(-[a-z]+)+")
"""Codes that a function of rival explanations returns beside a text, as a maker's are."""
LONGEST = 160
"""Characters of a text that the table shows."""


def flat(node: ast.expr | None, names: dict[str, ast.expr]) -> str | None:
    """The text of an expression, with an ellipsis where something is filled in; None
    for none that can be read."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=values):
            return "".join(
                flat(v, names) or "…" if isinstance(v, ast.Constant) else "…"
                for v in values
            )
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return (flat(left, names) or "…") + (flat(right, names) or "…")
        case ast.Name(id=name) if name in names:
            return flat(names[name], {k: v for k, v in names.items() if k != name})
        case _:
            return None


def _constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Names of a module's constants, and their values."""
    for node in tree.body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                yield name, value
            case ast.Assign(
                targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)
            ):
                for each, value in zip(names, values, strict=True):
                    if isinstance(each, ast.Name):
                        yield each.id, value


@cache
def messages() -> list[tuple[str, str, str, str]]:
    """Code, severity, package and text of every message made in the source, in order of
    the codes."""
    found = {}
    for path in sorted(SOURCE.rglob("*.py")):
        package = path.relative_to(SOURCE).parts[0]
        text = path.read_text()
        if not any(f"{maker}(" in text for maker in MAKERS):
            continue
        tree = ast.parse(text)
        constants = dict(_constants(tree))
        for function in ast.walk(tree):
            if not isinstance(function, ast.FunctionDef):
                continue
            assigned = [
                (node.lineno, node.targets[0].id, node.value)
                for node in ast.walk(function)
                if isinstance(node, ast.Assign)
                and isinstance(node.targets[0], ast.Name)
            ]
            for node in ast.walk(function):
                match node:
                    case ast.Call(
                        func=ast.Name(id=maker), args=[first, second, *_]
                    ) if maker in MAKERS:
                        of_call = True
                    case ast.Return(value=ast.Tuple(elts=[first, second])):
                        maker, of_call = "Explanation", False
                    case _:
                        continue
                names = constants | {
                    name: value
                    for line, name, value in sorted(assigned, key=lambda a: a[0])
                    if line <= node.lineno
                }
                if (code := flat(first, names)) is None:
                    continue
                if not of_call and not RETURNED.fullmatch(code):
                    continue
                text = re.sub(r"\s+", " ", flat(second, names) or "…").replace("|", "/")
                text = text if len(text) <= LONGEST else text[: LONGEST - 2] + " …"
                found.setdefault(code, (code, MAKERS[maker], package, text))
    return [found[code] for code in sorted(found)]


def table() -> str:
    """The table as Markdown."""
    rows = [
        f"| `{code}` | {severity} | `{package}/` | {text} |"
        for code, severity, package, text in messages()
    ]
    return (
        "\n".join(["| code | severity | from | text |", "|---|---|---|---|", *rows])
        + "\n"
    )


if __name__ == "__main__":
    print(table(), end="")
