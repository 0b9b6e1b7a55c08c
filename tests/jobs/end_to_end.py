#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the program on small archives and looks at what it left behind.  usage: end_to_end.py CASE"""
import json
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile

import h5py
import numpy

SCANMILL = os.environ["SCANMILL"]
ROOT = os.environ["SCANMILL_ROOT"]

PLAN = """scanmill_plan: 1
name: {name}
units: mm
sensor: {{pixels_x: 160, pixels_y: 160, field_x_mm: 60, field_y_mm: 60, stand_off_mm: 150, depth_mm: 30, noise_mm: 0.03,
  max_incidence_deg: 75, perspective: true}}
stations:
"""
EYES = [(150, 0, 0), (-150, 0, 0), (0, 150, 0), (0, -150, 0), (0, 0, 150), (0, 0, -150)]


def run(*words, want=0, cwd=None, timeout=300):
    done = subprocess.run([SCANMILL, *map(str, words)], capture_output=True, text=True, cwd=cwd, timeout=timeout)
    text = done.stderr + done.stdout
    assert done.returncode == want, f"exit {done.returncode}, wanted {want}: {words}\n{text}"
    return text


def make_archive(folder, objects=("sphere",)):
    for name in objects:
        os.makedirs(f"{folder}/{name}")
        plan = f"{folder}/{name}.making"
        with open(plan, "w") as out:
            out.write(PLAN.format(name=name))
            for n, eye in enumerate(EYES):
                up = (0, 0, 1) if eye[2] == 0 else (0, 1, 0)
                out.write(f"  - name: s{n}\n    pose: {{eye: {list(eye)}, target: [0, 0, 0], up: {list(up)}}}\n    data: s{n}.ply\n")
        os.rename(plan, f"{folder}/{name}/plan.yaml")
        run("simulate", f"{folder}/{name}/plan.yaml", "--object", name, "--out", f"{folder}/{name}", "--quiet")


def write_job(path, archive, text="lattice: {bin_mm: 1.5}\n"):
    with open(path, "w") as out:
        out.write(f"scanmill: 1\narchive: {archive}\nsettle_s: 0\n{text}")
    return path


def results(tree):
    """Relative path -> bytes of every mesh and record."""
    found = {}
    for folder, _, files in os.walk(f"{tree}/scans"):
        for name in files:
            if name in ("mesh.stl", "record.h5"):
                path = os.path.join(folder, name)
                found[os.path.relpath(path, tree)] = open(path, "rb").read()
    return found


def no_leftovers(tree):
    for folder, folders, files in os.walk(tree):
        for name in folders + files:
            assert ".tmp" not in name and not (folder.endswith("scans") and name.startswith(".")), f"left behind: {folder}/{name}"


def read_view(path):
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + 11
    return data[:end], numpy.frombuffer(data[end:], "<f4").reshape(-1, 3)


def same_bytes_for_any_threads(work):
    make_archive(f"{work}/a", ("sphere", "cube"))
    job = write_job(f"{work}/job.yaml", "a")
    for threads in (1, 2, 7):
        run("run", job, "--out", f"{work}/o{threads}", "--threads", threads)
    one = results(f"{work}/o1")
    assert len(one) == 4, sorted(one)
    for threads in (2, 7):
        other = results(f"{work}/o{threads}")
        assert sorted(other) == sorted(one)
        for path in one:
            assert other[path] == one[path], f"{path} differs for {threads} threads"
    no_leftovers(f"{work}/o1")


def same_bytes_for_any_order_of_files(work):
    make_archive(f"{work}/a")
    os.makedirs(f"{work}/b/sphere")
    for name in sorted(os.listdir(f"{work}/a/sphere"), reverse=True):
        shutil.copy(f"{work}/a/sphere/{name}", f"{work}/b/sphere/{name}")
    run("run", write_job(f"{work}/a.yaml", "a"), "--out", f"{work}/oa")
    run("run", write_job(f"{work}/b.yaml", "b"), "--out", f"{work}/ob")
    assert results(f"{work}/oa") == results(f"{work}/ob")


