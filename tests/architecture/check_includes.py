#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads all sources and fails on an include against the layers, a foreign header outside its wall, a container keyed by
bins that is not an OpenVDB tree, or a libm function whose bits differ between CPUs on the way to results.

usage: check_includes.py SRC | --self-test
"""
import re
import sys
from pathlib import Path

# Layer by layer; a module includes lower layers only, never another module of its own layer, except as named below.
LAYERS = [
    ["base", "document"],
    ["geom", "timing"],
    ["cloud", "mesh", "lattice", "fringe"],
    ["plan", "simulate", "refine", "clean", "reduce", "stars", "grow", "front", "merge", "optimise", "verify", "surfaces"],
    ["formats", "export", "render", "report", "provenance", "store"],
    ["pipeline"],
    ["runner"],
    ["cli"],
]
LAYER = {module: number for number, modules in enumerate(LAYERS) for module in modules}
WITHIN_LAYER = {("document", "base")}
# Less than the layers would allow: what the outside world and the runner may see.
ONLY = {
    "formats": {0, 1, 2},
    "export": {0, 1, 2},
    "render": {0, 1, 2},
    "report": {0, 1, 2},
    "provenance": {0, 1, 2},
    "store": {0, 1, 2},
}
ONLY_MODULES = {"runner": {"base", "document", "timing", "store"}}

# Foreign header -> the places that may include it.
WALLS = [
    (r"openvdb/|nanovdb/", ["lattice/", "store/"]),
    (r"CLI/", ["cli/"]),
    (r"tbb/|oneapi/", ["base/chunks.cpp"]),
    (r"hdf5|H5|highfive", ["provenance/hdf5_file.", "provenance/hdf5_reader."]),
    (r"yaml-cpp/|nlohmann/", ["document/"]),
    (r"openssl/", ["base/digest.cpp"]),
    (r"zlib\.h|zconf\.h", ["base/deflate.cpp", "formats/png.cpp"]),
    (r"Eigen/|unsupported/Eigen", ["geom/"]),
    (r"zlib", ["base/deflate.cpp", "formats/png.cpp"]),
    (r"vtk|CGAL/|pcl/|open3d/|TopoDS|BRep|STEPControl|IGESControl", []),
]

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.M)
LIBM = re.compile(
    r"(?<![\w.>:])(?:std::|::)?((?:sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|hypot|cbrt)[fl]?)\s*\("
)
CONTAINER = re.compile(r"\b(?:unordered_)?(?:multi)?(?:map|set)\s*<")
BIN = re.compile(r"\b(?:BinKey|LocalBin)\b")


def without_comments(text):
    """Comments and literals blanked out, lines kept."""
    token = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)
    return token.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def first_argument(text, start):
    """The first template argument from just behind '<'."""
    depth = 0
    for at in range(start, len(text)):
        c = text[at]
        if c in "<([":
            depth += 1
        elif c in ">)]":
            if depth == 0:
                return text[start:at]
            depth -= 1
        elif c == "," and depth == 0:
            return text[start:at]
    return text[start:]


def may_include(module, other):
    if module == other:
        return True
    if module in ONLY_MODULES:
        return other in ONLY_MODULES[module]
    if (module, other) in WITHIN_LAYER:
        return True
    if module in ONLY:
        return LAYER[other] in ONLY[module]
    return LAYER[other] < LAYER[module]


def problems_of(path, text):
    """One line per violation; `path` is relative to src/, with '/'."""
    found = []
    module = path.split("/")[0] if "/" in path else None  # main.cpp stands above all
    line_of = lambda at: text.count("\n", 0, at) + 1
    if module is not None and module not in LAYER:
        return [f"src/{path}:1: module {module} is in no layer; name it in tests/architecture/check_includes.py"]
    for match in INCLUDE.finditer(text):
        where = f"src/{path}:{line_of(match.start())}"
        name = match.group(2)
        if match.group(1) == '"':
            other = name.split("/")[0]
            if "/" not in name or other not in LAYER:
                found.append(f'{where}: "{name}" is no "module/file" of src/')
            elif module is None:
                if other not in ("cli", "base"):
                    found.append(f"{where}: main includes {name}; it may see cli only")
            elif not may_include(module, other):
                found.append(f"{where}: {module} (layer {LAYER[module]}) must not include {name} (layer {LAYER[other]})")
        for pattern, places in WALLS:
            if re.match(pattern, name) and match.group(1) == "<" and not any(path.startswith(p) for p in places):
                found.append(f"{where}: <{name}> outside its wall ({', '.join(places) or 'nowhere in src/'})")
    code = without_comments(text)
    for match in CONTAINER.finditer(code):
        if BIN.search(first_argument(code, match.end())):
            found.append(f"src/{path}:{line_of(match.start())}: container keyed by bins; use lattice's bin index (an OpenVDB tree)")
    if module is not None and LAYER[module] <= 4:
        for match in LIBM.finditer(code):
            found.append(f"src/{path}:{line_of(match.start())}: {match.group(1)}() differs between CPUs; use + - * / sqrt, or cos_of_degrees")
    return found


def check_tree(src):
    files = sorted(p for p in src.rglob("*") if p.suffix in (".hpp", ".cpp"))
    found = []
    for path in files:
        found += problems_of(path.relative_to(src).as_posix(), path.read_text(encoding="utf-8"))
    for line in found:
        print(line)
    print(f"{len(files)} files, {len(found)} violations")
    return 1 if found or not files else 0


def self_test():
    bad = [
        ("base/a.cpp", '#include "document/document.hpp"\n'),
        ("geom/a.cpp", '#include "cloud/cloud.hpp"\n'),
        ("mesh/a.hpp", '#include "lattice/lattice.hpp"\n'),
        ("reduce/a.cpp", '#include "grow/params.hpp"\n'),
        ("reduce/a.cpp", '#include "store/files.hpp"\n'),
        ("store/a.cpp", '#include "plan/plan.hpp"\n'),
        ("formats/a.cpp", '#include "store/files.hpp"\n'),
        ("pipeline/a.cpp", '#include "runner/job.hpp"\n'),
        ("runner/a.cpp", '#include "pipeline/what.hpp"\n'),
        ("runner/a.cpp", '#include "geom/vec3.hpp"\n'),
        ("main.cpp", '#include "pipeline/what.hpp"\n'),
        ("base/a.cpp", '#include "result.hpp"\n'),
        ("novel/a.cpp", "int x;\n"),
        ("reduce/a.cpp", "  #  include <openvdb/openvdb.h>\n"),
        ("runner/a.cpp", "#include <CLI/CLI.hpp>\n"),
        ("base/context.cpp", "#include <tbb/parallel_for.h>\n"),
        ("provenance/record.cpp", "#include <hdf5.h>\n"),
        ("plan/a.cpp", "#include <yaml-cpp/yaml.h>\n"),
        ("runner/a.cpp", "#include <nlohmann/json.hpp>\n"),
        ("base/bytes.cpp", "#include <openssl/evp.h>\n"),
        ("stars/a.cpp", "#include <Eigen/Dense>\n"),
        ("pipeline/a.cpp", "#include <vtkPolyData.h>\n"),
        ("render/render.cpp", "#include <zlib.h>\n"),
        ("reduce/a.cpp", "std::unordered_map<BinKey, int, Hash> bins;\n"),
        ("reduce/a.cpp", "std::set<scanmill::LocalBin> bins;\n"),
        ("pipeline/a.cpp", "std::map<std::pair<int, BinKey>, int> bins;\n"),
        ("stars/a.cpp", "double x = std::acos(y);\n"),
        ("geom/a.cpp", "double x = hypot(a, b);\n"),
        ("mesh/a.cpp", "float x = std::sinf (a);\n"),
        ("provenance/a.cpp", "double x = ::pow(a, 2);\n"),
    ]
    good = [
        ("document/a.cpp", '#include "base/result.hpp"\n#include <yaml-cpp/yaml.h>\n'),
        ("reduce/a.cpp", '#include "lattice/lattice.hpp"\n#include "reduce/params.hpp"\n'),
        ("pipeline/a.cpp", '#include "store/files.hpp"\n#include "reduce/params.hpp"\n'),
        ("runner/a.cpp", '#include "store/files.hpp"\n'),
        ("cli/a.cpp", '#include "pipeline/what.hpp"\n#include <CLI/CLI.hpp>\n'),
        ("lattice/a.cpp", "#include <openvdb/tree/Tree.h>\n"),
        ("provenance/hdf5_file.cpp", "#include <hdf5.h>\n"),
        ("base/chunks.cpp", "#include <tbb/parallel_for.h>\n"),
        ("base/deflate.cpp", "#include <zlib.h>\n"),
        ("main.cpp", '#include "cli/cli.hpp"\n'),
        ("reduce/a.cpp", "std::map<int, BinKey> by_slot;  // std::map<BinKey, int>\n"),
        ("stars/a.cpp", "// cos(x) is not used\nauto s = std::sqrt(2.0); auto c = cos_of_degrees(5); row.log(x); \"exp(1)\";\n"),
        ("pipeline/a.cpp", "double suggested = std::log(2.0);\n"),
    ]
    failures = [f"not seen: {path}: {text!r}" for path, text in bad if not problems_of(path, text)]
    failures += [f"wrongly seen: {line}" for path, text in good for line in problems_of(path, text)]
    for line in failures:
        print(line)
    print(f"{len(bad)} violations and {len(good)} sound files, {len(failures)} judged wrongly")
    return 1 if failures else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(self_test() if sys.argv[1] == "--self-test" else check_tree(Path(sys.argv[1])))
