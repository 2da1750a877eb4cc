"""Several elements side by side: a number type of ``WIDTH`` floats that work as one.

An element kernel says nothing of the type of its numbers.  Given arrays of float64 it computes one
element, given arrays of *lanes* it computes ``WIDTH`` elements with the same operations in the same
order (vector instructions of the processor), so the results are the same to the last bit.

Lanes are float64 arrays whose last axis is the lane, seen through ``lanes``; a lane alone is
read and written in the float64 array itself.  Linear algebra takes them from any place of an array
(``load``) and puts them back (``store``).
"""

import math
import operator

import numpy as np
from llvmlite import ir
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.core.types import Array, Float, Type, void
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_cast,
    models,
    register_model,
    type_callable,
)
from numba.np.arrayobj import make_array, populate_array

from .jit import internal, kernel

WIDTH = 8
VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)


class Lanes(Type):
    """``WIDTH`` float64; a float64 beside lanes stands for the same number in all of them."""

    def __init__(self):
        super().__init__(name=f"lanes{WIDTH}")

    def can_convert_from(self, typingctx, other):
        return Conversion.promote if isinstance(other, Float) else None

    def unify(self, typingctx, other):
        return self if isinstance(other, Float) else None


LANES = Lanes()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, type_):
        super().__init__(manager, type_, VECTOR)


@lower_cast(Float, Lanes)
def _spread(context, builder, from_type, to_type, value):
    """The same number in all lanes."""
    number = context.cast(builder, value, from_type, from_type)
    first = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), number,
                                   ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, ir.Constant(VECTOR, ir.Undefined),
                                  ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), None))


def _define(function, instruction, arguments):
    """Let ``function`` of lanes (or lanes and float64) be one instruction."""

    @type_callable(function)
    def typer(context):
        def result(*types):
            if (len(types) == arguments and LANES in types
                    and all(isinstance(t, (Lanes, Float)) for t in types)):
                return LANES
            return None
        if arguments == 1:
            return lambda a: result(a)
        return lambda a, b: result(a, b)

    def lower(context, builder, signature, args):
        return instruction(builder, *(context.cast(builder, value, type_, LANES)
                                      for value, type_ in zip(args, signature.args)))

    choices = [(Lanes,)] if arguments == 1 else [(Lanes, Lanes), (Lanes, Float), (Float, Lanes)]
    for types in choices:
        lower_builtin(function, *types)(lower)


def _square_root(builder, value):
    sqrt = cgutils.get_or_insert_function(builder.module, ir.FunctionType(VECTOR, [VECTOR]),
                                          f"llvm.sqrt.v{WIDTH}f64")
    return builder.call(sqrt, [value])


for _functions, _instruction in (
        ((operator.add, operator.iadd), ir.IRBuilder.fadd),
        ((operator.sub, operator.isub), ir.IRBuilder.fsub),
        ((operator.mul, operator.imul), ir.IRBuilder.fmul),
        ((operator.truediv, operator.itruediv), ir.IRBuilder.fdiv)):
    for _function in _functions:
        _define(_function, _instruction, 2)
_define(operator.neg, ir.IRBuilder.fneg, 1)
_define(math.sqrt, _square_root, 1)


@intrinsic
def lanes(typingctx, array):
    """A contiguous float64 array (..., WIDTH) as an array (...) of lanes: the same memory."""
    seen = Array(LANES, array.ndim - 1, "C", aligned=False)

    def view(context, builder, signature, args):
        old = make_array(signature.args[0])(context, builder, args[0])
        new = make_array(seen)(context, builder)
        pointer = context.get_data_type(LANES).as_pointer()
        populate_array(new, data=builder.bitcast(old.data, pointer),
                       shape=cgutils.unpack_tuple(builder, old.shape)[:-1],
                       strides=cgutils.unpack_tuple(builder, old.strides)[:-1],
                       itemsize=ir.Constant(ir.IntType(64), 8 * WIDTH),
                       meminfo=old.meminfo, parent=old.parent)
        value = new._getvalue()
        context.nrt.incref(builder, seen, value)
        return value

    return seen(array), view


@intrinsic
def load(typingctx, array, position):
    """Lanes from ``WIDTH`` entries one after the other in a contiguous float64 array."""

    def read(context, builder, signature, args):
        return builder.load(_place(context, builder, signature, args), align=8)

    return LANES(array, position), read


@intrinsic
def store(typingctx, array, position, value):
    """Write lanes to ``WIDTH`` entries one after the other in a contiguous float64 array."""

    def write(context, builder, signature, args):
        builder.store(args[2], _place(context, builder, signature, args), align=8)
        return context.get_dummy_value()

    return void(array, position, value), write


def _place(context, builder, signature, args):
    """Pointer to lanes from an array and a position in it."""
    data = make_array(signature.args[0])(context, builder, args[0]).data
    return builder.bitcast(builder.gep(data, [args[1]]), VECTOR.as_pointer())


@kernel
def zeros(shape):
    """Float64 array ``shape + (WIDTH,)`` that begins on a multiple of the lanes' size."""
    size = WIDTH
    for n in shape:
        size *= n
    room = np.zeros(size + WIDTH)
    skipped = (-room.ctypes.data // room.itemsize) % WIDTH
    return room[skipped:skipped + size].reshape(shape + (WIDTH,))


@internal
def new(shape):
    """Lanes, zeros; only for kernels, as Python does not know their type."""
    return lanes(zeros(shape))


@internal
def pair(shape):
    """Zeros to be read or written lane by lane, and the same memory as lanes."""
    numbers = zeros(shape)
    return numbers, lanes(numbers)