def shuffled_rows_change_sources_only(work):
    make_archive(f"{work}/a")
    shutil.copytree(f"{work}/a", f"{work}/b")
    order = numpy.random.default_rng(5)
    for name in sorted(os.listdir(f"{work}/b/sphere")):
        if name.endswith(".ply"):
            header, points = read_view(f"{work}/b/sphere/{name}")
            with open(f"{work}/b/sphere/{name}", "wb") as out:
                out.write(header + points[order.permutation(len(points))].tobytes())
    run("run", write_job(f"{work}/a.yaml", "a"), "--out", f"{work}/oa")
    run("run", write_job(f"{work}/b.yaml", "b"), "--out", f"{work}/ob")
    one, other = results(f"{work}/oa"), results(f"{work}/ob")
    for path in one:
        if path.endswith(".stl"):
            assert one[path] == other[path], path
    record = [p for p in one if p.endswith(".h5")][0]
    with h5py.File(f"{work}/oa/{record}") as a, h5py.File(f"{work}/ob/{record}") as b:
        names, different = [], []
        a.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        for name in names:
            if not numpy.array_equal(a[name][()], b[name][()]):
                different.append(name)
        allowed = [n for n in different if n.startswith("inputs") or n.endswith(("source_row", "worst_source"))]
        assert different == allowed, different
        assert "reduced/source_row" in different and len(names) > 20, (different, len(names))


def record_rebuilds_stl_and_finds_sources(work):
    make_archive(f"{work}/a", ("torus",))
    os.makedirs(f"{work}/a/text")
    _, points = read_view(f"{work}/a/torus/s0.ply")
    with open(f"{work}/a/text/view.xyz", "w") as out:
        out.write("# one view as text\nx y z\n")
        out.writelines("%.9g %.9g %.9g\n" % tuple(p) for p in points)
    run("run", write_job(f"{work}/job.yaml", "a"), "--out", f"{work}/o")
    for scan in ("torus/plan", "text/view"):
        folder = f"{work}/o/scans/{scan}"
        subprocess.run([sys.executable, f"{ROOT}/tests/provenance/check_record.py", f"{folder}/record.h5", "--stl",
                        f"{folder}/mesh.stl", "--archive", f"{work}/a"], check=True)


def bad_files_are_named_and_the_others_go_on(work):
    make_archive(f"{work}/a")
    header, points = read_view(f"{work}/a/sphere/s0.ply")
    bad = {
        "empty.ply": b"",
        "cut.ply": header + points.tobytes()[:5000],
        "lying.ply": header.replace(b"element vertex %d" % len(points), b"element vertex 99999999999") + points.tobytes(),
        "nan.ply": header + numpy.full_like(points, numpy.nan).tobytes(),
        "garbage.xyz": b"1 2 3\n4 five 6\n",
        "short.xyz": b"1 2 3\n4 5\n",
    }
    for name, data in bad.items():
        open(f"{work}/a/{name}", "wb").write(data)
    shutil.copytree(f"{work}/a/sphere", f"{work}/a/hole")
    os.remove(f"{work}/a/hole/s3.ply")  # a plan says what its scan is made of: without a view it fails
    text = run("run", write_job(f"{work}/job.yaml", "a"), "--out", f"{work}/o", want=3)
    for name in bad:
        lines = [line for line in text.splitlines() if name in line]
        assert lines, f"no line names {name}:\n{text}"
    assert "s3.ply" in text, text
    assert sorted(os.path.dirname(p) for p in results(f"{work}/o") if p.endswith(".h5")) == ["scans/sphere/plan"]
    assert "7 failed" in text.splitlines()[-1] and "exit 3" in text.splitlines()[-1], text
    no_leftovers(f"{work}/o")
    missing = run("mesh", f"{work}/nothere.ply", "--bin-mm", "1", "-o", f"{work}/x.stl", want=2)
    assert "nothere.ply" in missing and not os.path.exists(f"{work}/x.stl"), missing
    os.makedirs(f"{work}/empty")
    none = run("run", write_job(f"{work}/none.yaml", "empty"), "--out", f"{work}/on", want=2)
    assert "empty" in none, none


