"""Kernels in, object files out: Numba compiles them to LLVM's language, LLVM to machine code of any platform.

Run as a module, in a process of its own, because Numba decides on the processor when it is imported: kernels are
compiled for the baseline of each architecture, whatever machine builds them.

Numba's wrappers for the interpreter are dropped. What is left are the functions

    int32_t curvesqueal_KERNEL(void **result, void **error, double *memory, ...)

with the memory of `component.Instance`; they call the C mathematics library and nothing else.
"""

from __future__ import annotations

import json
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ...component import Component, Instance
from ...sources import PACKAGE, files_of
from .kept import keep, kept, key_of

PREFIX = "curvesqueal_"
C_FUNCTIONS = {
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "exp",
    "expm1",
    "fmod",
    "log",
    "log1p",
    "pow",
    "sin",
    "sqrt",
    "tan",
}
"""What kernels may call. LLVM's own intrinsics become such functions, or memset and memcpy."""

NOTHING = re.compile(r"(define [^\n]*@NRT_(?:in|de)cref\([^\n]*\{)\n.*?\n\}", re.DOTALL)
"""Reference counting of arrays: the arrays of kernels are views of the instance's memory, which nobody counts."""


def lower(components: Mapping[str, Component], triples: Iterable[str], folder: Path) -> dict[tuple[str, str], Path]:
    """Write the object files of components into `folder`, kept ones or compiled; return them by name and triple.

    Parameters
    ----------
    components : by a name for their files
    triples : LLVM's names of the platforms
    folder : also gets NAME.TRIPLE.ll of what was compiled, the kernels in LLVM's language
    """
    kinds = {name: (c.kernels, tuple(sizes_of(c))) for name, c in components.items()}
    first = {kind: name for name, kind in reversed(kinds.items())}  # the same kernels and sizes are compiled once
    wanted = sorted(triples)
    keys = {(name, triple): _key(kind, triple) for kind, name in first.items() for triple in wanted}
    found = {each: kept(key) for each, key in keys.items()}
    missing = {name: list(kind) for kind, name in first.items() if any(found[name, t] is None for t in wanted)}
    if missing:
        _lower_in_a_process({"components": missing, "triples": wanted, "folder": str(folder)})
    for (name, triple), key in keys.items():
        path, content = folder / f"{name}.{triple}.o", found[name, triple]
        if name in missing:
            keep(key, path.read_bytes())
        elif content is not None:
            path.write_bytes(content)
    return {(name, t): folder / f"{first[kind]}.{t}.o" for name, kind in kinds.items() for t in wanted}


def _key(kind: tuple[str, tuple[int, ...]], triple: str) -> str:
    """Return under which name an object file is kept: a hash of its kernels, of this file and of the compilers."""
    kernels, sizes = kind
    texts = [(PACKAGE / name).read_bytes() for name in files_of(kernels)]
    tools = [platform.python_version(), *(version(name) for name in ("numba", "llvmlite"))]
    return key_of([kernels, repr(sizes), triple, *tools, Path(__file__).read_bytes(), *texts])


