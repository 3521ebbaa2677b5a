"""What is changed in the source, by kind of node of its syntax tree."""

import ast
import copy
from collections.abc import Callable, Iterator
from typing import Any

ARITHMETIC = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.MatMult: None,
}
"""A matrix product has its factors swapped."""

BITS = {ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd}

BOUNDARY = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}

OPPOSITE = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}

REDUCTIONS = {
    "sum": "max",
    "mean": "sum",
    "median": "max",
    "min": "max",
    "max": "min",
    "argmin": "argmax",
    "argmax": "argmin",
    "minimum": "maximum",
    "maximum": "minimum",
    "any": "all",
    "all": "any",
    "cumsum": "cumprod",
}

SAME_EITHER_WAY = {
    "minimum",
    "maximum",
    "min",
    "max",
    "hypot",
    "allclose",
    "array_equal",
    "shares_memory",
    "logical_and",
    "logical_or",
    "isinstance",
    "getattr",
    "hasattr",
    "cast",
    "commonpath",
}
"""Functions of two arguments in any order, and those that fail at once in another."""

GUARD = 1e-5
"""Smaller constants guard against rounding: twice as much is no other guard, but 1 is
none."""

MANY = 10
"""Larger whole numbers are doubled: one more of so many changes next to nothing."""

Change = tuple[str, Any, Any]
"""Name of the operator, the node, and what comes in its place."""


def changes(node: ast.AST, parent: ast.AST) -> Iterator[Change]:
    """Every mutant of one node (not of those inside of it)."""
    for kind, change in CHANGES.items():
        if isinstance(node, kind):
            for name, new in change(node, parent):
                if ast.dump(new) != ast.dump(node):
                    yield name, node, new
    if isinstance(node, ast.If | ast.IfExp):
        yield "condition", node.test, ast.Constant(True)
    if isinstance(node, ast.If | ast.IfExp | ast.While):
        yield "condition", node.test, ast.Constant(False)


def _with(node: Any, **fields: Any) -> Any:
    """A copy of a node with other fields."""
    new = copy.deepcopy(node)
    for name, value in fields.items():
        setattr(new, name, value)
    return new


def _is_text(node: ast.AST) -> bool:
    return any(
        isinstance(inner, ast.JoinedStr)
        or (isinstance(inner, ast.Constant) and isinstance(inner.value, str | bytes))
        for inner in ast.walk(node)
    )