def wrong_units_are_refused_with_a_guess(work):
    make_archive(f"{work}/a")
    os.makedirs(f"{work}/m")
    _, points = read_view(f"{work}/a/sphere/s0.ply")
    with open(f"{work}/m/metres.xyz", "w") as out:
        out.writelines("%.9g %.9g %.9g\n" % tuple(p / 1000) for p in points)
    text = run("run", write_job(f"{work}/job.yaml", "m"), "--out", f"{work}/o", want=3)
    assert "set units to m" in text and "metres" in text, text
    run("run", write_job(f"{work}/job.yaml", "m", "units: m\nlattice: {bin_mm: 1.5}\n"), "--out", f"{work}/o")


def changed_and_new_scans_are_redone(work):
    make_archive(f"{work}/a", ("sphere", "cube"))
    job = write_job(f"{work}/job.yaml", "a")
    run("run", job, "--out", f"{work}/o")
    first = results(f"{work}/o")
    text = run("run", job, "--out", f"{work}/o", "--explain")
    assert "2 unchanged" in text.splitlines()[-1], text
    header, points = read_view(f"{work}/a/cube/s2.ply")
    moved = points.copy()
    moved[0, 2] += 0.01
    open(f"{work}/a/cube/s2.ply", "wb").write(header + moved.tobytes())
    shutil.copytree(f"{work}/a/sphere", f"{work}/a/third")
    text = run("run", job, "--out", f"{work}/o", "--explain")
    assert "1 unchanged, 2 done" in text.splitlines()[-1] and "s2.ply" in text, text
    now = results(f"{work}/o")
    assert now["scans/sphere/plan/record.h5"] == first["scans/sphere/plan/record.h5"]
    assert now["scans/cube/plan/record.h5"] != first["scans/cube/plan/record.h5"]
    assert now["scans/third/plan/mesh.stl"] == first["scans/sphere/plan/mesh.stl"]
    state = json.load(open(f"{work}/o/run.json"))
    assert state["exit"] == 0 and len(state["scans"]) == 3


def tools_agree_with_the_job(work):
    make_archive(f"{work}/a")
    plan = f"{work}/a/sphere/plan.yaml"
    unswapped = "lattice: {bin_mm: 1.5}\noptimise: {smooth: false, feature: false}\n"
    run("run", write_job(f"{work}/job.yaml", "a", unswapped), "--out", f"{work}/o")
    wanted = results(f"{work}/o")["scans/sphere/plan/mesh.stl"]
    run("mesh", plan, "--bin-mm", "1.5", "-o", f"{work}/direct.stl")
    run("reduce", plan, "--bin-mm", "1.5", "-o", f"{work}/r.ply")
    run("mesh", f"{work}/r.ply", "--as-is", "-o", f"{work}/as-is.stl")
    assert open(f"{work}/direct.stl", "rb").read() == wanted
    assert open(f"{work}/as-is.stl", "rb").read() == wanted
    run("convert", plan, f"{work}/cloud.ply")
    run("mesh", f"{work}/cloud.ply", "--bin-mm", "1.5", "-o", f"{work}/cloud.stl")
    # One posed file knows no view directions; the sphere is closed, so its side follows from its volume.
    assert len(open(f"{work}/cloud.stl", "rb").read()) == len(wanted)
    told = json.loads([line for line in run("info", plan, "--json").splitlines() if "size_mm" in line][-1])
    told = told.get("values", told)
    assert all(abs(edge - 40) < 1 for edge in told["size_mm"]), told
    data = open(f"{work}/direct.stl", "rb").read()
    assert data.startswith(b"scanmill") and len(data) == 84 + 50 * struct.unpack("<I", data[80:84])[0]


