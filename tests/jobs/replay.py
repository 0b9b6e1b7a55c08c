#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Scan plans as their users run them: check, replay, plan import/export/solve/propose.  usage: replay.py CASE"""
import hashlib
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile

import jsonschema
import numpy

SCANMILL = os.environ["SCANMILL"]
ROOT = os.environ["SCANMILL_ROOT"]
DATA = os.environ.get("SCANMILL_DATA") or f"{ROOT}/../shared/data"
MACHINES = f"{ROOT}/jobs/machines"
SKIP = 77


def run(*words, want=0, cwd=None):
    done = subprocess.run([SCANMILL, *map(str, words)], capture_output=True, text=True, cwd=cwd, timeout=600)
    text = done.stderr + done.stdout
    assert done.returncode == want, f"exit {done.returncode}, wanted {want}: {words}\n{text}"
    return text


def replayed(folder):
    found = json.load(open(f"{folder}/replay.json"))
    jsonschema.validate(found, json.load(open(f"{ROOT}/schemas/replay.schema.json")))
    return found


def cloud_of(path):
    """float64 x y z and view of a PLY that replay or convert wrote."""
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + 11
    row = numpy.dtype([("p", "<f8", 3), ("view", "<u4"), ("row", "<f8")])
    return numpy.frombuffer(data[end:], row)


def bins_of(points, edge):
    return set(map(tuple, numpy.floor(points / edge).astype(numpy.int64)))


def machine_text(name):
    """The file up to its stations."""
    return open(f"{MACHINES}/{name}.yaml").read().split("\nstations:")[0]


def write_plan(path, machine, stations):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as out:
        out.write(machine_text(machine) + "\nstations:\n" + "".join(f"  - {line}\n" for line in stations))


RING = ["{name: top, joints: {x: 375, y: 250, z: 230, a: 0, b: -90}, data: views/top.ply}",
        "{name: west, joints: {x: 235, y: 250, z: 170, a: 0, b: -45}, data: views/west.ply}",
        "{name: south, joints: {x: 375, y: 110, z: 170, a: 90, b: -45}, data: views/south.ply}",
        "{name: east, joints: {x: 515, y: 250, z: 170, a: 180, b: -45}, data: views/east.ply}",
        "{name: north, joints: {x: 375, y: 390, z: 170, a: -90, b: -45}, data: views/north.ply}"]


def scanned(folder, stations=RING, machine="bradley"):
    """An archive with one plan and its views of the figurine."""
    os.makedirs(f"{folder}/making")
    write_plan(f"{folder}/making/head.yaml", machine, stations)
    run("simulate", f"{folder}/making/head.yaml", "--object", "figurine", "--out", f"{folder}/head", "--quiet")
    shutil.rmtree(f"{folder}/making")
    return f"{folder}/head/head.yaml"


def machine_files_check_and_replay(work):
    for name in ("bradley", "turntable", "gantry", "fixed"):
        run("check", f"{MACHINES}/{name}.yaml")
        run("replay", f"{MACHINES}/{name}.yaml", "-o", f"{work}/{name}")
        found = replayed(f"{work}/{name}")
        assert found["totals"]["errors"] == 0 and found["totals"]["warnings"] == 0, found["totals"]
        for picture in ("machine.png", "part.png"):
            assert open(f"{work}/{name}/{picture}", "rb").read(8) == b"\x89PNG\r\n\x1a\n"
        assert len(open(f"{work}/{name}/timeline.tsv").read().splitlines()) == len(found["stations"]) + 1


def replay_is_the_same_for_any_threads(work):
    plan = scanned(f"{work}/a")
    for threads in (1, 2, 7):
        run("replay", plan, "-o", f"{work}/o{threads}", "--threads", threads)
    names = sorted(os.listdir(f"{work}/o1"))
    assert names == ["cloud.ply", "machine.png", "part.png", "replay.json", "timeline.png", "timeline.tsv"], names
    for threads in (2, 7):
        for name in names:
            assert open(f"{work}/o{threads}/{name}", "rb").read() == open(f"{work}/o1/{name}", "rb").read(), name


