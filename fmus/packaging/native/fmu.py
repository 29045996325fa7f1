"""Components in, native FMUs out: no Python on the host, one archive for several platforms."""

from __future__ import annotations

import hashlib
import json
import platform as host
import shutil
import struct
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import version as version_of
from importlib.resources import files
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import fmpy

from ...component import Component
from ...sources import PACKAGE, files_of
from ..archive import write_files
from ..c99.translator import translate
from ..description.documentation import documentation_files
from ..description.fmi2 import model_description
from ..description.fmi3 import model_description3
from ..description.terminals import terminal_files
from .linker import FLAGS, Compiler, find_compiler, link, with_cache
from .lowering import lower, sizes_of
from .platforms import PLATFORMS, Platform
from .tables import component_header

HEADERS = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
"""The headers of the standard, under a BSD licence, as FMPy carries them."""


@dataclass(frozen=True)
class Standard:
    """What an FMU speaks.

    Attributes
    ----------
    fmi : major version, 2 or 3
    only_scalars : whether FMI 3 does without arrays
    """

    fmi: int = 2
    only_scalars: bool = False


def build_native_fmus(
    components: Mapping[str, Component],
    platforms: Iterable[str],
    standard: Standard,
    folder: Path,
    version: str,
) -> dict[str, Path]:
    """Write one FMU per component into `folder`; return the files by name. The same input gives the same bytes.

    Parameters
    ----------
    components : by the name of the FMU file without suffix
    platforms : names of `PLATFORMS`
    standard : Standard
    folder : where the FMUs go; must exist
    version : version of the project, written into the model description

    Raises
    ------
    RuntimeError
        If there is no compiler for a platform, or it fails.
    """
    chosen = [PLATFORMS[name] for name in sorted(set(platforms))]
    compilers = {}
    for each in chosen:
        compiler = find_compiler(each.name)
        if compiler is None:
            raise RuntimeError(f"there is no C compiler for {each.name}; the package ziglang brings one")
        compilers[each.name] = compiler
    built = {}
    with tempfile.TemporaryDirectory(prefix="curvesqueal_") as temporary:
        scratch = Path(temporary)
        compilers = {name: with_cache(compiler, scratch) for name, compiler in compilers.items()}
        objects = lower(components, [p.triple for p in chosen], scratch)
        for name, component in components.items():
            own = {p: objects[name, p.triple] for p in chosen}
            file = folder / f"{name}.fmu"
            write_files(_content(component, standard, own, compilers, version), file)
            built[name] = file
    return built


def _content(
    component: Component,
    standard: Standard,
    objects: Mapping[Platform, Path],
    compilers: Mapping[str, Compiler],
    version: str,
) -> dict[str, bytes]:
    """Return the files of an FMU by their names in it."""
    fmi = standard.fmi
    sources, description = _sources(component, standard, version)
    content = {
        **{f"sources/{name}": data for name, data in sources.items()},
        "modelDescription.xml": description,
        "extra/org.curvesqueal/build.json": _provenance(component, fmi, objects, compilers),
        **documentation_files(component, version, python=False),
        **terminal_files(component, fmi),
    }
    with tempfile.TemporaryDirectory(prefix="curvesqueal_") as temporary:
        folder = Path(temporary)
        for source, data in sources.items():
            (folder / source).write_bytes(data)
        libraries: dict[Platform, bytes] = {}
        for each, kernels in objects.items():
            shutil.copyfile(kernels, folder / "kernels.o")
            library = link(
                compilers[each.name], each, [f"fmi{fmi}.c", "kernels.o"], component.name + each.suffix, folder
            )
            libraries[each] = library.read_bytes()
    content.update(_binaries(component.name, fmi, libraries))
    return content


