#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program as an operator meets it at night: workers that die, runs that meet, requests to stop.

at_night.py CASE        (SCANMILL: the program)
"""
import json
import math
import os
import signal
import subprocess
import time

from cases import run_case

SCANMILL = os.environ["SCANMILL"]
KEYS = "settle_s: 0\nlattice: {bin_mm: 1.5}\nretry: {wait_s: 0.05}\n"


def archive(folder, scans):
    os.makedirs(folder)
    for scan in scans:
        with open(f"{folder}/{scan}.xyz", "w") as out:
            for i in range(60):
                for j in range(60):
                    out.write(f"{0.5 * i} {0.5 * j} {math.sin(0.07 * i) * math.cos(0.05 * j):.6f}\n")


def job(work, scans, keys=KEYS):
    archive(f"{work}/archive", scans)
    with open(f"{work}/job.yaml", "w") as out:
        out.write(f"scanmill: 1\narchive: archive\n{keys}")


def start(work, *words, fault="", threads=2):
    environment = dict(os.environ, SCANMILL_TEST_FAULT=fault)
    return subprocess.Popen([SCANMILL, "run", "job.yaml", "--out", "out", "--threads", str(threads), *words], cwd=work, text=True,
                            env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def ended(run, want, seconds=120):
    out, err = run.communicate(timeout=seconds)
    assert run.returncode == want, f"exit {run.returncode}, wanted {want}\n{out}{err}"
    return out + err


def call(work, *words, want=0):
    done = subprocess.run([SCANMILL, *words], cwd=work, capture_output=True, text=True, timeout=120)
    assert done.returncode == want, f"{words}: exit {done.returncode}, wanted {want}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def wait_for(what, seconds=30):
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def states(work):
    with open(f"{work}/out/run.json") as file:
        return {scan["name"]: scan for scan in json.load(file)["scans"]}


def bad_scans_cost_only_themselves(work):
    job(work, ["crash", "fine", "good", "hang", "hog"], KEYS + "resources: {scan_time_limit: 3s, memory: 600M}\n")
    with open(f"{work}/archive/broken.ply", "w") as out:
        out.write("ply\nformat ascii 1.0\nelement vertex 1000\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2\n")
    text = ended(start(work, fault="crash:crash,hang:hang,hog:hog"), 3)
    found = states(work)
    assert {name: scan["state"] for name, scan in found.items()} == {
        "broken": "failed", "crash": "failed", "fine": "done", "good": "done", "hang": "failed", "hog": "failed"}, text
    for name, failure in (("broken", "bad_input"), ("crash", "internal"), ("hang", "internal"), ("hog", "resource")):
        error = found[name]["error"]
        assert error["class"] == failure, error
        assert f"--only {name}" in error["repeat"], error
        assert error["stage"], error
        assert f"scan {name}: failed: " in text, text
    # The next night: a line each, and nothing is wrong.
    text = ended(start(work), 0)
    for name in ("broken", "crash", "hang", "hog"):
        assert f"scan {name}: quarantined" in text, text
    # Whoever knows better says retry.
    text = call(work, "retry", "out", "h*", "crash")
    assert "3 done" in text, text
    call(work, "retry", "out", want=3)
    assert states(work)["broken"]["state"] == "failed"


def two_runs_meet(work):
    job(work, ["a", "stuck"])
    first = start(work, fault="hang:stuck")
    wait_for(lambda: os.path.exists(f"{work}/out/scans/a"))
    text = ended(start(work), 75)
    assert f"pid {first.pid}" in text and "for 00:00:" in text, text
    assert "running for" in call(work, "status", "out")
    workers = open(f"/proc/{first.pid}/task/{first.pid}/children").read().split()
    assert workers
    first.kill()
    first.wait()
    for worker in workers:
        wait_for(lambda: not os.path.exists(f"/proc/{worker}") or open(f"/proc/{worker}/stat").read().split()[2] == "Z", 5)
    assert "killed" in call(work, "status", "out")
    text = ended(start(work), 0)
    assert "1 unchanged, 1 done" in text, text
    assert "no run; the last ended" in call(work, "status", "out")


def the_first_request_drains_the_second_stops(work):
    job(work, [f"s{n}" for n in range(8)])
    run = start(work, threads=1)
    wait_for(lambda: os.path.exists(f"{work}/out/journal/live.json"))
    run.send_signal(signal.SIGINT)
    text = ended(run, 130)
    found = [scan["state"] for scan in states(work).values()]
    assert "pending" in found and "interrupted" not in found and "failed" not in found, found
    assert "stopping: 1 scan is brought to the end" in text or "done" in found, text
    run = start(work, threads=1, fault="hang:s7")
    wait_for(lambda: os.path.exists(f"{work}/out/journal/live.json") and "s7" in call(work, "status", "out"))
    run.send_signal(signal.SIGUSR1)
    run.send_signal(signal.SIGTERM)
    time.sleep(0.5)
    assert run.poll() is None, "it drains"
    run.send_signal(signal.SIGTERM)
    text = ended(run, 143)
    assert "s7" in text, text
    assert states(work)["s7"]["state"] in ("interrupted", "pending"), states(work)["s7"]
    ended(start(work), 0)


def cancel_and_gc(work):
    job(work, ["a", "stuck"])
    assert "found no run here" in call(work, "status", "out", want=2)
    run = start(work, fault="hang:stuck")
    wait_for(lambda: os.path.exists(f"{work}/out/scans/a"))
    for command in ("gc", "retry"):
        assert "holds this output" in call(work, command, "out", want=75)
    assert "asked pid" in call(work, "cancel", "out")
    wait_for(lambda: "stopping" in call(work, "status", "out"))
    assert "asked to stop before" in call(work, "cancel", "out")
    ended(run, 143)
    os.makedirs(f"{work}/out/scans/.a.7")
    open(f"{work}/out/logs/gone.log", "w").close()
    text = call(work, "gc", "out", "--dry-run")
    assert ".a.7" in text and "gone.log" in text and os.path.exists(f"{work}/out/logs/gone.log"), text
    call(work, "gc", "out")
    assert not os.path.exists(f"{work}/out/logs/gone.log") and not os.path.exists(f"{work}/out/scans/.a.7")
    assert os.path.exists(f"{work}/out/logs/a.log")
    assert "nothing to remove" in call(work, "gc", "out")
    # A run on a part of the scans does not make the others gone.
    with open(f"{work}/archive/bad.ply", "w") as out:
        out.write("ply\n")
    ended(start(work), 3)
    ended(start(work, "--only", "a"), 0)
    assert "nothing to remove" in call(work, "gc", "out")
    assert os.path.exists(f"{work}/out/logs/bad.log")
    os.remove(f"{work}/archive/bad.ply")
    assert "vanished from the archive: bad" in ended(start(work), 0)
    assert "logs/bad.log" in call(work, "gc", "out")


def dry_run_tells_what_it_would_do(work):
    job(work, ["a", "b"])
    text = call(work, "run", "job.yaml", "--out", "out", "--dry-run")
    assert "would run 2 scans of 2" in text and "time not known" in text, text
    assert not os.path.exists(f"{work}/out")
    ended(start(work), 0)
    with open(f"{work}/archive/b.xyz", "a") as out:
        out.write("0 0 1\n")
    tree = json.loads(call(work, "run", "job.yaml", "--out", "out", "--dag", "json"))
    assert [(task["scan"], task["verb"], task["why"]) for task in tree["tasks"]] == [
        ("a", "unchanged", []), ("b", "run", ["input b.xyz changed"])], tree
    assert tree["seconds"] > 0
    dot = call(work, "run", "job.yaml", "--out", "out", "--dag", "dot")
    assert dot.startswith("digraph") and '"b: run"' in dot and dot.rstrip().endswith("}"), dot


run_case([bad_scans_cost_only_themselves, two_runs_meet, the_first_request_drains_the_second_stops, cancel_and_gc,
          dry_run_tells_what_it_would_do])