def every_file(tree):
    """Relative path -> bytes of everything in scans/, but for the one line of a report that tells date and times."""
    found = {}
    for folder, _, files in os.walk(f"{tree}/scans"):
        for name in files:
            data = open(os.path.join(folder, name), "rb").read()
            if name == "report.html":
                data = b"\n".join(line for line in data.split(b"\n") if not line.startswith(b'<p id="run">'))
            if name != ".state.json":
                found[os.path.relpath(os.path.join(folder, name), tree)] = data
    return found


def values_of(text):
    return [json.loads(line) for line in text.splitlines() if '"type":"report"' in line][-1]["values"]


def every_output_is_the_same_for_any_threads(work):
    make_archive(f"{work}/a", ("cube",))
    keys = ("lattice: {bin_mm: 1.5}\noutputs: [stl, ply, obj]\nclean: {keep_box: {min: [-60, -60, -60], max: [15, 60, 60]}}\n")
    job = write_job(f"{work}/job.yaml", "a", keys)
    for threads in (1, 2, 7):
        run("run", job, "--out", f"{work}/o{threads}", "--threads", threads)
    first = every_file(f"{work}/o1")
    names = {os.path.basename(path) for path in first}
    assert names == {"mesh.stl", "mesh.ply", "mesh.obj", "record.h5", "report.html", "preview-shaded.png",
                     "preview-error.png", "preview-patches.png", "preview-removed.png"}, names
    assert every_file(f"{work}/o2") == first and every_file(f"{work}/o7") == first
    run("run", write_job(f"{work}/text.yaml", "a", "lattice: {bin_mm: 1.5}\noutputs: [{stl: {ascii: true}}]\n"), "--out",
        f"{work}/text")
    assert open(f"{work}/text/scans/cube/plan/mesh.stl", "rb").read().startswith(b"solid")


