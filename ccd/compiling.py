"""The decorators of compiled code, and how: to little machine code, for which the engine waits longer than for arithmetic."""

import functools
import os

import llvmlite.binding
import numba
from numba.core import ir, types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.lowering import Lower
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering, NopythonTypeInference
from numba.core.types.containers import BaseTuple

from ccd.code_cache import cache_folder, one_at_a_time


@register_pass(mutates_CFG=False, analysis_only=False)
class IndicesFromTheFront(FunctionPass):
    """No kernel has an index below 0: told so, numba leaves out what would count such an index from the end, at every access."""

    _name = "indices_from_the_front"

    def __init__(self):
        FunctionPass.__init__(self)

    def run_pass(self, state):
        changed = {}
        for node, signature in state.calltypes.items():
            if isinstance(node, ir.SetItem) or (isinstance(node, ir.Expr) and node.op == "getitem"):
                array, index, *value = signature.args
                if isinstance(array, types.Array):
                    changed[node] = signature.replace(args=(array, _not_negative(index), *value))
        state.calltypes.update(changed)
        return bool(changed)


def _not_negative(index):
    if isinstance(index, BaseTuple):
        return BaseTuple.from_types([_not_negative(each) for each in index])
    return types.uintp if isinstance(index, types.Integer) and not isinstance(index, types.Literal) else index


class _Lower(Lower):
    """A large kernel stays a function of its own: LLVM would copy it to every place that calls it."""

    def setup_function(self, fndesc):
        super().setup_function(fndesc)
        if "alwaysinline" not in self.function.attributes:
            self.function.attributes.add("noinline")


@register_pass(mutates_CFG=True, analysis_only=False)
class KernelLowering(NativeLowering):
    _name = "kernel_lowering"
    lowering_class = _Lower


class KernelCompiler(CompilerBase):
    """numba's own pipeline, with these two and without unrolled loops."""

    _nested = 0

    def define_pipelines(self):
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(IndicesFromTheFront, NopythonTypeInference)
        passes.passes = [(KernelLowering, why) if each is NativeLowering else (each, why) for each, why in passes.passes]
        passes.finalize()
        return [passes]

    def compile_extra(self, function):
        KernelCompiler._nested += 1                         # a kernel is compiled within those that call it, one thread at a time
        _unroll("false", 20)
        try:
            return super().compile_extra(function)
        finally:
            KernelCompiler._nested -= 1
            if not KernelCompiler._nested:
                _unroll("true", 300)                        # what LLVM does by itself


def _unroll(copies, threshold):
    for option in (f"-unroll-runtime={copies}", f"-unroll-threshold={threshold}"):
        llvmlite.binding.set_option("ccd", option)


OPTIONS = {"nogil": True, "error_model": "numpy", "_nrt": False, "pipeline_class": KernelCompiler, "no_cfunc_wrapper": True}


class Entry(CPUDispatcher):
    """Compiled code that Python calls. Processes that want the same compile it once."""

    def compile(self, signature):
        with one_at_a_time(_package(self.py_func)):
            return super().compile(signature)


class Kernel(CPUDispatcher):
    """Compiled code as other compiled code calls it. What Python calls as well is compiled for it, on the first call: taking arguments from
    Python is more code than most kernels are."""

    @functools.cached_property
    def entry(self):
        return _entry(self.py_func, "called from Python", **OPTIONS, forceinline=False, no_cpython_wrapper=False)

    def __call__(self, *arguments):
        return self.entry(*arguments)


def kernel(function):
    """Compile with numba: cached on disk, free of the interpreter lock, division as in numpy, never fastmath (inf means "no event").

    A kernel allocates nothing and counts no references: one that returns a view of an array is called by kernels only.
    """
    return _inner(function, forceinline=True)


def large_kernel(function):
    """`kernel` that is not copied to wherever it is called: one long and wanted in several places, or wanted rarely. With few arguments:
    a World is more than two hundred."""
    return _inner(function, forceinline=False)              # said, since an option not set is that of whoever compiles first


def _inner(function, forceinline):
    compiled = _compile(function, "", **OPTIONS, forceinline=forceinline, no_cpython_wrapper=True)
    if compiled is not function:                            # which it is with NUMBA_DISABLE_JIT
        compiled.__class__ = Kernel
    return compiled


def parallel_kernel(function):
    """`kernel` whose prange loops run on all cores, called from Python. The results do not depend on how many there are."""
    return _entry(function, "", nogil=True, error_model="numpy", parallel=True)


def _entry(function, room, **options):
    compiled = _compile(function, room, **options)
    if compiled is not function:
        compiled.__class__ = Entry
    return compiled


def _compile(function, room, **options):
    folder = cache_folder(_package(function))
    if folder is None:
        return numba.njit(**options)(function)
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = os.path.join(folder, room)
    try:
        return numba.njit(cache=True, **options)(function)
    finally:
        numba.config.CACHE_DIR = before


def _package(function):
    return function.__module__.split(".")[0]
