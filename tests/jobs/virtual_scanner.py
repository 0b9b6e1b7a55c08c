#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The virtual scanner and what is checked with it, as users run them.  usage: virtual_scanner.py CASE"""
import json
import os
import subprocess
import sys
import tempfile

import numpy

SCANMILL = os.environ["SCANMILL"]
ROOT = os.environ["SCANMILL_ROOT"]


def run(*words, want=0):
    done = subprocess.run([SCANMILL, *map(str, words)], capture_output=True, text=True, timeout=1200)
    text = done.stderr + done.stdout
    assert done.returncode == want, f"exit {done.returncode}, wanted {want}: {words}\n{text}"
    return text


def report(*words):
    """The result line of a command under --json."""
    lines = [json.loads(line) for line in run(*words, "--json").splitlines() if line.startswith("{")]
    return next(line for line in reversed(lines) if line["type"] == "result")


def cloud_of(path):
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + 11
    return numpy.frombuffer(data[end:], numpy.dtype([("p", "<f8", 3), ("view", "<u4"), ("row", "<f8")]))


STATIONS = ["{name: top, joints: {x: 375, y: 250, z: 230, a: 0, b: -90}}",
            "{name: west, joints: {x: 235, y: 250, z: 170, a: 0, b: -45}}",
            "{name: south, joints: {x: 375, y: 110, z: 170, a: 90, b: -45}}"]


def plan_file(path, stations=STATIONS, pixels=(140, 100), change=()):
    """bradley.yaml with these stations and pixels."""
    text = open(f"{ROOT}/jobs/machines/bradley.yaml").read().split("\nstations:")[0]
    for was, now in [("pixels_x: 700", f"pixels_x: {pixels[0]}"), ("pixels_y: 500", f"pixels_y: {pixels[1]}"), *change]:
        assert was in text, was
        text = text.replace(was, now)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as out:
        out.write(text + "\nstations:\n" + "".join(f"  - {line}\n" for line in stations))
    return path


def every_format_holds_the_same_views(work):
    plan = plan_file(f"{work}/p.yaml")
    clouds = {}
    for form in ("ply", "xyz", "ptx", "pcd", "png"):
        run("simulate", plan, "--object", "figurine", "--out", f"{work}/{form}", "--format", form, "--keep-out")
        run("check", f"{work}/{form}/p.yaml")
        run("convert", f"{work}/{form}/p.yaml", f"{work}/{form}.ply")
        points = cloud_of(f"{work}/{form}.ply")["p"]
        clouds[form] = points[numpy.lexsort(points.round(2).T)]
        assert len(points) > 10000
        truth = json.load(open(f"{work}/{form}/p.truth.json"))
        assert sum(v["points"] for v in truth["views"]) == len(points)
        assert sum(v["around"] for v in truth["views"]) > 100  # the fixture
    assert (clouds["pcd"] == clouds["ply"]).all()
    for form, within in (("xyz", 1e-5), ("ptx", 1e-5), ("png", 0.002)):
        order = [numpy.sort(c, axis=0) for c in (clouds[form], clouds["ply"])]
        assert numpy.abs(order[0] - order[1]).max() < within, form


def same_bytes_for_any_threads(work):
    plan = plan_file(f"{work}/p.yaml", pixels=(210, 150))
    more = ["--keep-out", "--outlier-share", "0.01", "--missing-patches", "4", "--projector-mm", "60", "--station-mm", "0.1",
            "--station-deg", "0.05", "--dropout-from-deg", "50", "--noise-by-incidence", "1"]
    for threads in (1, 2, 7):
        run("simulate", plan, "--object", "figurine", "--out", f"{work}/o{threads}", "--threads", threads, *more)
    names = [os.path.relpath(os.path.join(d, f), f"{work}/o1") for d, _, fs in os.walk(f"{work}/o1") for f in fs]
    assert len(names) == 5, names
    for name in names:
        for threads in (2, 7):
            assert open(f"{work}/o{threads}/{name}", "rb").read() == open(f"{work}/o1/{name}", "rb").read(), name
    for view in json.load(open(f"{work}/o1/p.truth.json"))["views"]:
        told, true = (numpy.array(view[k]).reshape(4, 4) for k in ("pose", "true_pose"))
        assert abs(numpy.linalg.norm(true[:3, 3] - told[:3, 3]) - 0.1) < 1e-9
        turn = true[:3, :3].T @ told[:3, :3]
        assert abs(numpy.degrees(numpy.arccos((numpy.trace(turn) - 1) / 2)) - 0.05) < 1e-4
        assert view["outliers"] > 0 and view["missing"] > 0 and view["dropped"] > 0, view


def a_mesh_is_scanned_like_its_solid(work):
    plan = plan_file(f"{work}/p.yaml", change=[("noise_mm: 0.025", "noise_mm: 0")])
    run("simulate", plan, "--object", "figurine", "--out", f"{work}/solid")
    run("mesh", f"{work}/solid/p.yaml", "--bin-mm", "0.5", "-o", f"{work}/m.stl")
    run("simulate", plan, "--object", f"{work}/m.stl", "--out", f"{work}/mesh")
    truth = json.load(open(f"{work}/mesh/p.truth.json"))
    assert len(truth["object_sha256"]) == 64
    clouds = []
    for kind in ("solid", "mesh"):
        run("convert", f"{work}/{kind}/p.yaml", f"{work}/{kind}.ply")
        clouds.append(cloud_of(f"{work}/{kind}.ply"))
    assert 0.95 < len(clouds[1]) / len(clouds[0]) <= 1.01
    # no object of this name, no bodies to be shown, a file without triangles
    assert "did you mean cube" in run("simulate", plan, "--object", "cub", "--out", f"{work}/x", want=2)
    assert "no keep_out" in run("simulate", f"{ROOT}/jobs/machines/fixed.yaml", "--object", "cube", "--keep-out", "--out",
                                f"{work}/x", want=2)
    assert "allowed ply, xyz" in run("simulate", plan, "--object", "cube", "--format", "stl", "--out", f"{work}/x", want=2)


def a_job_takes_what_was_scanned(work):
    """The archive as written is one scan; the truth beside it is none."""
    plan = plan_file(f"{work}/p.yaml")
    run("simulate", plan, "--object", "figurine", "--out", f"{work}/a/one", "--format", "ptx")
    with open(f"{work}/job.yaml", "w") as out:
        out.write("scanmill: 1\narchive: a\nsettle_s: 0\nlattice: {bin_mm: 1.5}\n")
    run("run", f"{work}/job.yaml", "--out", f"{work}/out")
    scans = json.load(open(f"{work}/out/run.json"))["scans"]
    assert [s["name"] for s in scans] == ["one/p"], scans


CASES = {f.__name__: f for f in (every_format_holds_the_same_views, same_bytes_for_any_threads,
                                 a_mesh_is_scanned_like_its_solid, a_job_takes_what_was_scanned)}

if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-scanner-") as folder:
        CASES[sys.argv[1]](folder)
