#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A part moved by whole bins, far from the origin, keeps its points, its topology and nearly every triangle.
usage: far_moved.py CASE"""
import json
import os

import h5py
import numpy

from cases import run_case
from end_to_end import read_view, run

GRID = 2.0**20  # coordinates are multiples of 2^-20 mm, so moving a part by whole bins of 2^-k mm rounds nothing


def write_part(path, points):
    with open(path, "wb") as out:
        out.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(points))
        out.write(b"".join(b"property double %s\n" % axis for axis in (b"x", b"y", b"z")) + b"end_header\n")
        out.write(points.astype("<f8").tobytes())


def part_of(work, count):
    """A bumpy ball without its lower cap: noise, an open border, scan lines that beat with the bins."""
    run("bench", "scale", "--generate", f"{work}/ball.ply", "--points", count)
    points = read_view(f"{work}/ball.ply")[1].astype(float)
    points = points[points[:, 2] > -0.6 * numpy.abs(points).max()]
    return numpy.rint(points * GRID) / GRID


class Made:
    """What the record of a job over the part holds, keyed by the part's own rows and without the move."""

    def __init__(self, work, name, points, bin_mm, bins_moved, more=""):
        move = numpy.array(bins_moved, dtype=float) * bin_mm
        moved = points + move
        assert numpy.array_equal(moved * GRID, numpy.rint(moved * GRID)), "the move rounds"
        os.makedirs(f"{work}/{name}")
        write_part(f"{work}/{name}/part.ply", moved)
        with open(f"{work}/{name}.yaml", "w") as job:
            job.write(f"scanmill: 1\narchive: {name}\nsettle_s: 0\nlattice: {{bin_mm: {bin_mm}, origin: absolute}}\n{more}")
        run("run", f"{work}/{name}.yaml", "--out", f"{work}/{name}.out", "--threads", 2)
        self.counts = json.load(open(f"{work}/{name}.out/run.json"))["scans"][0]["counts"]
        with h5py.File(f"{work}/{name}.out/scans/part/record.h5") as record:
            source = record["reduced/source_row"][()].astype(numpy.int64)
            self.bins = dict(zip(source, map(tuple, record["reduced/bin"][()] - numpy.array(bins_moved))))
            self.drops = dict(zip(source, record["reduced/drop"][()]))
            row = source[record["mesh/row"][()]]
            self.offset = record["mesh"].attrs["offset_mm"]
            positions = record["mesh/stl_positions"][()].astype(float) + self.offset - move
            self.positions = dict(zip(row, positions))
            corners = row[record["mesh/triangles"][()]]
            first = corners.argmin(axis=1)
            self.triangles = {tuple(numpy.roll(t, -k)) for t, k in zip(corners, first)}

    def topology(self):
        edges = {}
        for t in self.triangles:
            for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0])):
                edges.setdefault((min(a, b), max(a, b)), []).append(a < b)
        used = {v for t in self.triangles for v in t}
        return {"vertices": len(used), "triangles": len(self.triangles), "edges": len(edges),
                "open": sum(len(d) == 1 for d in edges.values()), "manifold": all(len(d) <= 2 and len(set(d)) == len(d) for d in edges.values()),
                "loops": self.counts["boundary_loops"], "patches": self.counts["patches"]}


def compare(home, far, bin_mm):
    """Same points of the same bins, positions to a thousandth of a bin, equal topology, 99.9 % of the triangles."""
    assert home.bins == far.bins and home.drops == far.drops
    assert set(home.positions) == set(far.positions)
    apart = max(numpy.abs(home.positions[v] - far.positions[v]).max() for v in home.positions)
    assert apart <= 1e-3 * bin_mm, apart
    assert home.topology() == far.topology() and home.topology()["manifold"], (home.topology(), far.topology())
    shared = len(home.triangles & far.triangles) / len(home.triangles)
    assert shared >= 0.999, shared
    for key in ("rms_mm", "max_error_mm"):
        assert abs(home.counts[key] - far.counts[key]) <= 1e-3 * bin_mm, (key, home.counts, far.counts)
    assert not home.offset.any() and numpy.abs(far.offset).min() > 4e5
    print(f"{len(home.triangles)} triangles, {shared:.6f} of them equal, positions within {apart / bin_mm:.1e} h")


def moved_by_whole_bins(work, bin_mm, moves, more="", count=200000):
    points = part_of(work, count)
    home = Made(work, "home", points, bin_mm, (0, 0, 0), more)
    assert home.topology()["open"] > 0
    for number, move in enumerate(moves):
        compare(home, Made(work, f"far{number}", points, bin_mm, move, more), bin_mm)


def bins_of_half_a_millimetre(work):
    moved_by_whole_bins(work, 0.5, ((1 << 20, -(1 << 20) - 77777, 9_999_999), (1_000_001, 5_555_555, -9_876_543)))


def the_papers_rules(work):
    moved_by_whole_bins(work, 1, ((4_999_999, -3_333_333, 500_001),), "profile: paper\n")


def bins_of_a_decimal_fraction(work):
    """0.36 is no binary fraction, 25 bins of it are 9 mm: here bins follow to the last point, too. What may differ, in
    principle, is a point within 1e-9 of a bin's border, and the choice between two points as near to a tie."""
    moved_by_whole_bins(work, 0.36, ((25 * 60000, -25 * 555555, 25 * 333333),))


if __name__ == "__main__":
    run_case([bins_of_half_a_millimetre, the_papers_rules, bins_of_a_decimal_fraction])
