#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Nth write, sync, rename or open of a run fails, N = 1, 1 + STEP, ... until a run is not touched.

Whatever fails: never exit 0 with missing work, never a partial file under a final name, always to be resumed.

fault_injection.py SCANMILL WORK STEP        (needs strace; 77: it is not there, or may not trace)
"""
import hashlib
import json
import os
import shutil
import subprocess
import sys

SCANMILL, WORK, STEP = sys.argv[1], sys.argv[2], int(sys.argv[3])
FAULTS = [("write", "error=ENOSPC"), ("write", "error=EIO"), ("fsync,fdatasync", "error=EIO"),
          ("rename,renameat2", "error=EIO"), ("openat", "error=EIO"), ("openat", "error=ENOSPC")]
MOST = 2000


def make_archive(folder):
    os.makedirs(folder)
    for scan in range(2):
        with open(f"{folder}/part{scan}.xyz", "w") as out:
            for i in range(24):
                for j in range(24):
                    out.write(f"{0.5 * i} {0.5 * j} {0.01 * i * j * (scan + 1)}\n")


def command(tree):
    return [SCANMILL, "run", f"{WORK}/job.yaml", "--out", tree, "--threads", "1", "--progress", "none"]


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def results(tree, what):
    """As in crash_loop.py: scan -> digests of mesh and record; everything under a final name must be whole."""
    found = {}
    for folder, folders, files in os.walk(f"{tree}/scans"):
        folders[:] = [name for name in folders if not name.startswith(".")]
        if not files:
            continue
        assert ".state.json" in files, f"{what}: {folder} is half there: {files}"
        with open(f"{folder}/.state.json") as file:
            state = json.load(file)
        for output in state["outputs"]:
            assert digest(f"{folder}/{output['name']}") == output["sha256"], f"{what}: {folder}/{output['name']}"
        found[os.path.basename(folder)] = {name: digest(f"{folder}/{name}") for name in ("mesh.stl", "record.h5")}
    for name in ("run.json", "quarantine.json"):
        if os.path.exists(f"{tree}/{name}"):
            with open(f"{tree}/{name}") as file:
                json.load(file)
    return found


def main():
    if shutil.which("strace") is None:
        print("strace is not installed")
        return 77
    shutil.rmtree(WORK, ignore_errors=True)
    make_archive(f"{WORK}/archive")
    with open(f"{WORK}/job.yaml", "w") as out:
        out.write("scanmill: 1\narchive: archive\nsettle_s: 0\nlattice: {bin_mm: 1}\nretry: {wait_s: 0.01}\n")
    if subprocess.run(["strace", "-f", "-o", "/dev/null", "true"], capture_output=True).returncode != 0:
        print("strace may not trace here")
        return 77
    subprocess.run(command(f"{WORK}/wanted"), check=True, capture_output=True)
    wanted = results(f"{WORK}/wanted", "undisturbed")
    assert len(wanted) == 2
    tree, log = f"{WORK}/tree", f"{WORK}/calls"
    for call, fault in FAULTS:
        codes = {}
        for nth in range(1, MOST, STEP):
            what = f"{fault} at {call} number {nth}"
            shutil.rmtree(tree, ignore_errors=True)
            run = subprocess.run(["strace", "-f", "-qq", "-o", log, "-e", f"trace={call}", "-e", f"inject={call}:{fault}:when={nth}"]
                                 + command(tree), capture_output=True, text=True, timeout=120)
            with open(log) as file:
                touched = "(INJECTED)" in file.read()
            codes[run.returncode] = codes.get(run.returncode, 0) + 1
            found = results(tree, what)
            assert run.returncode >= 0, f"{what}: died of signal {-run.returncode}\n{run.stderr}"
            if run.returncode == 0:
                assert found == wanted, f"{what}: exit 0 with {sorted(found)}\n{run.stderr}"
            for name, digests in found.items():
                assert digests == wanted[name], f"{what}: {name} has other bytes"
            if not touched:
                break
            again = subprocess.run(command(tree), capture_output=True, text=True, timeout=120)
            assert again.returncode == 0, f"{what}: exit {again.returncode} of the resume\n{again.stderr}\nfirst run:\n{run.stderr}"
            assert results(tree, what) == wanted, f"{what}: other results after the resume"
        else:
            raise AssertionError(f"{call}: no run without a fault up to {MOST}")
        print(f"{call} {fault}: {sum(codes.values())} runs up to number {nth}, exit codes {codes}", flush=True)
    shutil.rmtree(WORK)
    return 0


sys.exit(main())