def replay_places_what_the_virtual_scanner_saw(work):
    plan = scanned(f"{work}/a")
    run("replay", plan, "-o", f"{work}/out")
    found = replayed(f"{work}/out")
    points = cloud_of(f"{work}/out/cloud.ply")["p"]
    assert len(points) == found["totals"]["points"] > 10000
    assert (numpy.abs(points) <= numpy.array([31, 21, 16])).all(), (points.min(0), points.max(0))
    seen = found["totals"]["coverage"]
    assert sum(seen["seen_by"]) == seen["bins"] and seen["median_best_angle_deg"] < 60, seen
    for station in found["stations"]:
        assert station["findings"] == [] and station["coverage"]["bins"] > 100, station
        assert 134.8 < station["depth_mm"][0] < station["depth_mm"][1] < 165.2, station["depth_mm"]


def bradley_count_law(work):
    """One count more on x moves every point by lead / (counts_per_rev gear)."""
    plan = scanned(f"{work}/a", [RING[0]])
    run("replay", plan, "-o", f"{work}/o0", "--no-pictures")
    counts = replayed(f"{work}/o0")["stations"][0]["counts"]
    clouds = []
    for more in (0, 1):
        line = "{name: top, counts: {x: %d, y: %d, z: %d, a: %d, b: %d}, data: views/top.ply}" % (
            counts["x"] + more, counts["y"], counts["z"], counts["a"], counts["b"])
        write_plan(f"{work}/a/head/head.yaml", "bradley", [line])
        run("replay", plan, "-o", f"{work}/o{more}", "--no-pictures")
        clouds.append(cloud_of(f"{work}/o{more}/cloud.ply")["p"])
    moved = clouds[1] - clouds[0]
    assert numpy.abs(moved - [5 / 2000, 0, 0]).max() < 1e-9, numpy.abs(moved).max()
    station = replayed(f"{work}/o1")["stations"][0]
    assert station["counts"]["x"] == counts["x"] + 1 and station["turns"]["x"] == (counts["x"] + 1) / 2000


def broken_plans_are_named(work):
    good = scanned(f"{work}/good")
    base = open(good).read()

    def plan_with(name, stations=None, text=None):
        folder = f"{work}/a/{name}"
        shutil.copytree(f"{work}/good/head", folder)
        if stations:
            write_plan(f"{folder}/head.yaml", "bradley", stations)
        if text:
            open(f"{folder}/head.yaml", "w").write(text)
        return f"{folder}/head.yaml"

    digest = hashlib.sha256(open(f"{work}/good/head/views/east.ply", "rb").read()).hexdigest()
    hashed = RING[:3] + [RING[3].replace("}, data", f"}}, sha256: {digest}, data")] + RING[4:]
    run("check", plan_with("hashed", hashed))
    cases = {
        "limit": (RING[:4] + ["{name: over, joints: {x: 751.5, y: 390, z: 170, a: -90, b: -45}, data: views/north.ply}"],
                  "station over: joint x at 751.5 mm is beyond its limit of 750 mm"),
        "unreachable": (RING[:4] + ["{name: pole, target: {point: [0, 0, 30], normal: [0, 0, 1]}, data: views/north.ply}"],
                        "station pole: unreachable: joint z would have to go to 260 mm, its limit is 240 mm"),
        "above": (RING[:4] + ["{name: sky, pose: {eye: [0, -150, -20], target: [0, 0, 0]}, data: views/north.ply}"],
                  "station sky: unreachable: joint b would have to go to 7.5946 deg, its limit is 0 deg"),
    }
    for name, (stations, wanted) in cases.items():
        plan = plan_with(name, stations)
        for command in (["check", plan], ["replay", plan, "-o", f"{work}/r-{name}"]):
            text = run(*command, want=2)
            assert wanted in text, text
        assert replayed(f"{work}/r-{name}")["totals"]["errors"] == 1

    # the sensor looks up: a joint limit that allows it, and the rule that does not
    up = plan_with("horizon", text=base.replace("limits: [-90, 0]", "limits: [-90, 30]").replace(
        RING[4], "{name: sky, joints: {x: 375, y: 430, z: 40, a: -90, b: 5}, data: views/north.ply}"))
    # a view that another sensor took
    band = plan_with("band", text=base.replace("depth_mm: 15", "depth_mm: 5"))
    missing = plan_with("missing")
    os.remove(f"{work}/a/missing/views/west.ply")
    altered = plan_with("altered", hashed)
    with open(f"{work}/a/altered/views/east.ply", "r+b") as out:
        out.seek(-4, 2)
        out.write(b"\0\0\0\0")
    wants = {"horizon": (up, "station sky: the sensor looks 5 deg above the horizontal; the limit is 0 deg"),
             "band": (band, "points lie outside the sensor's depth band of 145 to 155 mm"),
             "missing": (missing, "station west: the file views/west.ply is not there"),
             "altered": (altered, "station east: the file views/east.ply has SHA-256")}
    for name, (plan, wanted) in wants.items():
        for command in (["check", plan], ["replay", plan, "-o", f"{work}/r-{name}"]):
            text = run(*command, want=2)
            assert wanted in text, f"{name}: {text}"
    # In a job each of these scans fails, the sound ones are made.
    with open(f"{work}/job.yaml", "w") as out:
        out.write("scanmill: 1\narchive: a\nsettle_s: 0\nlattice: {bin_mm: 1.5}\n")
    text = run("run", f"{work}/job.yaml", "--out", f"{work}/out", want=3)
    failed = {s["name"]: s for s in json.load(open(f"{work}/out/run.json"))["scans"]}
    for name in ("limit", "unreachable", "above", "horizon", "band", "missing", "altered"):
        assert not os.path.exists(f"{work}/out/scans/{name}/head/mesh.stl"), name
        assert name + "/head" in text, text
    assert os.path.exists(f"{work}/out/scans/hashed/head/mesh.stl")
    assert "station over: joint x at 751.5 mm" in text and "depth band of 145 to 155 mm" in text, text
    assert len(failed) == 8, failed.keys()