def mesh_tools_agree_with_the_job(work):
    make_archive(f"{work}/a", ("cube",))
    keys = "lattice: {bin_mm: 1.5}\noutputs: [stl, ply, obj]\n"
    run("run", write_job(f"{work}/swapped.yaml", "a", keys), "--out", f"{work}/s")
    plain = keys + "optimise: {smooth: false, feature: false}\n"
    run("run", write_job(f"{work}/plain.yaml", "a", plain), "--out", f"{work}/p")
    swapped, unswapped = f"{work}/s/scans/cube/plan", f"{work}/p/scans/cube/plan"
    # The swaps of the job, from a file that keeps numbers and patches.
    told = values_of(run("optimise", f"{unswapped}/mesh.ply", "-o", f"{work}/again.stl", "--bin-mm", "1.5", "--json"))
    assert told["feature"]["swaps"] > 0
    assert open(f"{work}/again.stl", "rb").read() == open(f"{swapped}/mesh.stl", "rb").read()
    # What verify finds is what the record says.
    told = values_of(run("verify", f"{swapped}/mesh.ply", "--cloud", f"{work}/a/cube/plan.yaml", "--bin-mm", "1.5", "--json"))
    with h5py.File(f"{swapped}/record.h5") as record:
        stage = record["stages"]
        counters = next(stage[name].attrs for name in stage if name.endswith("_verify"))
        for key, value in (("triangles", told["triangles"]), ("crossing_pairs", told["crossing_pairs"]),
                           ("max_mm", told["fit"]["all"]["max_mm"]), ("rms_mm", told["fit"]["all"]["rms_mm"]),
                           ("p99_mm", told["fit"]["all"]["p99_mm"]), ("smallest_angle_p5_deg", told["smallest_angle_p5_deg"])):
            assert counters[key] == value, (key, counters[key], value)
        errors = record["VTKHDF/PointData/error_mm"][:]
        assert len(errors) == told["vertices"] and abs(errors).max() <= told["fit"]["all"]["max_mm"] + 1e-6
    # Sections of the tool are those of the job, to the byte.
    cuts = "verify: {sections: [{axis: z, at_mm: 3}, {axis: x, through: worst}, {axis: [1, 1, 0], count: 2}, {axis: y, through: [1, 2, 3], slab_mm: 2}]}\n"
    run("run", write_job(f"{work}/cuts.yaml", "a", keys.replace("obj]", "obj, iges]") + cuts), "--out", f"{work}/c")
    told = values_of(run("verify", f"{work}/c/scans/cube/plan/mesh.ply", "--cloud", f"{work}/a/cube/plan.yaml", "--bin-mm", "1.5", "--json",
                         "--section", "z=3", "--section", "x=worst", "--section", "1,1,0=2x", "--section",
                         "{axis: y, through: [1, 2, 3], slab_mm: 2}", "-o", f"{work}/cuts/of/cube"))
    assert [os.path.basename(path) for path in told["files"]] == ["sections.svg", "sections.dxf", "sections.igs"] + [f"section-{n}.png" for n in range(1, 6)]
    for path in told["files"]:
        assert open(path, "rb").read() == open(f"{work}/c/scans/cube/plan/{os.path.basename(path)}", "rb").read(), path
    with h5py.File(f"{work}/c/scans/cube/plan/record.h5") as record:
        for n, section in enumerate(told["sections"]):
            assert section["name"] == record["sections/name"][n].decode() and section["max_mm"] == record["sections/max_mm"][n]
            assert section["worst"]["row"] == record["sections/worst_row"][n] and section["points"] == record["sections/points"][n]
    mesh, plan = f"{swapped}/mesh.ply", f"{work}/a/cube/plan.yaml"
    for words, wanted in ((("--section", "z=3", "-o", f"{work}/x"), "add --cloud"), (("--cloud", plan, "--section", "z=3"), "add -o DIR"),
                          (("--cloud", plan, "-o", f"{work}/x"), "add --section AXIS=PLACE"),
                          (("--cloud", plan, "--section", "z", "-o", f"{work}/x"), "found z; wanted AXIS=PLACE"),
                          (("--cloud", plan, "--section", "q=3", "-o", f"{work}/x"), "found 'q'; allowed x, y, z"),
                          (("--cloud", plan, "--section", "z=worts", "-o", f"{work}/x"), "nearest worst")):
        assert wanted in run("verify", mesh, *words, want=2), words
        assert not os.path.exists(f"{work}/x")
    # The same surface in every format.
    for name in ("mesh.stl", "mesh.obj"):
        told = values_of(run("compare", f"{swapped}/mesh.ply", f"{swapped}/{name}", "--json"))
        assert told["same_triangles"] and told["same_vertices"], name
    run("convert", f"{swapped}/mesh.ply", f"{work}/c.stl")
    assert open(f"{work}/c.stl", "rb").read()[84:] == open(f"{swapped}/mesh.stl", "rb").read()[84:]
    text = run("convert", f"{swapped}/mesh.ply", f"{work}/c.obj")
    assert "error" in text and "note" in text, text  # the errors of vertices are lost, and it says so
    run("convert", f"{swapped}/mesh.ply", f"{work}/points.ply", "--points")
    assert values_of(run("info", f"{swapped}/mesh.stl", "--json"))["closed_manifold"] is True
    for style in ("points", "wire", "shaded", "patches", "error"):
        run("render", f"{swapped}/mesh.ply", "-o", f"{work}/{style}.png", "--as", style, "--width", 400, "--height", 320)
        assert open(f"{work}/{style}.png", "rb").read().startswith(b"\x89PNG")
    assert "no error per vertex" in run("render", f"{swapped}/mesh.stl", "-o", f"{work}/x.png", "--as", "error", want=3)


