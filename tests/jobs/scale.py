#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The bench of scale: its clouds, its runs, its words.  usage: scale.py CASE"""
import hashlib
import json
import os
import subprocess

import jsonschema
import numpy

from cases import run_case
from end_to_end import ROOT, SCANMILL, read_view, run


def the_same_cloud_every_time(work):
    for threads in (1, 2, 7):
        run("bench", "scale", "--generate", f"{work}/{threads}.ply", "--points", "1e5", "--threads", threads)
    digests = {hashlib.sha256(open(f"{work}/{threads}.ply", "rb").read()).hexdigest() for threads in (1, 2, 7)}
    assert digests == {"2d5c1266c85690eede244b4c2cfb5d7b19048f002969d68090f637f70dd38931"}, digests
    run("bench", "scale", "--generate", f"{work}/other.ply", "--points", "1e5", "--seed", 2)
    _, one = read_view(f"{work}/1.ply")
    _, other = read_view(f"{work}/other.ply")
    assert one.shape == (100000, 3) and other.shape == one.shape and not numpy.array_equal(one, other)
    # 40 points on a square millimetre: the number sets the size.
    radius = numpy.sqrt(1e5 / 40 / 4 / numpy.pi)
    distance = numpy.linalg.norm(one.astype(float), axis=1)
    assert 0.97 * radius - 0.1 < distance.min() and distance.max() < 1.03 * radius + 0.1
    assert abs(numpy.linalg.norm(one - other, axis=1).std()) < 0.03  # the seed moves the noise alone


def views_hold_the_cloud(work):
    told = json.loads(run("bench", "scale", "--generate", f"{work}/one.ply", "--points", "54321", "--json").splitlines()[-1])
    run("bench", "scale", "--generate", f"{work}/views", "--points", "54321")
    names = sorted(os.listdir(f"{work}/views"))
    assert len(names) == told["values"]["views"], names
    together = b"".join(read_view(f"{work}/views/{name}")[1].tobytes() for name in names)
    assert together == read_view(f"{work}/one.ply")[1].tobytes()
    assert os.path.getsize(f"{work}/one.ply") == told["values"]["bytes"]


def whole_jobs_are_measured(work):
    text = run("bench", "scale", "--points", "1e5,2e4", "--threads", "1,2", "--out", f"{work}/o", "--memory", "1G", "--keep")
    assert "points per CPU s" in text, text
    report = json.load(open(f"{work}/o/scale.json"))
    schema = json.load(open(f"{ROOT}/schemas/scale.schema.json"))
    jsonschema.Draft7Validator.check_schema(schema)
    jsonschema.validate(report, schema)
    assert [(r["points"], r["threads"]) for r in report["runs"]] == [(20000, 1), (20000, 2), (100000, 1), (100000, 2)]
    for row in report["runs"]:
        assert row["kept"] > row["points"] / 100 and row["triangles"] > row["kept"], row
        assert 30 < row["points"] / row["bins"] < 90, row
        assert row["cpu_s"] > 0 and 1 << 20 < row["peak_bytes"] <= row["peak_resident_bytes"] < 1 << 30, row
        stages = {stage["name"]: stage for stage in row["stages"]}
        assert {"reduce", "stars", "optimise", "verify", "export"} <= set(stages), stages
        assert stages["reduce"]["amount"] == row["points"] and stages["stars"]["amount"] == row["kept"]
        assert sum(stage["wall_s"]["median"] for stage in row["stages"]) <= row["wall_s"]
    assert open(f"{work}/o/scale.png", "rb").read(8) == b"\x89PNG\r\n\x1a\n"
    one, two = (open(f"{work}/o/points-100000/out-{t}/scans/cloud/mesh.stl", "rb").read() for t in (1, 2))
    assert one == two
    # The ball is closed, and so is its mesh.
    told = json.loads(run("info", f"{work}/o/points-100000/out-1/scans/cloud/mesh.stl", "--json").splitlines()[-1])["values"]
    assert '"boundary_loops": 0' in json.dumps(told) or told.get("boundary_loops") == 0, told
    # Without --keep and --out nothing stays; views in place of one file.
    before = set(os.listdir(work))
    lines = run("bench", "scale", "--points", "2e4", "--threads", "1", "--views", "--json").splitlines()
    values = [json.loads(line) for line in lines if '"report"' in line][-1]["values"]
    jsonschema.validate(values, schema)
    assert values["input"]["files"] == "views" and set(os.listdir(work)) == before