def pose_that_counts_deny_is_reported(work):
    plan = scanned(f"{work}/a")
    text = open(plan).read().replace("{name: top, joints: {x: 375, y: 250, z: 230, a: 0, b: -90}",
                                     "{name: top, counts: {x: 150000, y: 100000, z: -4000, a: 0, b: -9000}, "
                                     "pose: {eye: [0.5, 0, 150], target: [0.5, 0, 0], up: [1, 0, 0]}")
    open(plan, "w").write(text)
    wanted = "station top: the pose given lies 0.5 mm and"
    assert wanted in run("check", plan)
    assert wanted in run("replay", plan, "-o", f"{work}/out")
    top = replayed(f"{work}/out")["stations"][0]
    assert top["findings"][0]["kind"] == "pose_differs" and abs(top["pose"][3]) < 1e-9, top  # placed by the counts


def poses_solve_counts_replay(work):
    """Poses of a replay, solved again, come back within half a count."""
    plan = scanned(f"{work}/a")
    run("replay", plan, "-o", f"{work}/o1", "--no-pictures", "--no-cloud")
    first = replayed(f"{work}/o1")["stations"]
    lines = ["{name: %s, pose: {matrix: %s}}" % (s["name"], json.dumps(s["pose"])) for s in first]
    write_plan(f"{work}/wanted.yaml", "bradley", lines)
    text = run("plan", "solve", f"{work}/wanted.yaml", "-o", f"{work}/solved.yaml")
    assert "turns" in text, text
    run("replay", f"{work}/solved.yaml", "-o", f"{work}/o2", "--no-pictures")
    for a, b in zip(first, replayed(f"{work}/o2")["stations"]):
        for joint in "xyz":
            assert a["counts"][joint] == b["counts"][joint], (a["name"], joint)
        assert a["counts"]["b"] == b["counts"]["b"]
        assert numpy.abs(numpy.array(a["pose"]) - b["pose"]).max() < 1e-6, a["name"]
    lines.append("{name: far, pose: {eye: [900, 0, 0], target: [0, 0, 0]}}")
    write_plan(f"{work}/wanted.yaml", "bradley", lines)
    text = run("plan", "solve", f"{work}/wanted.yaml", "-o", f"{work}/no.yaml", want=2)
    assert "station far: unreachable: joint x would have to go to 1315 mm, its limit is 750 mm" in text, text
    assert not os.path.exists(f"{work}/no.yaml")


