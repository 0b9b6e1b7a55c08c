#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Driver and workers are killed at random moments; nothing may be lost, half done or different afterwards.

crash_loop.py SCANMILL WORK ROUNDS [SEED]
"""
import hashlib
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import time

SCANMILL, WORK, ROUNDS = sys.argv[1], sys.argv[2], int(sys.argv[3])
SEED = int(sys.argv[4]) if len(sys.argv) > 4 else 7
SCANS = 8


def make_archive(folder):
    """Clouds of bent sheets, each of another size, so that scans overlap in time in ever new ways."""
    os.makedirs(f"{folder}/deep")
    for scan in range(SCANS):
        side = 40 + 12 * scan
        with open(f"{folder}/{'deep/' if scan % 3 == 0 else ''}part{scan}.xyz", "w") as out:
            for i in range(side):
                for j in range(side):
                    out.write(f"{0.5 * i} {0.5 * j} {math.sin(0.07 * i + scan) * math.cos(0.05 * j):.6f}\n")


def start(tree):
    return subprocess.Popen([SCANMILL, "run", f"{WORK}/job.yaml", "--out", tree, "--threads", "2", "--quiet"],
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def finish(tree):
    run = start(tree)
    text = run.communicate(timeout=300)[0]
    assert run.returncode == 0, f"exit {run.returncode} of an undisturbed resume\n{text}"


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def results(tree):
    """Scan -> {file: digest} of what stands under final names; every file must be what its state says."""
    found = {}
    for folder, folders, files in os.walk(f"{tree}/scans"):
        folders[:] = [name for name in folders if not name.startswith(".")]
        if not files:
            continue
        name = os.path.relpath(folder, f"{tree}/scans")
        assert ".state.json" in files and "record.h5" in files, f"{name} is half there: {files}"
        with open(f"{folder}/.state.json") as file:
            state = json.load(file)
        assert sorted(files) == sorted([".state.json"] + [o["name"] for o in state["outputs"]]), f"{name}: {files}"
        found[name] = {o["name"]: o["sha256"] for o in state["outputs"]}
        for file_name, sha256 in found[name].items():
            assert digest(f"{folder}/{file_name}") == sha256, f"{name}/{file_name} is not what its state says"
    return found


def meshes_and_records(tree):
    return {name: {f: d for f, d in files.items() if f in ("mesh.stl", "record.h5")} for name, files in results(tree).items()}


def no_leftovers(tree):
    for folder, folders, files in os.walk(tree):
        left = [name for name in folders if name.startswith(".")] + [name for name in files if ".tmp-" in name]
        assert not left, f"left behind in {folder}: {left}"


def children(pid):
    try:
        with open(f"/proc/{pid}/task/{pid}/children") as file:
            return [int(word) for word in file.read().split()]
    except OSError:
        return []


def kill(pid):
    try:
        os.kill(pid, signal.SIGKILL)
        return True
    except ProcessLookupError:
        return False


def main():
    shutil.rmtree(WORK, ignore_errors=True)
    make_archive(f"{WORK}/archive")
    with open(f"{WORK}/job.yaml", "w") as out:
        out.write("scanmill: 1\narchive: archive\nsettle_s: 0\nlattice: {bin_mm: 1.5}\noutputs: [stl]\n")
    began = time.monotonic()
    finish(f"{WORK}/undisturbed")
    length = time.monotonic() - began
    wanted = meshes_and_records(f"{WORK}/undisturbed")
    assert len(wanted) == SCANS, f"found {len(wanted)} results of {SCANS}"
    chance = random.Random(SEED)
    tree, hits = f"{WORK}/tree", {"driver": 0, "worker": 0, "missed": 0}
    for number in range(ROUNDS):
        if number % 3 == 0:
            shutil.rmtree(tree, ignore_errors=True)
        run = start(tree)
        time.sleep(chance.uniform(0, length))
        if number % 2 == 0:
            hits["driver" if run.poll() is None and kill(run.pid) else "missed"] += 1
            run.communicate(timeout=60)
        else:
            workers = children(run.pid)
            hit = bool(workers) and kill(chance.choice(workers))
            hits["worker" if hit else "missed"] += 1
            text = run.communicate(timeout=300)[0]
            assert run.returncode == 0, f"round {number}: exit {run.returncode} after a worker was killed\n{text}"
            assert meshes_and_records(tree) == wanted, f"round {number}: another result after a worker was killed"
        results(tree)  # whatever stands there is whole
        if number % 3 == 2 or number + 1 == ROUNDS:
            finish(tree)
            assert meshes_and_records(tree) == wanted, f"round {number}: another result after the resume"
            no_leftovers(tree)
    assert hits["driver"] + hits["worker"] >= ROUNDS // 4, f"too few kills hit anything: {hits}"
    print(f"{ROUNDS} rounds, seed {SEED}, a run of {length:.2f} s: {hits['driver']} drivers and {hits['worker']} workers "
          f"killed, {hits['missed']} came too late; all results as undisturbed")
    shutil.rmtree(WORK)


main()