def single_files_have_one_exit_code_each(work):
    for words in (["run"], ["info"], ["audit"], ["render", "-o", f"{work}/x.png"], ["verify"], ["check"], ["replay"], ["init"],
                  ["convert", f"{work}/x.ply"], ["simulate", "--object", "cube", "--out", f"{work}/x"]):
        run(words[0], f"{work}/nothere", *words[1:], want=2)
    os.makedirs(f"{work}/empty")
    run("init", f"{work}/empty", "-o", f"{work}/e.yaml", want=2)
    run("run", write_job(f"{work}/job.yaml", f"{work}/empty", "lattice: {bin_mm: 1}\n"), "--out", f"{work}/o", want=2)
    with open(f"{work}/nan.xyz.ply", "w") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
                   "nan nan nan\nnan 0 0\n")
    for words in (["info"], ["render", "-o", f"{work}/x.png"], ["reduce", "--bin-mm", "1", "-o", f"{work}/x.ply"]):
        assert "no finite point" in run(words[0], f"{work}/nan.xyz.ply", *words[1:], want=3)
    assert not os.path.exists(f"{work}/x.png")


def simulate_overwrites_its_own_views_only(work):
    make_archive(f"{work}/a", ("cube",))
    plan = f"{work}/a/cube/plan.yaml"
    run("simulate", plan, "--object", "cube", "--out", f"{work}/a/cube", "--quiet")
    view = next(f"{work}/a/cube/{name}" for name in sorted(os.listdir(f"{work}/a/cube")) if name.endswith(".ply"))
    with open(view, "w") as file:
        file.write("ply\nmeasured by hand\n")
    assert "was not simulated" in run("simulate", plan, "--object", "cube", "--out", f"{work}/a/cube", want=2)
    with open(plan) as file:
        text = file.read()
    with open(f"{work}/other.yaml", "w") as file:
        file.write(text + "# another\n")
    assert "another plan" in run("simulate", f"{work}/other.yaml", "--object", "cube", "--out", f"{work}/a/cube", want=2)
    assert open(view).read() == "ply\nmeasured by hand\n"


def gates_decide_the_exit_code(work):
    make_archive(f"{work}/a", ("sphere",))
    keys = "lattice: {bin_mm: 1.5}\nverify: {max_error_mm: 0.0001, rms_mm: 5}\nsensor: {accuracy_mm: 0.1}\n"
    text = run("run", write_job(f"{work}/job.yaml", "a", keys), "--out", f"{work}/o", want=4)
    assert "rejected: verify.max_error_mm: found" in text and "gates: 1" in text, text
    page = open(f"{work}/o/scans/sphere/plan/report.html").read()
    assert "verify.max_error_mm" in page
    assert json.load(open(f"{work}/o/run.json"))["scans"][0]["rejected"] is True
    mesh = f"{work}/o/scans/sphere/plan/mesh.stl"
    text = run("verify", mesh, "--cloud", f"{work}/a/sphere/plan.yaml", "--rms-mm", "0.00001", want=4)
    assert "rejected: verify.rms_mm" in text, text
    run("verify", mesh, "--cloud", f"{work}/a/sphere/plan.yaml", "--rms-mm", "1")