def bunny_comes_back(work):
    source = f"{DATA}/range-views/bunny"
    if not os.path.isdir(source):
        sys.exit(SKIP)
    os.makedirs(f"{work}/a")
    for name in os.listdir(source):
        if not name.startswith("bun_zipper"):
            shutil.copy(f"{source}/{name}", f"{work}/a/{name}")
    text = run("plan", "import", f"{work}/a/bun.conf", "-o", f"{work}/a/bunny.yaml", "--hash")
    assert "units: m is a guess" in text, text
    run("replay", f"{work}/a/bunny.yaml", "-o", f"{work}/out", "--bin-mm", "1")
    found = replayed(f"{work}/out")
    poses = {}
    for line in open(f"{work}/a/bun.conf"):
        words = line.split()
        if words and words[0] == "bmesh":
            t, (x, y, z, w) = numpy.array(words[2:5], float), map(float, words[5:9])
            n = math.sqrt(x * x + y * y + z * z + w * w)
            x, y, z, w = x / n, y / n, z / n, w / n
            r = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]).T
            poses[words[1]] = (r, 1000 * t)
    assert len(found["stations"]) == len(poses) == 10
    for station in found["stations"]:
        m = numpy.array(station["pose"]).reshape(4, 4)
        r, t = poses[station["data"]]
        assert numpy.abs(m[:3, :3] - r).max() < 1e-6, station["name"]
        assert numpy.abs(m[:3, 3] - t).max() <= 1e-6 * max(1, numpy.abs(t).max()), station["name"]
    # the same bins as the .conf by itself, and the overlap that the right rule gives
    run("convert", f"{work}/a/bun.conf", f"{work}/conf.ply", "--units", "m")
    both = cloud_of(f"{work}/out/cloud.ply"), cloud_of(f"{work}/conf.ply")
    assert bins_of(both[0]["p"], 1.0) == bins_of(both[1]["p"], 1.0)
    best = sorted(s["coverage"]["best_overlap"] for s in found["stations"])
    median = (best[4] + best[5]) / 2
    assert abs(median - 0.59) < 0.02 and abs(best[0] - 0.44) < 0.02, best
    # the plain quaternion, not its conjugate, loses clearly
    wrong = open(f"{work}/a/bun.conf").read().splitlines()
    with open(f"{work}/a/wrong.conf", "w") as out:
        for line in wrong:
            words = line.split()
            if words and words[0] == "bmesh":
                words[8] = str(-float(words[8]))
            out.write(" ".join(words) + "\n")
    run("plan", "import", f"{work}/a/wrong.conf", "--units", "m", "-o", f"{work}/a/wrong.yaml")
    run("replay", f"{work}/a/wrong.yaml", "-o", f"{work}/wrong", "--bin-mm", "1", "--no-cloud", "--no-pictures")
    worse = sorted(s["coverage"].get("best_overlap", 0) for s in replayed(f"{work}/wrong")["stations"])
    assert (worse[4] + worse[5]) / 2 < 0.1, worse
    # out again as every pose format, and in again
    for form, name in (("conf", "again.conf"), ("aln", "again.aln"), ("log", "again.log"), ("xf", "again.xf")):
        run("plan", "export", f"{work}/a/bunny.yaml", "--as", form, "-o", f"{work}/a/{name}")
        if form in ("log", "xf"):
            os.makedirs(f"{work}/b", exist_ok=True)
            for n, station in enumerate(found["stations"]):
                shutil.copy(f"{work}/a/{station['data']}", f"{work}/b/v{n:02d}.ply")
            shutil.copy(f"{work}/a/{name}", f"{work}/b/{name}")
            run("plan", "import", f"{work}/b/{name}", "--files", "v*.ply", "--units", "m", "-o", f"{work}/b/{form}.yaml")
            plan = f"{work}/b/{form}.yaml"
        else:
            run("plan", "import", f"{work}/a/{name}", "--units", "m", "-o", f"{work}/a/{form}.yaml")
            plan = f"{work}/a/{form}.yaml"
        run("replay", plan, "-o", f"{work}/again", "--bin-mm", "1", "--no-cloud", "--no-pictures")
        for a, b in zip(found["stations"], replayed(f"{work}/again")["stations"]):
            assert numpy.abs(numpy.array(a["pose"]) - b["pose"]).max() < 1e-9, (form, a["name"])