def _lower_in_a_process(specification: Mapping[str, Any]) -> None:
    """Run this module for the baseline of each architecture.

    Raises
    ------
    RuntimeError
        If a kernel cannot be compiled.
    """
    environment = {**os.environ, "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "", "NUMBA_OPT": "1"}
    done = subprocess.run(
        [sys.executable, "-m", __name__], input=json.dumps(specification), env=environment,
        cwd=Path(__file__).parents[3], capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(f"the kernels could not be compiled: {done.stderr.strip()}")


def sizes_of(component: Component) -> list[int]:
    """Return the lengths of parameters, derived, state, inputs and outputs."""
    i = Instance(component)
    return [a.size for a in (i.parameters, i.derived, i.state, i.inputs, i.outputs)]


def _entries(kernels: str, sizes: list[int]) -> dict[str, tuple[Any, Any]]:
    """Return the functions to compile by name, each with its Numba signature."""
    from numba import carray, types  # type: ignore[attr-defined]  # noqa: PLC0415

    module = import_module(f"fmus.{kernels}")
    initialise, do_step = module.initialise, module.do_step
    differentiate: Any = getattr(module, "differentiate", None)
    a = sizes[0]
    b = a + sizes[1]
    c = b + sizes[2]
    d = c + sizes[3]
    e = d + sizes[4]
    n_inputs, n_outputs = sizes[3:]

    def initialise_entry(memory: Any) -> None:
        m = carray(memory, e)
        initialise(m[:a], m[a:b], m[b:c], m[c:d], m[d:e])

    def do_step_entry(memory: Any, h: float) -> None:
        m = carray(memory, e)
        do_step(m[:a], m[a:b], m[b:c], m[c:d], m[d:e], h)

    def differentiate_entry(memory: Any, h: float, seed: Any, sensitivity: Any) -> None:
        m = carray(memory, e)
        differentiate(m[:a], m[a:b], m[b:c], m[c:d], m[d:e], h, carray(seed, n_inputs), carray(sensitivity, n_outputs))

    pointer = types.CPointer(types.float64)
    real = types.float64
    entries = {
        "initialise": (initialise_entry, types.void(pointer)),
        "do_step": (do_step_entry, types.void(pointer, real)),
    }
    if differentiate is not None:
        entries["differentiate"] = (differentiate_entry, types.void(pointer, real, pointer, pointer))
    return entries


def _module(kernels: str, sizes: list[int]) -> Any:
    """Return one LLVM module with the kernels of a component and nothing of the interpreter."""
    import llvmlite.binding as llvm  # noqa: PLC0415
    import numba  # noqa: PLC0415

    merged = None
    for name, (function, signature) in _entries(kernels, sizes).items():
        compiled: Any = numba.cfunc(signature, error_model="numpy")(function)
        text = NOTHING.sub(r"\1\n  ret void\n}", compiled._library.get_llvm_str())
        module = llvm.parse_assembly(text)
        entry = module.get_function(compiled.native_name.removeprefix("cfunc."))
        entry.name = PREFIX + name
        entry.visibility = "hidden"
        for each in module.functions:
            if not each.is_declaration and each.name != PREFIX + name:
                each.linkage = "internal"
        for each in module.global_variables:
            if not each.is_declaration:
                each.linkage = "internal"
        if merged is None:
            merged = module
        else:
            merged.link_in(module)
    return merged


def _optimise(module: Any, machine: Any) -> None:
    """Drop what nothing calls, and let LLVM do its best for the target machine."""
    import llvmlite.binding as llvm  # noqa: PLC0415

    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=3))
    builder.getModulePassManager().run(module, builder)
    module.verify()
    outside = {f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")}
    if not outside <= C_FUNCTIONS:
        raise RuntimeError(f"a kernel calls {', '.join(sorted(outside - C_FUNCTIONS))}; only C's mathematics is there")


def _compile(name: str, kernels: str, sizes: list[int], triples: list[str], folder: Path) -> None:
    """Write the object files of one component."""
    import llvmlite.binding as llvm  # noqa: PLC0415

    text = str(_module(kernels, sizes))
    for triple in triples:
        machine = llvm.Target.from_triple(triple).create_target_machine(opt=3, reloc="pic", codemodel="default")
        module = llvm.parse_assembly(text)
        module.triple = triple
        module.data_layout = str(machine.target_data)
        _optimise(module, machine)
        (folder / f"{name}.{triple}.o").write_bytes(machine.emit_object(module))
        (folder / f"{name}.{triple}.ll").write_text(str(module), encoding="utf-8")


def main() -> None:
    """Do what the specification on the standard input says."""
    import llvmlite.binding as llvm  # noqa: PLC0415

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    specification = json.load(sys.stdin)
    for name, (kernels, sizes) in specification["components"].items():
        _compile(name, kernels, sizes, specification["triples"], Path(specification["folder"]))


if __name__ == "__main__":
    main()
