#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Records proven, and every kind of change noticed.  usage: audits.py CASE"""
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from random import Random

import h5py
import numpy

from end_to_end import make_archive, run, values_of, write_job

KEPT = f"{os.environ['SCANMILL_ROOT']}/tests/provenance/kept"
KEYS = "lattice: {bin_mm: 1.5}\noutputs: [stl, {iges: {style: patches}}, 3mf, vdb]\nverify: {sections: [{axis: z, count: 1}]}\n"


def flip(path, at):
    with open(path, "r+b") as file:
        file.seek(at)
        byte = file.read(1)
        file.seek(at)
        file.write(bytes([byte[0] ^ 1]))


def records_are_proven_and_made_again(work):
    make_archive(f"{work}/a", ("sphere", "cube"))
    # The archive's path in run.json is the job's: relative to where the job is run.
    run("run", write_job(f"{work}/job.yaml", f"{work}/a", KEYS), "--out", f"{work}/o")
    folders = [f"{work}/o/scans/{name}/plan" for name in ("sphere", "cube")]
    data = os.environ.get("SCANMILL_DATA", "")
    if os.path.isdir(f"{data}/range-views/bunny"):
        job = write_job(f"{work}/bunny.yaml", f"{data}/range-views/bunny", "units: m\nlattice: {target_points: 3000}\n")
        run("run", job, "--out", f"{work}/b")
        folders.append(f"{work}/b/scans/bun")
    for folder in folders:
        told = values_of(run("audit", folder, "--json"))
        assert told["proven"] and told["content_proven"] and told["inputs_proven"] == told["inputs"] > 1, told
        told = values_of(run("audit", f"{folder}/record.h5", "--rerun", "--json", "--threads", 1))
        assert told["proven"] and told["remade_the_same"] and told["remade_identity"] == told["identity"], told
    # The record and its archive alone: away from the tree that made it.
    os.makedirs(f"{work}/alone")
    for name in os.listdir(folders[0]):
        shutil.copy(f"{folders[0]}/{name}", f"{work}/alone/{name}")
    assert "add --archive DIR" in run("audit", f"{work}/alone", want=2)
    assert values_of(run("audit", f"{work}/alone", "--rerun", "--archive", f"{work}/a", "--json"))["proven"]