def living_room_comes_back(work):
    source = f"{DATA}/range-views/livingroom-depth"
    if not os.path.isdir(source):
        sys.exit(SKIP)
    os.makedirs(f"{work}/a/depth")
    for n in range(211):
        os.symlink(os.path.realpath(f"{source}/{n:05d}.png"), f"{work}/a/depth/{n:05d}.png")
    shutil.copy(f"{source}/trajectory.log", f"{work}/a/trajectory.log")
    rows = open(f"{source}/trajectory.log").read().split("\n")
    run("plan", "import", f"{work}/a/trajectory.log", "-o", f"{work}/a/room.yaml", "--units", "m", "--every", "60",
        "--intrinsics", "525,525,319.5,239.5", "--depth-scale", "1000", "--files", "depth/*.png", want=2)
    # list_files follows no link out of the folder: copies are needed
    for n in range(211):
        os.remove(f"{work}/a/depth/{n:05d}.png")
        shutil.copy(f"{source}/{n:05d}.png", f"{work}/a/depth/{n:05d}.png")
    run("plan", "import", f"{work}/a/trajectory.log", "-o", f"{work}/a/room.yaml", "--units", "m", "--every", "60",
        "--intrinsics", "525,525,319.5,239.5", "--depth-scale", "1000", "--files", "depth/*.png")
    run("replay", f"{work}/a/room.yaml", "-o", f"{work}/out", "--bin-mm", "20")
    found = replayed(f"{work}/out")
    assert [s["name"] for s in found["stations"]] == ["00000", "00060", "00120", "00180"]
    for k, station in enumerate(found["stations"]):
        wanted = numpy.array(" ".join(rows[5 * 60 * k + 1:5 * 60 * k + 5]).split(), float).reshape(4, 4)
        wanted[:3, 3] *= 1000
        got = numpy.array(station["pose"]).reshape(4, 4)
        assert numpy.abs(got - wanted).max() <= 1e-6 * max(1, numpy.abs(wanted).max()), station["name"]
    cloud = cloud_of(f"{work}/out/cloud.ply")
    bins = [bins_of(cloud["p"][cloud["view"] == v], 20.0) for v in range(4)]
    share = [len(a & b) / min(len(a), len(b)) for a, b in zip(bins, bins[1:])]
    assert abs(share[0] - 0.44) < 0.03 and abs(share[1] - 0.59) < 0.03, share
    with open(f"{work}/job.yaml", "w") as out:
        out.write("scanmill: 1\narchive: a\nsettle_s: 0\nlattice: {bin_mm: 50}\noutputs: [stl]\n")
    assert "room" in run("run", f"{work}/job.yaml", "--out", f"{work}/jobout", "--only", "room")


def matrix_and_ptx_poses_come_in(work):
    pair, ptx = f"{DATA}/range-views/pair-small-gicp", f"{DATA}/formats/ptx/complex-transform.ptx"
    if not os.path.isdir(pair) or not os.path.exists(ptx):
        sys.exit(SKIP)
    matrix = numpy.loadtxt(f"{pair}/T_target_source.txt")
    shares = {}
    for rule, pose in (("right", matrix), ("none", numpy.eye(4)), ("inverse", numpy.linalg.inv(matrix))):
        folder = f"{work}/{rule}"
        os.makedirs(folder)
        for name in ("source.ply", "target.ply"):
            shutil.copy(f"{pair}/{name}", f"{folder}/{name}")
        numpy.savetxt(f"{folder}/poses.txt", numpy.vstack([pose, numpy.eye(4)]), fmt="%.12g")
        run("plan", "import", f"{folder}/poses.txt", "--files", "*e*.ply", "--units", "m", "-o", f"{folder}/plan.yaml")
        run("replay", f"{folder}/plan.yaml", "-o", f"{folder}/out", "--bin-mm", "200", "--no-cloud", "--no-pictures")
        shares[rule] = replayed(f"{folder}/out")["stations"][0]["coverage"].get("best_overlap", 0)
    assert abs(shares["right"] - 0.51) < 0.03 and abs(shares["none"] - 0.32) < 0.03 and shares["inverse"] < shares["none"], shares
    # a PTX brings its own matrix: replay and convert agree
    shutil.copy(ptx, f"{work}/scan.ptx")
    run("plan", "import", f"{work}/scan.ptx", "--units", "m", "-o", f"{work}/ptx.yaml")
    run("replay", f"{work}/ptx.yaml", "-o", f"{work}/ptx", "--bin-mm", "10", "--no-pictures")
    run("convert", f"{work}/scan.ptx", f"{work}/ptx.ply", "--units", "m")
    assert (cloud_of(f"{work}/ptx/cloud.ply")["p"] == cloud_of(f"{work}/ptx.ply")["p"]).all()


