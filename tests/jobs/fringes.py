#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fringe pictures to phases to ranges to a mesh.  usage: fringes.py CASE"""
import json
import os
import shutil
import sys
import tempfile

import jsonschema
import numpy

from closed_loop import made, twenty_stations
from virtual_scanner import ROOT, cloud_of, plan_file, run


def pictures_to_mesh(work):
    """Twenty stations of the paper's mill, every view 24 pictures of the object and 12 of the plate."""
    plan = plan_file(f"{work}/making/mill.yaml", twenty_stations(), (350, 250))
    run("simulate", plan, "--object", "figurine", "--out", f"{work}/free", "--format", "fringes")
    files = os.listdir(f"{work}/free/views")
    assert len([f for f in files if f.endswith(".png")]) == 21 * 12 and len([f for f in files if f.endswith(".fringes")]) == 20
    run("check", f"{work}/free/mill.yaml")
    _, error = made(work, "free", 1.0)
    print(error)
    assert error["rms_mm"] <= 0.05 and error["max_mm"] < 1, error
    shutil.rmtree(f"{work}/free.out")
    # A picture that was exchanged is named.
    shutil.copy(f"{work}/free/views/mid-1.g1.s1.png", f"{work}/free/views/mid-1.g1.s2.png")
    text = run("replay", f"{work}/free/mill.yaml", "-o", f"{work}/r", "--no-pictures", want=2)
    assert "the picture mid-1.g1.s2.png has SHA-256" in text, text


def maps_are_written(work):
    plan = plan_file(f"{work}/p.yaml", ["{name: top, joints: {x: 375, y: 250, z: 240, a: 0, b: -90}}"], (350, 250))
    for bits in (8, 16):
        run("simulate", plan, "--object", "figurine", "--out", f"{work}/a{bits}", "--format", "fringes", "--fringe-bits", bits)
        text = run("fringes", f"{work}/a{bits}/views/top.fringes", "-o", f"{work}/maps{bits}")
        print(text)
        assert sorted(os.listdir(f"{work}/maps{bits}")) == ["quality.png", "range.ply", "range.png", "unwrapped.png", "wrapped.png"]
    truth = json.load(open(f"{work}/a8/p.truth.json"))
    jsonschema.validate(truth, json.load(open(f"{ROOT}/schemas/truth.schema.json")))
    assert truth["views"][0]["pictures"] == 12
    run("convert", f"{work}/a8/p.yaml", f"{work}/pictures.ply")
    run("simulate", plan, "--object", "figurine", "--out", f"{work}/points")
    run("convert", f"{work}/points/p.yaml", f"{work}/points.ply")
    clouds = [cloud_of(f"{work}/{name}.ply")["p"] for name in ("pictures", "points")]
    assert 0.7 < len(clouds[0]) / len(clouds[1]) <= 1.1, [len(c) for c in clouds]
    text = open(f"{work}/a8/views/top.fringes").read()
    for was, now, wanted in (("baseline_mm: 60", "baseline_mm: 0", "baseline_mm is 0"),
                             ("period_mm: 16", "period_mm: 4", "the depth band needs at least 13.3"),
                             ("gratings:", "grating:", "unknown key"), ("top.g1.s1.png", "gone.png", "gone.png")):
        open(f"{work}/a8/views/bad.fringes", "w").write(text.replace(was, now))
        assert wanted in run("fringes", f"{work}/a8/views/bad.fringes", "-o", f"{work}/x", want=3), wanted


def one_grating_is_enough_for_a_smooth_part(work):
    plan = plan_file(f"{work}/p.yaml", ["{name: top, joints: {x: 375, y: 250, z: 240, a: 0, b: -90}}"], (350, 350),
                     [("noise_mm: 0.025", "noise_mm: 0")])
    run("simulate", plan, "--object", "cube", "--out", f"{work}/one", "--format", "fringes", "--fringe-periods", "0.5")
    text = run("fringes", f"{work}/one/views/top.fringes", "-o", f"{work}/maps")
    assert "regions" in text, text
    run("convert", f"{work}/one/p.yaml", f"{work}/one.ply")
    top = cloud_of(f"{work}/one.ply")["p"]
    assert len(top) > 30000 and numpy.abs(top[:, 2] - top[:, 2].mean()).max() < 0.05, (len(top), top.min(0), top.max(0))


CASES = {f.__name__: f for f in (pictures_to_mesh, maps_are_written, one_grating_is_enough_for_a_smooth_part)}

if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-fringes-") as folder:
        CASES[sys.argv[1]](folder)
