"""Arithmetic in texts, as ``2 * sin(2 * pi * 5 * t)``: nothing of it is executed as Python."""

import ast
import operator
import warnings
from functools import lru_cache

import numpy as np
from simpleeval import InvalidExpression, MultipleExpressions, SimpleEval

from ..checks import shown
from ..errors import InputError


def _of_one(function):
    """A function of one argument and no more: ufuncs of numpy would write into a second."""
    return lambda x: function(x)


FUNCTIONS = {
    **{name: _of_one(getattr(np, name)) for name in (
        "sin", "cos", "tan", "arctan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "abs", "sign",
        "floor")},
    "minimum": lambda a, b: np.minimum(a, b), "maximum": lambda a, b: np.maximum(a, b),
    "where": lambda condition, a, b: np.where(condition, a, b)}
OPERATORS = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: np.true_divide,
    ast.Pow: np.float_power, ast.USub: operator.neg, ast.UAdd: operator.pos, ast.Lt: operator.lt,
    ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.BitAnd: np.logical_and,
    ast.BitOr: np.logical_or}
PARTS = (ast.Expr, ast.Name, ast.Constant, ast.UnaryOp, ast.BinOp, ast.Compare, ast.Call)
"""What an expression may consist of."""


def arithmetic(text, **names):
    """The value of a text: numbers, ``pi``, ``names``, ``+ - * / **``, comparisons (joined by ``&``
    and ``|``, each in parentheses) and ``FUNCTIONS``.

    Args:
        text: the expression.
        names: numbers or arrays, all of one shape.

    Returns:
        A float, or an array of that shape; infinite or nan where there is no value.

    Raises:
        InputError: it is no such expression.
    """
    parser, tree = _parsed(text)
    arrays = {name: np.asarray(value, dtype=float) for name, value in names.items()}
    parser.names = {"pi": np.pi, **arrays}
    shape = next(iter(arrays.values())).shape
    try:
        with np.errstate(all="ignore"):
            value = np.broadcast_to(np.asarray(parser.eval(text, tree), dtype=float), shape)
    except (InvalidExpression, ArithmeticError, TypeError, ValueError, RecursionError) as error:
        raise InputError(f"expression {shown(text)}: {_reason(error)}") from None
    return float(value) if not shape else value


class _Arithmetic(SimpleEval):
    """Of floats, which grow no farther than infinity."""

    def __init__(self):
        super().__init__(operators=OPERATORS, functions=FUNCTIONS)
        self.nodes = {part: evaluate for part, evaluate in self.nodes.items() if part in PARTS}
        self.nodes[ast.Constant] = lambda node: float(node.value)


@lru_cache
def _parsed(text):
    """A parser, and the tree that it makes of an expression."""
    parser = _Arithmetic()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return parser, parser.parse(text)
    except (InvalidExpression, MultipleExpressions, SyntaxError, RecursionError,
            MemoryError) as error:
        raise InputError(f"expression {shown(text)}: {_reason(error)}") from None


def _reason(error):
    if isinstance(error, MultipleExpressions):
        return "is more than one"
    if isinstance(error, TypeError | ValueError):
        return ("is no arithmetic: a function takes another number of arguments, or something is "
                "no number")
    return str(getattr(error, "msg", error)).partition("\n")[0] or "is nested too deeply"
