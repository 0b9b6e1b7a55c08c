#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The paper's reduction by sorting: of each bin's points the least (squared distance to the bin's centre, x, y, z, row).
Shares nothing with the program but the cloud; what `scanmill reduce` keeps must be the same points, all of them.
usage: oracle.py CASE"""
import numpy

from cases import run_case
from end_to_end import run

AT_ONCE = 6_000_000  # points of a slab, about: 0.7 GB


def points_of(path):
    with open(path, "rb") as file:
        header = file.read(4096)
    begin = header.index(b"end_header\n") + 11
    assert b"property float x\nproperty float y\nproperty float z\nend_header" in header
    return numpy.memmap(path, "<f4", "r", begin).reshape(-1, 3)


def reduced_of(path):
    """The kept points and the bins of what reduce wrote."""
    with open(path, "rb") as file:
        header = file.read(4096)
    begin = header.index(b"end_header\n") + 11
    elements = []
    for line in header[:begin].decode().splitlines():
        words = line.split()
        if words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            assert words[1] == "double", line
            elements[-1][2].append((words[2], "<f8"))
    found = {}
    for name, count, columns in elements:
        found[name] = numpy.memmap(path, numpy.dtype(columns), "r", begin, (count,))
        begin += found[name].nbytes
    return found["vertex"], found["bin"]


def slabs_of(points, h):
    """Layers of bins with their points, AT_ONCE or one layer at a time."""
    layer = numpy.empty(len(points), numpy.int32)
    for first in range(0, len(points), AT_ONCE):
        layer[first : first + AT_ONCE] = numpy.floor(points[first : first + AT_ONCE, 2].astype(float) / h)
    low = layer.min()
    counts = numpy.bincount(layer - low)
    first = 0
    while first < len(counts):
        end, held = first + 1, counts[first]
        while end < len(counts) and held + counts[end] <= AT_ONCE:
            held += counts[end]
            end += 1
        yield low + first, low + end, numpy.flatnonzero((layer >= low + first) & (layer < low + end))
        first = end


def winners_of(points, rows, h):
    """(k, j, i) and row of each bin's winner, ascending."""
    p = points[rows].astype(float)
    bins = numpy.floor(p / h).astype(numpy.int64)
    distance = (((bins + 0.5) * h - p) ** 2).sum(axis=1)
    order = numpy.lexsort((rows, p[:, 2], p[:, 1], p[:, 0], distance, bins[:, 0], bins[:, 1], bins[:, 2]))
    sorted_bins = bins[order]
    first = numpy.ones(len(order), bool)
    first[1:] = (sorted_bins[1:] != sorted_bins[:-1]).any(axis=1)
    return sorted_bins[first][:, ::-1], rows[order[first]]


def keeps_what_sorting_keeps(work, count, h):
    run("bench", "scale", "--generate", f"{work}/cloud.ply", "--points", count)
    run("reduce", f"{work}/cloud.ply", "-o", f"{work}/reduced.ply", "--bin-mm", h, "--representative", "centre",
        "--min-neighbour-distance", "0", timeout=3600)
    points = points_of(f"{work}/cloud.ply")
    vertices, bins = reduced_of(f"{work}/reduced.ply")
    assert len(points) == count and 3.5 < count / len(bins) < 4.5, (len(points), len(bins))
    assert not bins["drop"].any() and len(vertices) == len(bins)
    key = numpy.stack([bins[axis].astype(numpy.int64) for axis in "kji"], axis=1)
    order = numpy.lexsort((key[:, 2], key[:, 1], key[:, 0]))
    met = 0
    for _, _, rows in slabs_of(points, h):
        if len(rows) == 0:
            continue
        wanted_bins, wanted_rows = winners_of(points, rows, h)
        mine = order[met : met + len(wanted_bins)]
        assert numpy.array_equal(key[mine], wanted_bins), "other bins"
        different = numpy.flatnonzero(bins["row"][mine] != wanted_rows)
        assert len(different) == 0, f"{len(different)} bins keep another point, first {wanted_bins[different[0]]}"
        for axis, name in enumerate("xyz"):
            assert numpy.array_equal(vertices[name][mine], points[wanted_rows, axis].astype(float))
        met += len(wanted_bins)
    assert met == len(bins)
    print(f"{count} points, {met} bins, all equal")


def a_million_points(work):
    keeps_what_sorting_keeps(work, 1_000_000, 0.35)


def a_hundred_million_points(work):
    keeps_what_sorting_keeps(work, 100_000_000, 0.35)


if __name__ == "__main__":
    run_case([a_million_points, a_hundred_million_points])
