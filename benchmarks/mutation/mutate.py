"""Every mutant of a source file: one small change that tests should notice.

Left out by construction, as they change nothing that a test could see: annotations,
docstrings, decorators, what is inside of `raise`, texts, type checking, arguments such
as `strict`, constants that only set how much is done at a time.
"""

import ast
import copy
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from benchmarks.mutation.operators import changes, whole_number

AT_A_TIME = re.compile(r"\b\w*(CHUNK|BLOCK|AT_A_TIME|_KEPT|BUFFERED)\w*\b")
"""Names of constants that set how much is done or kept at a time."""

UNSEEN_ARGUMENTS = {
    "strict",
    "copy",
    "check_finite",
    "overwrite_a",
    "overwrite_b",
    "assume_sorted",
    "repr",
    "kw_only",
    "stacklevel",
    "optimize",
    "maxsize",
    "axis",
    "allow_pickle",
}
"""Arguments that change speed, checks of what holds anyway, or how things look; an
axis is changed with the call."""

SHOWN = 90
"""Longest text of a change that is shown."""


@dataclass(frozen=True)
class Mutant:
    """One change of a source file."""

    file: str
    """relative to the folder of the sources"""
    function: str
    """qualified name; that of the assigned constant outside of functions"""
    operator: str
    change: str
    """what stands there, and what in its place"""
    text: str
    """what replaces `span`"""
    span: tuple[int, int]
    """of bytes of the file"""
    lines: range
    """of the statement, without its body"""
    names: tuple[str, ...] = ()
    """where it is executed on import: names by which it is used"""

    @property
    def package(self) -> str:
        """First folder below the library."""
        return Path(self.file).parts[1]

    @property
    def key(self) -> str:
        """Tells it from all others, wherever lines move."""
        return f"{self.file} {self.function}: {self.change}"

    def apply(self, source: bytes) -> bytes:
        """The source with the change."""
        start, end = self.span
        return source[:start] + self.text.encode() + source[end:]


def find_mutants(sources: Path, file: str) -> list[Mutant]:
    """All mutants of a file, in its order, each with a key of its own."""
    source = (sources / file).read_bytes()
    found = list(_Finder(file, source).module(ast.parse(source)))
    times: Counter[str] = Counter()
    unique = []
    for mutant in found:
        times[mutant.key] += 1
        if (number := times[mutant.key]) > 1:
            mutant = replace_change(mutant, f"{mutant.change} (no. {number})")
        unique.append(mutant)
    return unique


def replace_change(mutant: Mutant, change: str) -> Mutant:
    """The same mutant under another text."""
    return Mutant(**{**vars(mutant), "change": change})


class _Finder:
    """Walks a module and gives the mutants of what it comes by."""

    def __init__(self, file: str, source: bytes):
        self.file = file
        lengths = [len(line) for line in source.splitlines(keepends=True)]
        self.starts = [sum(lengths[:number]) for number in range(len(lengths) + 1)]

    def module(self, tree: ast.Module) -> Iterator[Mutant]:
        """Mutants of the whole file."""
        yield from self._block(tree.body, (), ())

    def _block(self, body: list, scope: tuple, names: tuple) -> Iterator[Mutant]:
        for statement in body:
            yield from self._statement(statement, scope, names)

    def _statement(self, node: ast.stmt, scope: tuple, names: tuple):
        """Mutants of a statement, those of the statements inside among them.

        `names` is empty inside of functions.
        """
        if isinstance(node, ast.Import | ast.ImportFrom) or _is_docstring(node):
            return
        if isinstance(node, ast.FunctionDef):
            inner = (*scope, node.name)
            if any(isinstance(s, ast.Raise) for s in node.body[-1:]) and _is_abstract(
                node
            ):
                return
            for default in [*node.args.defaults, *node.args.kw_defaults]:
                if default is not None:
                    yield from self._expression(default, node, inner, ())
            yield from self._block(node.body, inner, ())
            return
        if isinstance(node, ast.ClassDef):
            for statement in node.body:
                yield from self._statement(statement, (*scope, node.name), (node.name,))
            return
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        inside = bool(scope) and not names
        if not inside:
            names, scope = _assigned(node, scope, names)
            if names == ("__all__",) or AT_A_TIME.search(names[0] if names else ""):
                return
        for part, inner in _parts(node):
            if inner:
                yield from self._block(part, scope, names)
            else:
                yield from self._expression(part, node, scope, names)
        if inside:
            yield from self._changed(node, node, node, scope, names)

    def _expression(self, node: ast.expr, statement, scope, names, parent=None):
        """Mutants of an expression and of those inside of it."""
        if isinstance(node, ast.JoinedStr):
            return
        yield from self._changed(node, parent or node, statement, scope, names)
        if isinstance(node, ast.Call) and _ends_in(node.func, "Message", "cast"):
            return
        for child in _inner(node):
            yield from self._expression(child, statement, scope, names, node)

    def _changed(self, node, parent, statement, scope, names) -> Iterator[Mutant]:
        """Mutants that change `node` itself, told within its `parent`."""
        if isinstance(node, ast.BinOp) and AT_A_TIME.search(ast.unparse(node)):
            return
        for operator, target, new in changes(node, parent):
            text = ast.unparse(new)
            if isinstance(new, ast.expr):
                text = f"({text})"
            yield Mutant(
                file=self.file,
                function=".".join(scope),
                operator=operator,
                change=_tell(parent, target, new),
                text=text,
                span=self._span(target),
                lines=_header(statement),
                names=names,
            )

    def _span(self, node) -> tuple[int, int]:
        start = self.starts[node.lineno - 1] + node.col_offset
        return start, self.starts[node.end_lineno - 1] + node.end_col_offset