def linuxcnc_limits_come_in(work):
    with open(f"{work}/mill.ini", "w") as out:
        out.write("[EMC]\nMACHINE = bench mill ; a comment\n[KINS]\nKINEMATICS = trivkins coordinates=XYZA\n[TRAJ]\n"
                  "COORDINATES = X Y Z A\nLINEAR_UNITS = inch\n[JOINT_0]\nTYPE = LINEAR\nMIN_LIMIT = -0.1\nMAX_LIMIT = 20\n"
                  "MAX_VELOCITY = 2\nMAX_ACCELERATION = 10\nBACKLASH = 0.001\nSCALE = 4000\n[JOINT_1]\nMIN_LIMIT = 0\n"
                  "MAX_LIMIT = 10\nMAX_VELOCITY = 2\nINPUT_SCALE = 8000\n[JOINT_2]\nMIN_LIMIT = -5\nMAX_LIMIT = 0\n[JOINT_3]\n"
                  "TYPE = ANGULAR\nMIN_LIMIT = -180\nMAX_LIMIT = 180\nSCALE = 100\n")
    text = run("plan", "import", f"{work}/mill.ini", "-o", f"{work}/mill.yaml")
    assert "carries: part" in text, text
    run("check", f"{work}/mill.yaml")
    plan = open(f"{work}/mill.yaml").read().replace("stations: []", "stations:\n  - {name: a, joints: {x: 254, y: 25.4, z: 0, a: 36}}\n"
                                                    "  - {name: b, joints: {x: 600, y: 25.4, z: 0, a: 36}}")
    open(f"{work}/mill.yaml", "w").write(plan)
    text = run("replay", f"{work}/mill.yaml", "-o", f"{work}/out", "--no-pictures", want=2)
    assert "station b: joint x at 600" in text and "limit of 508 mm" in text, text
    a = replayed(f"{work}/out")["stations"][0]
    assert a["counts"]["x"] == 40000 and a["counts"]["y"] == 8000 and a["counts"]["a"] == 3600, a["counts"]
    open(f"{work}/bad.ini", "w").write("[JOINT_0]\nMIN_LIMIT = low\n")
    assert "bad.ini:2: MIN_LIMIT: found \"low\", wanted a number" in run("plan", "import", f"{work}/bad.ini", want=3)


def gcode_goes_out(work):
    run("plan", "export", f"{MACHINES}/bradley.yaml", "--as", "gcode", "-o", f"{work}/scan.ngc")
    lines = open(f"{work}/scan.ngc").read().splitlines()
    assert "G21 ; mm" in lines and "G90 ; absolute" in lines and lines[-1] == "M2"
    moves = [line for line in lines if line.startswith("G0")]
    assert moves[0] == "G0 X375 Y250 Z240 A0 B-90 ; station above" and len(moves) == 6, moves
    event = json.loads(run("plan", "export", f"{MACHINES}/bradley.yaml", "--json").splitlines()[0])
    assert event["values"]["text"].splitlines() == lines, event
    assert "allowed gcode, conf, aln, log, xf, 3dtk; nearest gcode" in run(
        "plan", "export", f"{MACHINES}/bradley.yaml", "--as", "gcod", want=2)


