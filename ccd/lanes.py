"""Two numbers side by side in the lanes of a vector register: a kernel written for numbers does with them the same twice in one go.

The two bodies of a pair go through the same arithmetic, which so takes half the instructions, to the same bits. A kernel that takes numbers
and `Two` alike chooses by `where_less`, `greater` and `lesser`, and jumps only by `most` and `least`, to a way that is right for both;
`sqrt` and `absolute` are those of here.
"""

import math
import operator

from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model

from ccd.compiling import kernel


class Two:
    """Two numbers, as plain Python has them."""

    __slots__ = ("one", "other")

    def __init__(self, one, other):
        self.one, self.other = one, other

    def __neg__(self):
        return Two(-self.one, -self.other)

    def __repr__(self):
        return f"two({self.one!r}, {self.other!r})"


def two(one, other):
    """Two numbers side by side."""
    return Two(one, other)


def first(x):
    return x.one


def second(x):
    return x.other


def sqrt(x):
    return _each(math.sqrt, x)


def cos(x):
    return _each(math.cos, x)


def sin(x):
    return _each(math.sin, x)


def absolute(x):
    """The absolute value."""
    return _each(abs, x)


def most(x):
    """The larger of two numbers side by side; a number itself."""
    return max(x.one, x.other) if isinstance(x, Two) else x


def least(x):
    """The smaller of two numbers side by side; a number itself."""
    return min(x.one, x.other) if isinstance(x, Two) else x


def where_less(a, b, yes, no):
    """`yes` where a < b, else `no`."""
    return _each(lambda a, b, yes, no: yes if a < b else no, a, b, yes, no)


@kernel
def greater(a, b):
    return where_less(a, b, b, a)


@kernel
def lesser(a, b):
    return where_less(b, a, b, a)


@kernel
def total(x):
    return first(x) + second(x)


@kernel
def first_of(x):
    """The first lanes of a 3-vector."""
    return first(x[0]), first(x[1]), first(x[2])


@kernel
def second_of(x):
    return second(x[0]), second(x[1]), second(x[2])


@kernel
def total_of(x):
    return total(x[0]), total(x[1]), total(x[2])


@kernel
def abreast(a, b):
    """Two 3-vectors side by side."""
    return two(a[0], b[0]), two(a[1], b[1]), two(a[2], b[2])


def _each(function, *values):
    """A function of numbers, lane by lane if any of the values has lanes."""
    if any(isinstance(value, Two) for value in values):
        one = function(*(value.one if isinstance(value, Two) else value for value in values))
        return Two(one, function(*(value.other if isinstance(value, Two) else value for value in values)))
    return function(*values)


class _TwoType(types.Type):
    def __init__(self):
        super().__init__(name="two")


_NUMBER, _TWO, _REGISTER, _INDEX = types.float64, _TwoType(), ir.VectorType(ir.DoubleType(), 2), ir.IntType(32)


@register_model(_TwoType)
class _TwoModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _REGISTER)


def _pack(builder, one, other):
    return builder.insert_element(builder.insert_element(ir.Constant(_REGISTER, ir.Undefined), one, _INDEX(0)), other, _INDEX(1))


def _compile(function, generate, result, *cases):
    """Tell numba the code of a function. Where it takes lanes or gives them, a number stands in both."""
    def lower(kinds):
        wide = _TWO in kinds

        def implementation(context, builder, _signature, values):
            spread = (_pack(builder, value, value) if wide and kind is _NUMBER else value for kind, value in zip(kinds, values))
            return generate(context, builder, *spread)
        lower_builtin(function, *kinds)(implementation)

    for kinds in cases:
        lower(kinds)
    signatures = [signature(result or (_TWO if _TWO in kinds else kinds[-1]), *kinds) for kinds in cases]
    infer_global(function)(type(function.__name__, (ConcreteTemplate,), {"key": function, "cases": signatures}))


def _by_intrinsic(name):
    def generate(_, builder, x):
        suffix = "v2f64" if x.type == _REGISTER else x.type.intrinsic_name
        return builder.call(get_or_insert_function(builder.module, ir.FunctionType(x.type, [x.type]), f"llvm.{name}.{suffix}"), [x])
    return generate


def _by_library(function):
    """By calling it for each lane."""
    def generate(context, builder, x):
        call = context.get_function(function, signature(_NUMBER, _NUMBER))
        if x.type != _REGISTER:
            return call(builder, [x])
        return _pack(builder, *(call(builder, [builder.extract_element(x, _INDEX(lane))]) for lane in (0, 1)))
    return generate


def _outermost(sign):
    def generate(_, builder, x):
        if x.type != _REGISTER:
            return x
        one, other = (builder.extract_element(x, _INDEX(lane)) for lane in (0, 1))
        return builder.select(builder.fcmp_ordered(sign, one, other), other, one)
    return generate


def _operator(name, instruction):
    def generate(_, builder, a, b):
        return getattr(builder, instruction)(a, b)

    plain = getattr(operator, name)
    setattr(Two, f"__{name}__", lambda a, b: _each(plain, a, b))
    setattr(Two, f"__r{name}__", lambda a, b: _each(plain, b, a))
    for function in (plain, getattr(operator, f"i{name}")):
        _compile(function, generate, _TWO, (_TWO, _TWO), (_TWO, _NUMBER), (_NUMBER, _TWO))


for _name, _instruction in (("add", "fadd"), ("sub", "fsub"), ("mul", "fmul"), ("truediv", "fdiv")):
    _operator(_name, _instruction)
_compile(operator.neg, lambda _, builder, x: builder.fneg(x), _TWO, (_TWO,))
_compile(two, lambda _, builder, a, b: _pack(builder, a, b), _TWO, (_NUMBER, _NUMBER))
_compile(first, lambda _, builder, x: builder.extract_element(x, _INDEX(0)), _NUMBER, (_TWO,))
_compile(second, lambda _, builder, x: builder.extract_element(x, _INDEX(1)), _NUMBER, (_TWO,))
_compile(sqrt, _by_intrinsic("sqrt"), None, (_NUMBER,), (types.float32,), (_TWO,))
_compile(absolute, _by_intrinsic("fabs"), None, (_NUMBER,), (_TWO,))
_compile(cos, _by_library(math.cos), None, (_NUMBER,), (_TWO,))
_compile(sin, _by_library(math.sin), None, (_NUMBER,), (_TWO,))
_compile(most, _outermost("<"), _NUMBER, (_NUMBER,), (_TWO,))
_compile(least, _outermost(">"), _NUMBER, (_NUMBER,), (_TWO,))
_compile(where_less, lambda _, builder, a, b, yes, no: builder.select(builder.fcmp_ordered("<", a, b), yes, no), None,
         *((w, x, y, z) for w in (_NUMBER, _TWO) for x in (_NUMBER, _TWO) for y in (_NUMBER, _TWO) for z in (_NUMBER, _TWO)))
