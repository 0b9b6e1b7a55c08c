#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Check a record.h5 with readers that are not ours.

usage: check_record.py RECORD [--stl FILE] [--archive DIR] [--no-vtk]

vtk      VTK opens the record as an unstructured grid with the right number of points and cells
identity a SHA-256 is stored, and so are the other root attributes
stl      the STL file's bytes, rebuilt from the record alone (--stl)
source   ten vertices (fixed seed) are found again in the named file and row, after units and pose (--archive)

Prints one line per check, "ok" or "FAIL" first; exit code 1 when one failed.
"""
import argparse
import os
import random
import re
import struct
import sys

import h5py
import numpy as np

PLY_TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
             "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
             "double": "f8", "float64": "f8"}


def text(value):
    return value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else str(value)


def read_ply_header(stream):
    """format word and [(element, count, [(name, type, count type or None)])]; leaves the stream at the body"""
    if stream.readline().strip() != b"ply":
        raise ValueError("no PLY file")
    form, elements = None, []
    while True:
        line = stream.readline()
        if not line:
            raise ValueError("PLY header does not end")
        words = line.decode("latin-1").split()
        if not words:
            continue
        if words[0] == "end_header":
            return form, elements
        if words[0] == "format":
            form = words[1]
        elif words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            if words[1] == "list":
                elements[-1][2].append((words[4], PLY_TYPES[words[3]], PLY_TYPES[words[2]]))
            else:
                elements[-1][2].append((words[2], PLY_TYPES[words[1]], None))


def skip_binary(stream, order, count, properties):
    if all(listed is None for _, _, listed in properties):
        stream.seek(count * sum(np.dtype(kind).itemsize for _, kind, _ in properties), os.SEEK_CUR)
        return
    for _ in range(count):
        for _, kind, listed in properties:
            items = 1
            if listed:
                size = np.dtype(order + listed)
                items = int(np.frombuffer(stream.read(size.itemsize), size)[0])
            stream.seek(items * np.dtype(kind).itemsize, os.SEEK_CUR)


def ply_vertices(path, rows):
    """{row: possible (x, y, z)} for the wanted vertex numbers"""
    with open(path, "rb") as stream:
        form, elements = read_ply_header(stream)
        order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[form]
        for element, count, properties in elements:
            if element != "vertex":
                if order:
                    skip_binary(stream, order, count, properties)
                else:
                    for _ in range(count):
                        stream.readline()
                continue
            if order:
                if any(listed for _, _, listed in properties):
                    raise ValueError("list properties on vertices are not supported by this check")
                row_type = np.dtype([(name, order + kind) for name, kind, _ in properties])
                start, found = stream.tell(), {}
                for row in rows:
                    stream.seek(start + row * row_type.itemsize)
                    vertex = np.frombuffer(stream.read(row_type.itemsize), row_type)[0]
                    found[row] = [tuple(float(vertex[axis]) for axis in "xyz")]
                return found
            column = {name: place for place, (name, _, _) in enumerate(properties)}
            found = {}
            for row in range(max(rows) + 1):
                words = stream.readline().split()
                if row in rows:
                    plain = tuple(float(words[column[axis]]) for axis in "xyz")
                    typed = tuple(float(np.dtype(properties[column[axis]][1]).type(words[column[axis]])) for axis in "xyz")
                    found[row] = [plain, typed]  # decimal text as it stands, or as the type the header declares
            return found
    raise ValueError("PLY file without vertices")


def text_lines(path, rows):
    """{line number from 1: possible (x, y, z)}"""
    found = {}
    with open(path, "rb") as stream:
        for number, line in enumerate(stream, 1):
            if number in rows:
                words = [word for word in re.split(rb"[\s,;]+", line.strip()) if word]
                found[number] = [tuple(float(word) for word in words[:3])]
            if len(found) == len(rows):
                break
    return found


class Report:
    def __init__(self):
        self.failed = False

    def say(self, good, name, sentence):
        self.failed |= not good
        print(("ok   " if good else "FAIL ") + name + ": " + sentence)


def check_root(record, report):
    identity = text(record.attrs["identity"])
    good = re.fullmatch("[0-9a-f]{64}", identity) and text(record.attrs["Conventions"]) == "scanmill-record-1"
    report.say(bool(good), "identity", f"{text(record.attrs['title'])}: {identity}")


def check_vtk(path, record, report):
    from vtkmodules.vtkIOHDF import vtkHDFReader
    reader = vtkHDFReader()
    if not reader.CanReadFile(path):
        report.say(False, "vtk", "vtkHDFReader cannot read the file")
        return
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    cells, points = len(record["mesh/triangles"]), len(record["mesh/stl_positions"])
    good = grid.GetNumberOfCells() == cells and grid.GetNumberOfPoints() == points
    if cells:
        good = good and grid.GetCellData().GetArray("patch").GetNumberOfTuples() == cells
        good = good and grid.GetPointData().GetArray("source_row").GetNumberOfTuples() == points
        first = [grid.GetCell(0).GetPointId(corner) for corner in range(3)]
        good = good and first == list(record["mesh/triangles"][0])
    report.say(good, "vtk", f"{grid.GetNumberOfCells()} cells, {grid.GetNumberOfPoints()} points; "
                            f"{cells} and {points} in the record")


def rebuilt_stl(record):
    corners = record["mesh/stl_positions"][()][record["mesh/triangles"][()].astype(np.int64)]  # [f, 3, 3] float32
    if len(corners) == 0:
        corners = np.zeros((0, 3, 3), np.float32)
    wide = corners.astype(np.float64)
    u, v = wide[:, 1] - wide[:, 0], wide[:, 2] - wide[:, 0]
    normal = np.stack([u[:, 1] * v[:, 2] - u[:, 2] * v[:, 1], u[:, 2] * v[:, 0] - u[:, 0] * v[:, 2],
                       u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]], axis=1)
    length = np.sqrt(normal[:, 0] * normal[:, 0] + normal[:, 1] * normal[:, 1] + normal[:, 2] * normal[:, 2])
    normal = np.where(length[:, None] > 0, normal / np.where(length > 0, length, 1)[:, None], 0.0)
    facets = np.zeros(len(corners), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]))
    facets["normal"] = normal.astype(np.float32) + np.float32(0)  # -0 becomes +0
    facets["corners"] = corners
    return record["mesh/stl_header"][()].tobytes() + struct.pack("<I", len(facets)) + facets.tobytes()


def check_stl(record, stl, report):
    with open(stl, "rb") as stream:
        given = stream.read()
    made = rebuilt_stl(record)
    if made == given:
        report.say(True, "stl", f"{len(made)} bytes rebuilt from the record alone, all equal")
        return
    differs = next((i for i, (a, b) in enumerate(zip(made, given)) if a != b), min(len(made), len(given)))
    report.say(False, "stl", f"rebuilt {len(made)} bytes, the file has {len(given)}, first difference at byte {differs}")


def equal_but_for_rounding(a, b, offset):
    """Within one unit in the last place of float32; of double where sums of large numbers cancelled."""
    size = np.maximum(np.abs(a), np.abs(b))
    slack = 64 * np.spacing(np.max(np.abs(a.astype(np.float64)) + np.abs(offset)))
    return bool(np.all(np.abs(a.astype(np.float64) - b) <= np.maximum(np.spacing(size), slack)))


def check_source(record, archive, report):
    positions = record["mesh/stl_positions"][()]
    if len(positions) == 0:
        report.say(True, "source", "no vertices")
        return
    views, rows = record["VTKHDF/PointData/source_view"][()], record["VTKHDF/PointData/source_row"][()]
    offset = np.asarray(record["mesh"].attrs["offset_mm"], np.float64)
    chosen = random.Random(20010159).sample(range(len(positions)), min(10, len(positions)))
    by_view = {}
    for vertex in chosen:
        by_view.setdefault(int(views[vertex]), []).append(vertex)
    wrong, inputs = [], record["inputs"]
    for view, vertices in sorted(by_view.items()):
        name = text(inputs["path"][view])
        wanted = {int(rows[vertex]) for vertex in vertices}
        is_line = text(inputs["row_meaning"][view]).startswith("line")
        found = (text_lines if is_line else ply_vertices)(os.path.join(archive, name), wanted)
        pose = inputs["pose"][view]
        for vertex in vertices:
            row = int(rows[vertex])
            if row not in found:
                wrong.append(f"vertex {vertex}: {name} has no row {row}")
                continue
            expected = [(pose[:3, :3] @ (np.array(p) * inputs["units_mm"][view]) + pose[:3, 3] - offset).astype(np.float32)
                        for p in found[row]]
            if not any(equal_but_for_rounding(e, positions[vertex], offset) for e in expected):
                wrong.append(f"vertex {vertex} at {positions[vertex]}: {name} row {row} gives {expected[0]}")
    for sentence in wrong:
        report.say(False, "source", sentence)
    if not wrong:
        report.say(True, "source", f"{len(chosen)} vertices found in {len(by_view)} files")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("record")
    parser.add_argument("--stl")
    parser.add_argument("--archive")
    parser.add_argument("--no-vtk", action="store_true")
    options = parser.parse_args()
    report = Report()
    with h5py.File(options.record, "r") as record:
        check_root(record, report)
        if not options.no_vtk:
            check_vtk(options.record, record, report)
        if options.stl:
            check_stl(record, options.stl, report)
        if options.archive:
            check_source(record, options.archive, report)
    return 1 if report.failed else 0


if __name__ == "__main__":
    sys.exit(main())