def _sources(component: Component, standard: Standard, version: str) -> tuple[dict[str, bytes], bytes]:
    """Return what a C compiler reads, by file name, and modelDescription.xml."""
    fmi = standard.fmi
    c = files(__package__).joinpath("c")
    headers = Path(fmpy.__file__).parent / "c-code"
    sources = {name: c.joinpath(name).read_bytes() for name in ("instance.h", f"fmi{fmi}.c")}
    sources |= {name: (headers / name).read_bytes() for name in HEADERS[fmi]}
    names = ("initialise", "do_step", *(("differentiate",) if component.differentiable else ()))
    sources["kernels.c"] = translate({name: component.kernel(name) for name in names}, sizes_of(component)).encode()
    digest = hashlib.sha256(_kernel_text(component))
    for name in sorted(sources):
        digest.update(sources[name])
    content = digest.hexdigest()[:16]
    if fmi == 3:
        root = model_description3(component, version, content, standard.only_scalars)
        sources["buildDescription.xml"] = _build_description(component.name)
    else:
        root = model_description(component, version, content, component.differentiable, [f"fmi{fmi}.c"])
    token = root.attrib["instantiationToken" if fmi == 3 else "guid"]
    sources["component.h"] = component_header(component, fmi, token, standard.only_scalars).encode()
    return sources, tostring(root, "utf-8", xml_declaration=True)


def _build_description(identifier: str) -> bytes:
    """Return buildDescription.xml: which files to compile, and with what."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    sources = SubElement(configuration, "SourceFileSet", language="C99")
    SubElement(sources, "SourceFile", name="fmi3.c")
    SubElement(configuration, "Library", name="m", external="true", description="the C mathematics library")
    text: bytes = tostring(root, "utf-8", xml_declaration=True)
    return text


def _kernel_text(component: Component) -> bytes:
    """Return the Python sources that the kernels come from."""
    return b"".join((PACKAGE / name).read_bytes() for name in files_of(component.kernels))


def _provenance(
    component: Component, fmi: int, objects: Mapping[Platform, Path], compilers: Mapping[str, Compiler]
) -> bytes:
    """Return how the binaries were made."""
    data = {
        "kernels": f"fmus.{component.kernels}, lowered by Numba and LLVM, baseline processor",
        "kernels_sha256": hashlib.sha256(_kernel_text(component)).hexdigest(),
        "versions": {name: version_of(name) for name in ("numba", "llvmlite", "curvesqueal")},
        "python": host.python_version(),
        "entry_points": f"sources/fmi{fmi}.c",
        "flags": " ".join(FLAGS),
        "compilers": {p.name: compilers[p.name].name for p in objects},
    }
    return json.dumps(data, indent=1, sort_keys=True).encode()


def _binaries(name: str, fmi: int, libraries: Mapping[Platform, bytes]) -> dict[str, bytes]:
    """Return the libraries by their places in the FMU; for FMI 2 those of macOS are one universal file."""
    if fmi == 3:
        return {f"binaries/{p.name}/{name}{p.suffix}": data for p, data in libraries.items()}
    found = {
        f"binaries/{p.fmi2_folder}/{name}{p.suffix}": data for p, data in libraries.items() if p.suffix != ".dylib"
    }
    apple = {p.name: data for p, data in libraries.items() if p.suffix == ".dylib"}
    if apple:
        found[f"binaries/darwin64/{name}.dylib"] = universal(apple) if len(apple) > 1 else next(iter(apple.values()))
    return found


_CPU = {"x86_64-darwin": (0x01000007, 3), "aarch64-darwin": (0x0100000C, 0)}
_ALIGNMENT = 14


def universal(libraries: Mapping[str, bytes]) -> bytes:
    """Return one Mach-O file of libraries for several architectures: Apple's "fat" format, big-endian header."""
    header = struct.pack(">II", 0xCAFEBABE, len(libraries))
    body = b""
    place = -(-(len(header) + 20 * len(libraries)) // (1 << _ALIGNMENT)) << _ALIGNMENT
    begin = place
    for platform, data in sorted(libraries.items()):
        header += struct.pack(">IIIII", *_CPU[platform], place, len(data), _ALIGNMENT)
        padded = -(-len(data) // (1 << _ALIGNMENT)) << _ALIGNMENT
        body += data.ljust(padded, b"\0")
        place += padded
    return header.ljust(begin, b"\0") + body