def one_changed_byte_is_noticed(work):
    make_archive(f"{work}/a")
    run("run", write_job(f"{work}/job.yaml", f"{work}/a", KEYS), "--out", f"{work}/o")
    folder = f"{work}/o/scans/sphere/plan"
    view = f"{work}/a/sphere/s2.ply"
    flip(view, os.path.getsize(view) - 7)
    text = run("audit", folder, want=4)
    assert "rejected: input sphere/s2.ply: was changed: its SHA-256 is " in text, text
    assert "rejected: rerun: " in run("audit", folder, "--rerun", want=4)
    flip(view, os.path.getsize(view) - 7)
    run("audit", folder)
    os.rename(view, view + ".away")
    assert f"input sphere/s2.ply: is not in {work}/a" in run("audit", folder, want=4)
    os.rename(view + ".away", view)
    for name in ("mesh.stl", "mesh.igs", "mesh.3mf", "bins.vdb", "sections.svg", "sections.dxf"):
        flip(f"{folder}/{name}", 200)
        text = run("audit", folder, want=4)
        assert f"rejected: output {name}: was changed" in text and text.count("rejected:") == 1, text
        flip(f"{folder}/{name}", 200)
    for name in ("report.html", "preview-shaded.png", "section-1.png"):
        flip(f"{folder}/{name}", 200)
        text = run("audit", folder, want=4)
        assert f"rejected: file {name}: was changed" in text and text.count("rejected:") == 1, text
        flip(f"{folder}/{name}", 200)
    os.rename(f"{folder}/mesh.stl", f"{folder}/away")
    assert "output mesh.stl: is not in" in run("audit", folder, want=4)
    os.rename(f"{folder}/away", f"{folder}/mesh.stl")
    # A parameter, as an editor of HDF5 files would change it.
    shutil.copy(f"{folder}/record.h5", f"{work}/kept.h5")
    with h5py.File(f"{folder}/record.h5", "r+") as record:
        item = record["parameters/what_json"]
        item[()] = item[()].replace(b'"bin_mm":1.5', b'"bin_mm":1.6')
    assert "rejected: record: was changed after it was written" in run("audit", folder, want=4)
    text = run("audit", folder, "--rerun", want=4)
    assert "the record made again has the identity" in text and "rerun: mesh.stl made again" in text, text
    shutil.copy(f"{work}/kept.h5", f"{folder}/record.h5")
    # A measured value of the record.
    with h5py.File(f"{folder}/record.h5", "r+") as record:
        record["reduced/points"][7, 1] += 1e-9
    text = run("audit", folder, "--rerun", want=4)
    assert "record: was changed after it was written" in text, text
    with open(f"{folder}/record.h5", "r+b") as record:
        record.truncate(os.path.getsize(f"{folder}/record.h5") // 2)
    assert "rejected: " in run("audit", folder, want=4) and "not a complete HDF5 file" in run("info", f"{folder}/record.h5", want=3)
    assert "no such file" in run("audit", f"{work}/nowhere.h5", want=2)
    assert "not a complete HDF5 file" in run("audit", f"{folder}/mesh.stl", want=3)
    assert "holds no record.h5" in run("audit", f"{work}/a", want=3)
    # A rerun that the machine cannot do says nothing of the record.
    shutil.copy(f"{work}/kept.h5", f"{folder}/record.h5")
    open(f"{work}/no-folder", "w").close()
    os.environ["TMPDIR"] = f"{work}/no-folder"
    text = run("audit", folder, "--rerun", "--json", want=1)
    del os.environ["TMPDIR"]
    assert "remade_the_same" not in text and "rejected" not in text, text


def content_of(path):
    """The digest `content`, worked out as docs/formats.md says, by nothing of ours."""
    lines, seen = [], set()

    def typed(item):
        kind = item.dtype
        return f"text{kind.itemsize}" if kind.kind == "S" else kind.name

    def add(path, attribute, item, raw, shape):
        extents = "".join(f"{size}," for size in shape or ())
        lines.append(f"{path}{' @' + attribute if attribute else ''} {typed(item)} [{extents}] {hashlib.sha256(raw).hexdigest()}")

    def attributes(path, item):
        for name in item.attrs:
            if (path, name) != ("/", "content"):
                told = item.attrs.get_id(name)
                value = numpy.empty(told.shape or (), told.dtype)
                if told.shape is not None:
                    told.read(value)
                add(path, name, told, value.tobytes() if told.shape is not None else b"", told.shape)

    def below(group, path):
        for name in sorted(group):
            item, inner = group[name], path + name
            place = h5py.h5o.get_info(item.id).addr
            if place in seen:
                continue
            seen.add(place)
            if isinstance(item, h5py.Group):
                lines.append(f"{inner} group [] {hashlib.sha256(b'').hexdigest()}")
                attributes(inner, item)
                below(item, inner + "/")
            else:
                value = item[()]
                add(inner, "", item, value.tobytes() if hasattr(value, "tobytes") else value, item.shape)
                attributes(inner, item)

    with h5py.File(path, "r") as record:
        attributes("/", record)
        below(record, "/")
        return hashlib.sha256("".join(line + "\n" for line in sorted(lines)).encode()).hexdigest(), record.attrs["content"].decode(), sorted(lines)


def a_forged_record_is_found_by_a_rerun(work):
    """Who changes a parameter or a result and works `content` out again deceives the digest, not the rerun."""
    make_archive(f"{work}/a")
    run("run", write_job(f"{work}/job.yaml", f"{work}/a", KEYS), "--out", f"{work}/o")
    folder = f"{work}/o/scans/sphere/plan"
    shutil.copy(f"{folder}/record.h5", f"{work}/kept.h5")
    assert content_of(f"{folder}/record.h5")[0] == content_of(f"{folder}/record.h5")[1]

    def parameter(record):
        item = record["parameters/what_json"]
        item[()] = item[()].replace(b'"bin_mm":1.5', b'"bin_mm":1.6')

    def result(record):
        record["mesh/stl_positions"][7, 1] += numpy.float32(0.001)

    def figure(record):
        stage = next(group for name, group in record["stages"].items() if name.endswith("_verify"))
        stage.attrs.modify("max_mm", 0.001)

    for forge, wanted in ((parameter, "rerun: mesh.stl made again"), (result, "has the same identity and differs in /mesh/stl_positions"),
                          (figure, "has the same identity and differs in /stages/")):
        shutil.copy(f"{work}/kept.h5", f"{folder}/record.h5")
        with h5py.File(f"{folder}/record.h5", "r+") as record:
            forge(record)
        assert "record: was changed after it was written" in run("audit", folder, want=4)
        digest = content_of(f"{folder}/record.h5")[0]
        with h5py.File(f"{folder}/record.h5", "r+") as record:
            record.attrs.modify("content", numpy.bytes_(digest))
        assert "rejected: file record.h5: was changed" in run("audit", folder, want=4)
        os.rename(f"{folder}/.state.json", f"{work}/state.json")  # as a record that came without its tree
        run("audit", folder)
        text = run("audit", folder, "--rerun", want=4)
        assert "rejected: " in text and wanted in text, text
        os.rename(f"{work}/state.json", f"{folder}/.state.json")
    shutil.copy(f"{work}/kept.h5", f"{folder}/record.h5")
    run("audit", folder, "--rerun")


def the_demo_is_made_again(work):
    root = os.environ["SCANMILL_ROOT"]
    for part in ("figurine", "handset"):
        run("simulate", f"{root}/jobs/demo/{part}.plan.yaml", "--object", part, "--out", f"{work}/a/{part}")
    text = open(f"{root}/jobs/demo.yaml").read().replace("../archive/demo", f"{work}/a")
    open(f"{work}/demo.yaml", "w").write(text)
    run("run", f"{work}/demo.yaml", "--out", f"{work}/o")
    found = [folder for folder, _, files in os.walk(f"{work}/o/scans") if "record.h5" in files]
    assert len(found) == 2, found
    for folder in found:
        told = values_of(run("audit", folder, "--rerun", "--json"))
        assert told["proven"] and told["remade_the_same"], told
        digest, stored, _ = content_of(f"{folder}/record.h5")
        assert digest == stored


def no_flipped_byte_crashes(work):
    """HDF5 itself crashes on some; found by chance, so many are tried (FLIPS)."""
    make_archive(f"{work}/a", ("cube",))
    run("run", write_job(f"{work}/job.yaml", f"{work}/a", "lattice: {bin_mm: 3}\n"), "--out", f"{work}/o")
    folder = f"{work}/o/scans/cube/plan"
    whole = open(f"{folder}/record.h5", "rb").read()
    random = Random(5)
    codes = {}
    for number in range(int(os.environ.get("FLIPS", 40))):
        # Most of the file are numbers; structures lie at its beginning and between them.
        at = random.randrange(len(whole)) if number % 4 == 0 else random.randrange(min(len(whole), 40000))
        value = random.randrange(256) if number % 2 else whole[at] ^ (1 << random.randrange(8))
        damaged = whole[:at] + bytes([value]) + whole[at + 1:]
        with open(f"{folder}/record.h5", "wb") as file:
            file.write(damaged)
        for words in (["audit", folder], ["info", f"{folder}/record.h5"]):
            done = subprocess.run([os.environ["SCANMILL"], *words, "--quiet"], capture_output=True, text=True, timeout=120)
            assert done.returncode in (0, 3, 4), f"byte {at} = {value}: {words[0]} ends with {done.returncode}\n{done.stderr}"
            codes[words[0], done.returncode] = codes.get((words[0], done.returncode), 0) + 1
    print(codes)
    assert codes.get(("audit", 4), 0) > 5, codes


def kept_records_stay_readable(work):
    """A record of every layout and of what later versions of the stage added to it; a new one is added, none is ever replaced."""
    for name, layout, scan in (("record-1.h5", "scanmill-record-1", "ball"), ("record-1-stage-7.h5", "scanmill-record-1", "cube/plan")):
        shutil.copy(f"{KEPT}/{name}", f"{work}/record.h5")
        with h5py.File(f"{work}/record.h5") as record:
            assert record.attrs["Conventions"].decode() == layout
        os.makedirs(f"{work}/empty", exist_ok=True)
        text = run("audit", work, "--archive", f"{work}/empty", "--json", want=4)
        told = values_of(text)
        assert told["scan"] == scan and told["content_proven"], text
        assert told["inputs_proven"] < told["inputs"] and "is not in" in text
        digest, stored, _ = content_of(f"{work}/record.h5")
        assert digest == stored, "as an independent reader works it out"
        known = values_of(run("info", f"{work}/record.h5", "--json"))
        assert known["layout"] == layout and known["content_proven"] and known["triangles"] > 90, known
        schema = f"{os.environ['SCANMILL_ROOT']}/tests/provenance/record_schema.py"
        subprocess.run([sys.executable, schema, "check", "--any-counters", f"{work}/record.h5"], check=True)


def the_crate_names_every_file_with_its_hash(work):
    make_archive(f"{work}/a", ("sphere", "cube"))
    os.rename(f"{work}/a/cube", f"{work}/a/cube two")
    run("run", write_job(f"{work}/job.yaml", f"{work}/a", KEYS), "--out", f"{work}/o")
    crate = json.load(open(f"{work}/o/ro-crate-metadata.json"))
    entities = {entity["@id"]: entity for entity in crate["@graph"]}
    assert len(entities) == len(crate["@graph"]), "ids are unique"
    root = entities["./"]
    assert entities["ro-crate-metadata.json"]["about"]["@id"] == "./"
    actions = [entities[action["@id"]] for action in root["mentions"]]
    assert len(actions) == 2 and all(action["@type"] == "CreateAction" for action in actions)
    import urllib.parse

    for action in actions:
        assert entities[action["instrument"]["@id"]]["@type"] == "SoftwareApplication"
        for kind, base in (("object", f"{work}/a"), ("result", f"{work}/o")):
            assert len(action[kind]) > 5
            for reference in action[kind]:
                entity = entities[reference["@id"]]
                path = f"{base}/" + (entity["name"] if kind == "object" else urllib.parse.unquote(entity["@id"]))
                content = open(path, "rb").read()
                assert entity["sha256"] == hashlib.sha256(content).hexdigest() and entity["contentSize"] == str(len(content))
                assert kind == "object" or reference in root["hasPart"]
    names = {entities[r["@id"]]["name"] for r in actions[0]["result"]}
    assert {"mesh.stl", "mesh.igs", "record.h5", "report.html"} <= names, names


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-") as place:
        globals()[sys.argv[1]](place)