def poses_of_3dtk_come_back(work):
    """Left-handed frames: points and poses in, right-handed cloud out, and the same numbers out again."""
    rng = numpy.random.default_rng(3)
    part = rng.uniform(-50, 50, (4000, 3))  # right-handed truth
    os.makedirs(f"{work}/a")
    mirror = numpy.diag([1.0, 1, -1])
    for n in range(3):
        angles, t = rng.uniform(-170, 170, 3), rng.uniform(-100, 100, 3)
        angles[1] = rng.uniform(-80, 80)
        cx, cy, cz = numpy.cos(numpy.radians(angles))
        sx, sy, sz = numpy.sin(numpy.radians(angles))
        turn = (numpy.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]]) @ numpy.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
                @ numpy.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]))
        seen = (part @ mirror - t) @ turn  # inverse of turn p + t, in 3DTK's frame
        numpy.savetxt(f"{work}/a/scan{n:03d}.xyz", seen, fmt="%.9f")
        open(f"{work}/a/scan{n:03d}.pose", "w").write(
            "%.12g %.12g %.12g\n%.12g %.12g %.12g\n" % (*t, *angles))
    poses = [f"{work}/a/scan{n:03d}.pose" for n in range(3)]
    run("plan", "import", *poses, "--units", "mm", "-o", f"{work}/a/plan.yaml")
    run("replay", f"{work}/a/plan.yaml", "-o", f"{work}/out", "--bin-mm", "5")
    cloud = cloud_of(f"{work}/out/cloud.ply")
    for view in range(3):
        assert numpy.abs(cloud["p"][cloud["view"] == view] - part).max() < 1e-6, view
    # a record of such a scan leads back to the rows as they stand in the files
    with open(f"{work}/job.yaml", "w") as out:
        out.write("scanmill: 1\narchive: a\nsettle_s: 0\nlattice: {bin_mm: 20}\n")
    run("run", f"{work}/job.yaml", "--out", f"{work}/jobout")
    subprocess.run([sys.executable, f"{ROOT}/tests/provenance/check_record.py", f"{work}/jobout/scans/plan/record.h5",
                    "--archive", f"{work}/a"], check=True, stdout=subprocess.DEVNULL)
    run("plan", "export", f"{work}/a/plan.yaml", "--as", "3dtk", "-o", f"{work}/back")
    for n in range(3):
        was, now = (numpy.array(open(p).read().split(), float) for p in (poses[n], f"{work}/back/scan{n:03d}.pose"))
        assert numpy.abs(was - now).max() < 1e-6, (was, now)


def propose_covers_with_few_stations(work):
    """Coverage of the proposal against rings of the same machine, judged by replay of what the scanner then saw."""
    for name in ("figurine", "handset"):
        demo = f"{ROOT}/jobs/demo/{name}.plan.yaml"
        run("simulate", demo, "--object", name, "--out", f"{work}/{name}", "--quiet")
        run("mesh", f"{work}/{name}/{name}.plan.yaml", "--bin-mm", "1.5", "-o", f"{work}/{name}.stl")
        text = run("plan", "propose", f"{MACHINES}/gantry.yaml", "--object", f"{work}/{name}.stl", "-o", f"{work}/{name}-plan.yaml")
        print(text)
        words = dict(line.split(None, 1) for line in text.splitlines() if len(line.split(None, 1)) == 2)
        assert float(words["covered_percent"]) >= 99, text
        run("check", f"{work}/{name}-plan.yaml")


CASES = {f.__name__: f for f in (machine_files_check_and_replay, replay_is_the_same_for_any_threads,
                                 replay_places_what_the_virtual_scanner_saw, bradley_count_law, broken_plans_are_named,
                                 pose_that_counts_deny_is_reported, poses_solve_counts_replay, bunny_comes_back,
                                 living_room_comes_back, matrix_and_ptx_poses_come_in, linuxcnc_limits_come_in, gcode_goes_out, poses_of_3dtk_come_back,
                                 propose_covers_with_few_stations)}

if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-plans-") as folder:
        CASES[sys.argv[1]](folder)
