#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Records of real runs against the schema of the record.  usage: records.py CASE"""
import os
import subprocess
import sys

from cases import run_case
from end_to_end import ROOT, make_archive, run, write_job

SCRIPT = f"{ROOT}/tests/provenance/record_schema.py"


def schema(*words, want=0):
    done = subprocess.run([sys.executable, SCRIPT, *words], capture_output=True, text=True)
    assert done.returncode == want, done.stdout + done.stderr
    return done.stdout


def every_object_is_documented(work):
    """Everything at once; nothing at all; the other engine. Refined poses: closed_loop.py."""
    make_archive(f"{work}/a", ("sphere", "cube"))
    everything = ("lattice: {bin_mm: 2}\nverify: {max_error_mm: 9, sections: [{axis: z, count: 2}, {axis: x, at_mm: 500}]}\n"
                  "clean: {remove_plane: {fit: true, distance_mm: 0.5, min_share: 0.01}, outliers: {statistical: {neighbours: 8, deviations: 3}}, remove_box: [{min: [40, 40, 40], max: [50, 50, 50]}]}\n")
    for name, keys in (("everything", everything), ("least", "lattice: {bin_mm: 3}\noptimise: {smooth: false, feature: false}\n"),
                       ("front", "lattice: {bin_mm: 3}\ngrow: {engine: front}\n")):
        run("run", write_job(f"{work}/{name}.yaml", "a", keys), "--out", f"{work}/{name}")
        for scan in ("sphere", "cube"):
            schema("check", f"{work}/{name}/scans/{scan}/plan/record.h5")
    schema("self-test", f"{work}/everything/scans/cube/plan/record.h5", work)


def the_document_is_made_from_the_schema(work):
    made = schema("document")
    assert made == open(f"{ROOT}/docs/record.md").read(), \
        "docs/record.md is not what tests/provenance/record_schema.py document makes of schemas/record.schema.json"


if __name__ == "__main__":
    run_case([every_object_is_documented, the_document_is_made_from_the_schema])