def _binary(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    if _is_text(node):
        return
    kind = type(node.op)
    if kind is ast.MatMult:
        yield "arithmetic", _with(node, left=node.right, right=node.left)
    elif kind in ARITHMETIC:
        yield "arithmetic", _with(node, op=ARITHMETIC[kind]())
    elif kind in BITS and not isinstance(parent, ast.Subscript):
        yield "boolean", _with(node, op=BITS[kind]())


def _augmented(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    kind = type(node.op)
    if ARITHMETIC.get(kind) and not _is_text(node.value):
        yield "arithmetic", _with(node, op=ARITHMETIC[kind]())
    elif kind in BITS:
        yield "boolean", _with(node, op=BITS[kind]())
    yield "statement dropped", ast.Pass()


def _is_count(node: ast.AST) -> bool:
    """Whether a number is one of few whole ones, so that a bound itself occurs."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int)
    text = ast.unparse(node)
    return text.startswith("len(") or text.endswith((".size", ".ndim"))


def _comparison(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    for index, op in enumerate(node.ops):
        sides = [node.left, *node.comparators][index : index + 2]
        tables = [OPPOSITE]
        if any(_is_count(side) for side in sides):
            tables.append(BOUNDARY)
        for table in tables:
            if type(op) in table:
                ops = list(node.ops)
                ops[index] = table[type(op)]()
                yield "comparison", _with(node, ops=ops)


def _boolean(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    yield "boolean", _with(node, op=op)


def _unary(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    if isinstance(node.op, ast.Not):
        yield "boolean", node.operand
    elif isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        yield "arithmetic", node.operand
    elif isinstance(node.op, ast.Invert):
        yield "boolean", node.operand


def _constant(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    value = node.value
    if isinstance(value, bool):
        yield "constant", ast.Constant(not value)
    elif isinstance(value, int):
        yield "constant", ast.Constant(value + 1 if value < MANY else 2 * value)
    elif isinstance(value, float) and abs(value) < GUARD:
        yield "constant", ast.Constant(1.0)
    elif isinstance(value, float):
        yield "constant", ast.Constant(2.0 * value)
        yield "constant", ast.UnaryOp(ast.USub(), node)


def _call(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    function = node.func
    attribute = isinstance(function, ast.Attribute)
    name = function.attr if attribute else getattr(function, "id", "")
    if name in REDUCTIONS:
        new = REDUCTIONS[name]
        field = "attr" if attribute else "id"
        yield "reduction", _with(node, func=_with(function, **{field: new}))
    if (
        len(node.args) == 2
        and name not in SAME_EITHER_WAY
        and not any(isinstance(argument, ast.Starred) for argument in node.args)
    ):
        yield "arguments", _with(node, args=node.args[::-1])
    for index, keyword in enumerate(node.keywords):
        if keyword.arg == "axis":
            new = _other_axis(keyword.value)
            if new is not None:
                keywords = list(node.keywords)
                keywords[index] = _with(keyword, value=ast.Constant(new))
                yield "axis", _with(node, keywords=keywords)


def _other_axis(node: ast.AST) -> int | None:
    axis = whole_number(node)
    return None if axis is None else (1 if axis == 0 else 0)


def whole_number(node: ast.AST) -> int | None:
    """A whole number that is written out."""
    try:
        value = ast.literal_eval(node)  # type: ignore[arg-type]
    except (ValueError, TypeError):
        return None
    return value if type(value) is int else None


def _subscript(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Whole numbers of an index, one further from the beginning or the end."""
    parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    for place, part in enumerate(parts):
        for new in _off_by_one(part):
            if isinstance(node.slice, ast.Tuple):
                elts = list(parts)
                elts[place] = new
                new = _with(node.slice, elts=elts)
            yield "index", _with(node, slice=new)


def _off_by_one(part: ast.AST) -> Iterator[ast.AST]:
    """A slice loses an element at one end; an index becomes the next one."""
    if isinstance(part, ast.Slice):
        for name, step in (("lower", 1), ("upper", -1)):
            bound = getattr(part, name)
            value = whole_number(bound) if bound is not None else None
            if value is not None:
                yield _with(part, **{name: ast.Constant(value + step)})
    elif (value := whole_number(part)) is not None:
        yield ast.Constant(value + 1 if value >= 0 else value - 1)


def _return(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    if node.value is not None and ast.unparse(node.value) != "None":
        yield "return", ast.Return(ast.Constant(None))


def _dropped(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Statements without a name that is needed later."""
    targets = getattr(node, "targets", None) or [getattr(node, "target", None)]
    if isinstance(node, ast.Expr | ast.Continue | ast.Break) or all(
        isinstance(target, ast.Subscript | ast.Attribute) for target in targets
    ):
        yield "statement dropped", ast.Pass()


def _raise(node: Any, parent: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    yield "raise dropped", ast.Pass()


CHANGES: dict[Any, Callable[[Any, ast.AST], Iterator[tuple[str, Any]]]] = {
    ast.BinOp: _binary,
    ast.AugAssign: _augmented,
    ast.Compare: _comparison,
    ast.BoolOp: _boolean,
    ast.UnaryOp: _unary,
    ast.Constant: _constant,
    ast.Call: _call,
    ast.Subscript: _subscript,
    ast.Return: _return,
    (ast.Expr, ast.Continue, ast.Break, ast.Assign): _dropped,
    ast.Raise: _raise,
}