def _tell(parent: ast.AST, target: ast.AST, new: ast.AST) -> str:
    """What stands there, and what in its place: both of the parent, or of the part
    itself where that is too long."""
    before, after = ast.unparse(target), ast.unparse(new)
    if isinstance(parent, ast.expr) and target is not parent:
        whole = ast.unparse(parent)
        changed = ast.unparse(_Swapped(target, new).visit(copy.deepcopy(parent)))
        if len(whole) <= SHOWN:
            before, after = whole, changed
    before, after = (
        text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."
        for text in (" ".join(before.split()), " ".join(after.split()))
    )
    return f"{before} -> {after}"


class _Swapped(ast.NodeTransformer):
    """Puts `new` where `target` is, in a copy of the tree."""

    def __init__(self, target: ast.AST, new: ast.AST):
        self.place = _place(target)
        self.kind, self.new = type(target), new

    def visit(self, node: ast.AST) -> ast.AST:
        """The node, or what comes in its place."""
        if isinstance(node, self.kind) and _place(node) == self.place:
            return self.new
        return self.generic_visit(node)


def _place(node) -> tuple:
    return tuple(
        getattr(node, name, None)
        for name in ("lineno", "col_offset", "end_lineno", "end_col_offset")
    )


def _parts(node: ast.stmt) -> Iterator[tuple]:
    """Expressions of a statement, and blocks inside of it (told by True)."""
    if isinstance(node, ast.Raise | ast.Assert | ast.Delete):
        return
    for name, value in ast.iter_fields(node):
        if name == "annotation" or isinstance(value, str):
            continue
        if isinstance(value, ast.expr):
            yield value, False
        elif isinstance(value, list) and value:
            for is_statement, group in groupby(
                value, lambda item: isinstance(item, ast.stmt)
            ):
                items = list(group)
                if is_statement:
                    yield items, True
                    continue
                for item in items:
                    if isinstance(item, ast.expr):
                        yield item, False
                    elif isinstance(item, ast.withitem):
                        yield item.context_expr, False
                    elif isinstance(item, ast.ExceptHandler | ast.match_case):
                        yield item.body, True


def _inner(node: ast.expr) -> Iterator[ast.expr]:
    """Expressions right inside of one, but for whole numbers of an index, which are
    changed with it."""
    if isinstance(node, ast.Subscript):
        yield node.value
        index = node.slice
        for part in index.elts if isinstance(index, ast.Tuple) else [index]:
            bounds = _inner(part) if isinstance(part, ast.Slice) else [part]
            yield from (bound for bound in bounds if whole_number(bound) is None)
        return
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.keyword):
            if child.arg not in UNSEEN_ARGUMENTS:
                yield child.value
        elif isinstance(child, ast.comprehension):
            yield from (child.iter, *child.ifs)
        elif isinstance(child, ast.expr):
            yield child


def _assigned(node: ast.stmt, scope: tuple, names: tuple) -> tuple[tuple, tuple]:
    """Names by which a statement outside of functions is used, and its scope."""
    targets = getattr(node, "targets", None) or [getattr(node, "target", None)]
    found = tuple(target.id for target in targets if isinstance(target, ast.Name))
    return (found or names, (*scope, *found[:1]))


def _header(node) -> range:
    """Lines of a statement, without the block inside of it."""
    body = getattr(node, "body", None)
    if isinstance(body, list) and body and not isinstance(node, ast.FunctionDef):
        return range(node.lineno, max(node.lineno + 1, body[0].lineno))
    if isinstance(node, ast.FunctionDef):
        return range(node.body[0].lineno, (node.end_lineno or 0) + 1)
    return range(node.lineno, (node.end_lineno or node.lineno) + 1)


def _is_docstring(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_abstract(node: ast.FunctionDef) -> bool:
    """Whether a function only says that others must have it."""
    return "NotImplementedError" in ast.unparse(node.body[-1])


def _ends_in(function: ast.expr, *names: str) -> bool:
    return ast.unparse(function).rpartition(".")[2] in names