def every_json_line_fits_the_schema(work):
    import jsonschema

    schemas = {name: json.load(open(f"{ROOT}/schemas/{name}.schema.json")) for name in ("stream", "run")}
    lines = jsonschema.Draft7Validator(schemas["stream"])
    make_archive(f"{work}/a", ("sphere",))
    open(f"{work}/a/bad.xyz", "w").write("1 2 three\n")
    job = write_job(f"{work}/job.yaml", "a", "lattice: {bin_mm: 1.5}\nverify: {max_error_mm: 0.0001}\n")
    out = f"{work}/o"
    mesh = f"{out}/scans/sphere/plan/mesh.stl"
    plan = f"{work}/a/sphere/plan.yaml"
    commands = [(3, "run", job, "--out", out, "--explain"), (4, "run", job, "--out", out), (0, "check", job), (0, "info", plan),
                (0, "worklist", job, "--out", f"{work}/w", "--tasks", "1"), (3, "task", f"{work}/w/work/by-hand/tasks.json", "0"),
                (0, "--version"), (0, "schema", "job"), (0, "info", f"{out}/scans/sphere/plan/record.h5"), (0, "info", mesh), (0, "audit", f"{out}/scans/sphere/plan", "--archive", f"{work}/a"),
                (4, "audit", f"{out}/scans/sphere/plan", "--archive", work), (0, "verify", mesh, "--cloud", plan), (0, "verify", mesh, "--cloud", plan, "--section", "z=worst", "-o", f"{work}/cuts"),
                (0, "compare", mesh, mesh),
                (0, "optimise", mesh, "-o", f"{work}/m.ply"), (0, "convert", mesh, f"{work}/m.obj"),
                (0, "render", mesh, "-o", f"{work}/m.png"), (0, "reduce", plan, "--bin-mm", "2", "-o", f"{work}/r.ply"),
                (0, "mesh", f"{work}/r.ply", "--as-is", "-o", f"{work}/m.stl"), (0, "init", f"{work}/a", "-o", f"{work}/i.yaml"),
                (2, "run", f"{work}/nowhere.yaml"), (2, "rnu"), (2, "schema", "jb"), (3, "info", f"{work}/a/bad.xyz")]
    for want, *words in commands:
        done = subprocess.run([SCANMILL, *words, "--json"], capture_output=True, text=True, timeout=300)
        assert done.returncode == want, (words, done.returncode, done.stdout, done.stderr)
        assert done.stdout.strip(), words
        for line in done.stdout.splitlines():
            errors = list(lines.iter_errors(json.loads(line)))
            assert not errors, (words, line, errors)
    errors = list(jsonschema.Draft7Validator(schemas["run"]).iter_errors(json.load(open(f"{out}/run.json"))))
    assert not errors, errors
    run("check", f"{work}/i.yaml")


def front_engine_runs(work):
    make_archive(f"{work}/a")
    job = write_job(f"{work}/job.yaml", "a", "profile: paper\nlattice: {bin_mm: 2}\ngrow: {engine: front}\n")
    run("run", job, "--out", f"{work}/o1", "--threads", 1)
    run("run", job, "--out", f"{work}/o2", "--threads", 2)
    assert results(f"{work}/o1") == results(f"{work}/o2")
    with h5py.File(f"{work}/o1/scans/sphere/plan/record.h5") as record:
        assert len(record["mesh/triangles"]) > 1500


def full_disk_leaves_nothing_partial(work):
    disk = f"{work}/disk"
    os.makedirs(disk)
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "none", disk], capture_output=True).returncode:
        print("skipped: mounting a small disk needs root")
        sys.exit(77)
    try:
        make_archive(f"{work}/a")
        text = run("run", write_job(f"{work}/job.yaml", "a"), "--out", f"{disk}/o", want=1)
        assert "space" in text.lower() and disk in text, text
        assert results(f"{disk}/o") == {}, results(f"{disk}/o").keys()
    finally:
        subprocess.run(["umount", disk], check=True)
    run("run", f"{work}/job.yaml", "--out", f"{work}/o")


def a_limit_on_files_is_a_full_disk(work):
    make_archive(f"{work}/a")
    job = write_job(f"{work}/job.yaml", "a")
    limited = ["bash", "-c", 'ulimit -f 100; exec "$0" "$@"', SCANMILL, "run", job, "--out", f"{work}/o"]
    done = subprocess.run(limited, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1, done
    assert "File too large" in done.stderr and f"{work}/o/scans/sphere/.plan.1/mesh.stl" in done.stderr, done.stderr
    assert results(f"{work}/o") == {} and not os.path.exists(f"{work}/o/quarantine.json")
    run("run", job, "--out", f"{work}/o")


if __name__ == "__main__":
    random.seed(1)
    with tempfile.TemporaryDirectory(prefix="scanmill-") as place:
        globals()[sys.argv[1]](place)
