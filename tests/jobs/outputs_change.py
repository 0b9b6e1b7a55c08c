#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A job whose outputs or gates change: its scans are written or judged again, not meshed again.

outputs_change.py CASE        (SCANMILL: the program)
"""
import json
import math
import os
import random
import subprocess

from cases import run_case

SCANMILL = os.environ["SCANMILL"]
MESHING = {"stars", "complete", "front", "merge", "grow", "optimise", "verify"}
KEYS = """scanmill: 1
archive: archive
settle_s: 0
lattice: {bin_mm: 1.5}
overrides:
  - {scans: deck, clean: {remove_plane: {fit: true, distance_mm: 0.3}}}
  - {scans: front, grow: {engine: front}}
  - {scans: seeded, seeds: {points: [[5, 5, 0]], cover: false}}
  - {scans: target, lattice: {target_points: 300}}
  - {scans: views, clean: {outliers: {min_component_points: 40}}}
views:
  - {name: views, files: "views/*.xyz"}
"""
FILES = "outputs: [{stl: {ascii: true}}, ply, {iges: {style: wire}}, dxf, 3mf, obj, vdb]\n"
SECTIONS = "verify: {sections: [{axis: x, at_mm: 7}, {axis: y, through: worst}, {axis: x, through: loop}]}\n"


def sheet(path, seed, at=(0, 0, 0), tail=""):
    place = random.Random(seed)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as out:
        for i in range(60):
            for j in range(60):
                z = 3 * math.sin(0.15 * i) * math.cos(0.1 * j) + place.gauss(0, 0.03)
                out.write(f"{at[0] + 0.4 * i:.6f} {at[1] + 0.4 * j:.6f} {at[2] + z:.6f}\n")
        out.write(tail)


def archive(folder):
    for seed, name in enumerate(("front", "plain", "seeded", "target")):
        sheet(f"{folder}/{name}.xyz", seed)
    sheet(f"{folder}/far.xyz", 7, (7.1e5, -3.2e6, 1e3))
    patch = "".join(f"{40 + 0.4 * i} {0.4 * j} 9\n" for i in range(6) for j in range(6))
    sheet(f"{folder}/stray.xyz", 8, tail=patch + "nan nan nan\n")
    deck = "".join(f"{0.4 * i} {0.4 * j} -8\n" for i in range(60) for j in range(60))
    sheet(f"{folder}/deck.xyz", 9, tail=deck)
    sheet(f"{folder}/views/a.xyz", 10, tail=patch)
    sheet(f"{folder}/views/b.xyz", 11, (6, 4, 0))


def run(work, out, keys, want=0, words=()):
    with open(f"{work}/job.yaml", "w") as file:
        file.write(KEYS + keys)
    done = subprocess.run([SCANMILL, "run", "job.yaml", "--out", out, "--explain", *words], cwd=work, capture_output=True, text=True,
                          timeout=300)
    assert done.returncode == want, f"exit {done.returncode}, wanted {want}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def scans(work, out):
    with open(f"{work}/{out}/run.json") as file:
        return {scan["name"]: scan for scan in json.load(file)["scans"]}


def files(folder):
    """Contents by path; of reports all but the line that tells when and how fast they were made."""
    found = {}
    for place, _, names in os.walk(folder):
        for name in names:
            if name == ".state.json":
                continue
            with open(f"{place}/{name}", "rb") as file:
                text = file.read()
            if name == "report.html":
                text = b"\n".join(line for line in text.split(b"\n") if not line.startswith(b'<p id="run">'))
            found[os.path.relpath(f"{place}/{name}", folder)] = text
    return found


def expect_same(work, out, fresh):
    again, full = files(f"{work}/{out}/scans"), files(f"{work}/{fresh}/scans")
    assert again.keys() == full.keys(), sorted(again.keys() ^ full.keys())
    assert not (apart := [name for name in full if again[name] != full[name]]), apart


def files_equal_those_of_a_full_run(work):
    archive(f"{work}/archive")
    run(work, "out", "outputs: [stl]\n")
    assert os.path.exists(f"{work}/out/scans/deck/preview-removed.png")
    for number, keys in enumerate((FILES, FILES + SECTIONS, "outputs: [ply]\nsensor: {accuracy_mm: 0.01}\n", "outputs: [stl]\n")):
        text = run(work, "out", keys)
        assert text.count("outputs changed: written again from the record") == 8, text
        for name, scan in scans(work, "out").items():
            assert scan["state"] == "done" and not MESHING & scan["stage_seconds"].keys(), scan
        run(work, f"full{number}", keys)
        assert all(MESHING & scan["stage_seconds"].keys() for scan in scans(work, f"full{number}").values())
        expect_same(work, "out", f"full{number}")
        text = run(work, "out", keys)
        assert "8 unchanged" in text, text


def gates_are_judged_from_the_record(work):
    archive(f"{work}/archive")
    one = ("--only", "plain")
    run(work, "out", "", words=one)
    found = scans(work, "out")["plain"]["counts"]["max_error_mm"]
    text = run(work, "out", f"verify: {{max_error_mm: {found / 2}}}\n", 4, one)
    assert "rejected" in text, text
    assert not MESHING & scans(work, "out")["plain"]["stage_seconds"].keys()
    run(work, "full", f"verify: {{max_error_mm: {found / 2}}}\n", 4, one)
    expect_same(work, "out", "full")
    run(work, "out", f"verify: {{max_error_mm: {found * 2}}}\n", 0, one)
    assert not MESHING & scans(work, "out")["plain"]["stage_seconds"].keys()
    text = run(work, "out", f"verify: {{max_error_mm: {found * 2}}}\ngrow: {{min_angle_deg: 6}}\n", 0, one)
    assert "from the record" not in text and "grow.min_angle_deg" in text, text
    assert MESHING & scans(work, "out")["plain"]["stage_seconds"].keys()


def a_record_that_was_changed_is_of_no_use(work):
    archive(f"{work}/archive")
    one = ("--only", "plain")
    run(work, "out", "", words=one)
    record = f"{work}/out/scans/plain/record.h5"
    with open(record, "r+b") as file:
        file.seek(os.path.getsize(record) // 2)
        byte = file.read(1)[0]
        file.seek(-1, 1)
        file.write(bytes([byte ^ 1]))
    text = run(work, "out", "outputs: [stl, ply]\n", words=one)
    scan = scans(work, "out")["plain"]
    assert MESHING & scan["stage_seconds"].keys() and scan["state"] == "done", scan
    assert any("meshed again" in note and "record.h5" in note for note in scan["notes"]), scan["notes"]
    run(work, "full", "outputs: [stl, ply]\n", words=one)
    expect_same(work, "out", "full")


def a_file_that_is_gone_comes_back_from_the_record(work):
    archive(f"{work}/archive")
    one = ("--only", "stray")
    run(work, "out", "", words=one)
    before = files(f"{work}/out/scans")
    os.remove(f"{work}/out/scans/stray/mesh.stl")
    text = run(work, "out", "", words=one)
    assert "mesh.stl is missing" in text, text
    assert not MESHING & scans(work, "out")["stray"]["stage_seconds"].keys()
    assert files(f"{work}/out/scans") == before
    os.remove(f"{work}/out/scans/stray/record.h5")
    run(work, "out", "", words=one)
    assert MESHING & scans(work, "out")["stray"]["stage_seconds"].keys()
    assert files(f"{work}/out/scans") == before


run_case([files_equal_those_of_a_full_run, gates_are_judged_from_the_record, a_record_that_was_changed_is_of_no_use,
          a_file_that_is_gone_comes_back_from_the_record])
