#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docker/ci/run_job.sh as a build runs it, with the program at hand in place of the image.

ci_script.py CASE        (SCANMILL: the program, SCANMILL_ROOT: the source tree)
"""
import math
import os
import subprocess
import xml.etree.ElementTree

import yaml
from cases import run_case

SCANMILL, ROOT = os.environ["SCANMILL"], os.environ["SCANMILL_ROOT"]


def build(work, gates, want, *words):
    os.makedirs(f"{work}/archive", exist_ok=True)
    for scan in ("bent", "flat"):
        with open(f"{work}/archive/{scan}.xyz", "w") as out:
            out.writelines(f"{0.5 * i} {0.5 * j} {(scan == 'bent') * 3 * math.sin(0.2 * i) * math.cos(0.2 * j):.6f}\n"
                           for i in range(60) for j in range(60))
    with open(f"{work}/job.yaml", "w") as out:
        out.write(f"scanmill: 1\narchive: archive\nsettle_s: 0\nlattice: {{bin_mm: 1.5}}\n{gates}")
    page = f"{work}/page.md"
    done = subprocess.run([f"{ROOT}/docker/ci/run_job.sh", "job.yaml", "out", "publish", *words], cwd=work, capture_output=True, text=True,
                          env=dict(os.environ, SCANMILL=SCANMILL, GITHUB_STEP_SUMMARY=page))
    assert done.returncode == want, f"exit {done.returncode}, wanted {want}\n{done.stdout}{done.stderr}"
    cases = {case.get("name"): case for case in xml.etree.ElementTree.parse(f"{work}/publish/junit.xml").iter("testcase")}
    with open(page) as file:
        return done.stdout, cases, file.read()


def a_good_job_passes_and_publishes(work):
    said, cases, page = build(work, "", 0)
    assert "all good" in said and set(cases) == {"bent", "flat"}, (said, cases)
    assert not [case for case in cases.values() if len(case.findall("failure"))]
    for name in ("report.html", "run.json", "scanmill.prom", "summary.md", "scans/bent/report.html"):
        assert os.path.getsize(f"{work}/publish/{name}") > 0, name
    assert "2" in page


def a_failed_gate_ends_with_4(work):
    said, cases, page = build(work, "overrides: [{scans: bent, verify: {rms_mm: 0.001}}]\n", 4)
    assert "a gate failed" in said, said
    failures = {name: [failure.get("message") for failure in case.findall("failure")] for name, case in cases.items()}
    assert failures["bent"] and "rms" in failures["bent"][0] and not failures["flat"], failures
    assert "bent" in page, page
    # The gate is met again: what stands is judged anew, and the build is green.
    said, cases, _ = build(work, "overrides: [{scans: bent, verify: {rms_mm: 1}}]\n", 0)
    assert not [case for case in cases.values() if len(case.findall("failure"))]


def examples_call_the_script(_):
    with open(f"{ROOT}/docker/ci/github.yml") as file:
        steps = yaml.safe_load(file)["jobs"]["mesh"]["steps"]
    calls = [step["run"] for step in steps if "run" in step]
    with open(f"{ROOT}/docker/ci/gitlab.yml") as file:
        mesh = yaml.safe_load(file)["mesh"]
    assert calls == mesh["script"] == ["docker/ci/run_job.sh jobs/ci.yaml out publish"], (calls, mesh)
    assert mesh["artifacts"]["reports"]["junit"] == "publish/junit.xml"
    assert os.access(f"{ROOT}/docker/ci/run_job.sh", os.X_OK) and os.path.exists(f"{ROOT}/jobs/ci.yaml")


def kubernetes_tasks_are_those_of_the_program(work):
    """What the manifest's pods run, run by hand, makes what a run makes."""
    with open(f"{ROOT}/docker/kubernetes.yaml") as file:
        job = yaml.safe_load(file)["spec"]
    container = job["template"]["spec"]["containers"][0]
    assert container["args"][0] == "task" and job["completionMode"] == "Indexed"
    assert job["podFailurePolicy"]["rules"][0]["onExitCodes"]["values"] == [2, 3, 4]
    build(work, "", 0)
    worklist = "by-hand-out/work/by-hand/tasks.json"
    done = subprocess.run([SCANMILL, "worklist", "job.yaml", "--out", "by-hand-out", "--tasks", "2"], cwd=work, check=True, capture_output=True)
    assert b"2 tasks" in done.stdout, done
    for index in ("0", "1"):
        words = [word.replace("/data/out/work/by-hand/tasks.json", worklist).replace("$(JOB_COMPLETION_INDEX)", index) for word in container["args"]]
        subprocess.run([SCANMILL, *words], cwd=work, check=True, capture_output=True)
    done = subprocess.run([SCANMILL, "run", "job.yaml", "--out", "by-hand-out"], cwd=work, check=True, capture_output=True)
    assert b"2 unchanged" in done.stdout, done
    for scan in ("bent", "flat"):
        for name in ("mesh.stl", "record.h5"):
            with open(f"{work}/out/scans/{scan}/{name}", "rb") as a, open(f"{work}/by-hand-out/scans/{scan}/{name}", "rb") as b:
                assert a.read() == b.read(), (scan, name)


run_case([a_good_job_passes_and_publishes, a_failed_gate_ends_with_4, examples_call_the_script, kubernetes_tasks_are_those_of_the_program])