def bricks_make_the_same_mesh(work):
    text = run("bench", "scale", "--points", "1e5", "--bricks", "32,0", "--threads", "2", "--out", f"{work}/o", "--keep")
    report = json.load(open(f"{work}/o/scale.json"))
    jsonschema.validate(report, json.load(open(f"{ROOT}/schemas/scale.schema.json")))
    whole, cut = report["runs"]
    assert (whole["bricks"], cut["bricks"]) == (0, 32), report
    # Of a cut scan run.json times the last task alone.
    assert whole["stages"] and "stages" not in cut, cut
    assert cut["cpu_s"] > 0 and cut["wall_s"] > 0 and cut["peak_bytes"] > 1 << 20, cut
    stages = [line.split() for line in text.splitlines() if line.startswith(("reduce, points", "stars, kept points"))]
    assert len(stages) == 2 and all(words[-1] == "-" and words[-2] != "-" for words in stages), text
    table = [line.split() for line in text.splitlines() if line.startswith("100,000 ")]
    assert [words[:3] for words in table] == [["100,000", "-", "2"], ["100,000", "32", "2"]], text
    # It was cut indeed, and the bytes are those of one piece.
    folder = f"{work}/o/points-100000"
    one, many = (json.load(open(f"{folder}/{tree}/run.json")) for tree in ("out-2", "out-2-bricks-32"))
    assert set(many["job"]["set"]) == {"brick.edge_bins=32", "brick.pieces=4", "brick.batches=8"} and not one["job"].get("set"), many
    assert "join" in many["scans"][0]["stage_seconds"] and "join" not in one["scans"][0]["stage_seconds"], many
    trees = [open(f"{folder}/{tree}/scans/cloud/mesh.stl", "rb").read() for tree in ("out-2", "out-2-bricks-32")]
    assert trees[0] == trees[1]
    assert {hashlib.sha256(stl).hexdigest() for stl in trees} == {whole["stl_sha256"], cut["stl_sha256"]}


def a_run_that_fails_says_why(work):
    failed = subprocess.run([SCANMILL, "bench", "scale", "--points", "1e4", "--threads", "2", "--bricks", "64", "--memory", "64M"],
                            capture_output=True, text=True)
    assert failed.returncode == 3, failed
    assert "10,000 points with 2 threads in bricks of 64 bins ends with exit code 2: memory cap: found 64 MiB;" in failed.stderr, failed
    assert "{" not in failed.stderr and len(failed.stderr.splitlines()) == 1, failed


def wrong_words_are_refused(work):
    for words, wanted in (
        (("scale", "--points", "1e3,many"), "found 'many'"),
        (("scale", "--points", "10"), "1000 to 1e12"),
        (("scale", "--generate", f"{work}/x.ply"), "makes one cloud"),
        (("scale", "--keep"), "--out"),
        (("scale", "--file", "x.ply"), "makes its clouds itself"),
        (("scale", "--bricks", "0,7"), "--bricks"),
        (("reduce", "--bricks", "64"), "belongs to bench scale"),
        (("reduce", "--points", "1e5"), "belongs to bench scale"),
        (("reduce", "--threads", "1,2"), "belongs to bench scale"),
        (("scale", "--generate", f"{work}/x.ply", "--points", "1e12"), "the disk has"),
    ):
        text = run("bench", *words, want=2)
        assert wanted in text, (words, text)
    failed = subprocess.run([SCANMILL, "bench", "scale", "--points", "1e3", "--memory", "1M"], capture_output=True, text=True)
    assert failed.returncode == 2 and "memory cap" in failed.stderr, failed
    assert os.listdir(work) == [], os.listdir(work)


run_case([the_same_cloud_every_time, views_hold_the_cloud, whole_jobs_are_measured, bricks_make_the_same_mesh,
          a_run_that_fails_says_why, wrong_words_are_refused])
