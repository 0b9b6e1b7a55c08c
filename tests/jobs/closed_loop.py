#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Plan -> virtual scanner -> replay -> clean -> mesh, against the solid that was scanned.  usage: closed_loop.py CASE"""
import json
import math
import os
import subprocess
import sys
import tempfile

from virtual_scanner import cloud_of, plan_file, run

SOLID_ERROR = os.environ["SOLID_ERROR"]
NOISE = 0.025


def head_over_part(name, target, azimuth, elevation):
    """Station of the paper's mill: the sensor looks at a point of the global frame from this direction."""
    a, e = math.radians(azimuth), math.radians(elevation)
    away = (math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e))
    axis = [target[i] + (150 + 40) * away[i] for i in range(3)]  # the lens is 40 mm before the tilt axis
    pan = (azimuth + 360) % 360 - 180
    return "{name: %s, joints: {x: %.4f, y: %.4f, z: %.4f, a: %.2f, b: %.2f}}" % (
        name, 375 + axis[0], 250 + axis[1], axis[2] + 100 - 60, pan, -elevation)


def twenty_stations():
    """Four from above, eight from 45 degrees, eight that look almost level."""
    out = [head_over_part("top-1", (-14, 0, 6), 0, 90), head_over_part("top-2", (14, 0, 8), 0, 90),
           head_over_part("high-1", (-8, 0, 6), 180, 68), head_over_part("high-2", (8, 0, 6), 0, 68)]
    for i in range(8):
        for name, turn, reach, z, elevation in (("mid", 45 * i, (10, 6), 4, 45), ("low", 45 * i + 22.5, (16, 10), 0, 5)):
            a = math.radians(turn)
            target = (reach[0] * math.cos(a), reach[1] * math.sin(a), z)
            out.append(head_over_part(f"{name}-{i + 1}", target, turn, elevation))
    return out


# Fixture and deck end 5 mm below the figurine.
CLEAN = """clean:
  remove_box: {min: [-400, -300, -200], max: [400, 300, -17]}
"""


def made(work, name, bin_mm, more=""):
    """Job over the archive WORK/name: the folder of its scan, and how far the mesh is from the figurine."""
    with open(f"{work}/{name}.yaml", "w") as out:
        out.write(f"scanmill: 1\narchive: {name}\nsettle_s: 0\nlattice: {{bin_mm: {bin_mm}}}\n{CLEAN}{more}")
    run("run", f"{work}/{name}.yaml", "--out", f"{work}/{name}.out")
    folder = f"{work}/{name}.out/scans/mill"
    done = subprocess.run([SOLID_ERROR, "figurine", f"{folder}/mesh.stl"], capture_output=True, text=True, check=True)
    return folder, json.loads(done.stdout)


def scanned(work, name, pixels, *more, change=()):
    plan = plan_file(f"{work}/making/mill.yaml", twenty_stations(), pixels, change)
    run("simulate", plan, "--object", "figurine", "--keep-out", "--out", f"{work}/{name}", *more)
    run("replay", f"{work}/{name}/mill.yaml", "-o", f"{work}/{name}.replay", "--no-pictures")
    truth = json.load(open(f"{work}/{name}/mill.truth.json"))
    assert sum(view["around"] > 100 for view in truth["views"]) >= 8  # the fixture is in view
    assert len(cloud_of(f"{work}/{name}.replay/cloud.ply")) == sum(view["points"] for view in truth["views"])


def loop(work, pixels, bin_mm):
    scanned(work, "free", pixels)
    folder, error = made(work, "free", bin_mm)
    bound = math.sqrt((0.10 * bin_mm)**2 + NOISE**2)
    print(f"bins {bin_mm} mm: {error}, bound {bound:.4f}")
    assert error["rms_mm"] <= bound, error
    assert abs(error["mean_mm"]) <= bound / 2 and error["max_mm"] < bin_mm, error


def coarse(work):
    loop(work, (210, 150), 1.0)


def full(work):
    loop(work, (700, 500), 0.4)


CASES = {f.__name__: f for f in (coarse, full)}

if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-loop-") as folder:
        CASES[sys.argv[1]](folder)
