#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What a run leaves for people and programs, night after night.  usage: run_files.py CASE"""
import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse
import xml.etree.ElementTree

import numpy

from end_to_end import SCANMILL, make_archive, read_view, run, write_job

KEYS = "lattice: {bin_mm: 1.5}\n"


class Page(html.parser.HTMLParser):
    """Checks the nesting of tags; keeps links and pictures in their order."""

    VOID = {"meta", "img", "br", "link", "hr"}

    def __init__(self, path):
        super().__init__()
        self.open, self.links, self.text = [], [], ""
        self.source = open(path, encoding="utf-8").read()
        self.feed(self.source)
        assert self.open == [], self.open

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)
        self.links += [value for name, value in attributes if name in ("href", "src")]
        assert not any(name.startswith("on") for name, _ in attributes), attributes
        assert tag not in ("script", "link", "iframe", "object"), tag

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, tag

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in self.VOID:
            self.open.pop()

    def handle_data(self, data):
        if "style" not in self.open:
            self.text += data

    def after(self, heading):
        """The page from a section's heading to the next."""
        at = self.source.index(f'<h2 id="{heading}"')
        end = self.source.find("<h2 ", at + 1)
        return self.source[at : end if end > 0 else len(self.source)]


def metrics_of(path):
    """Series -> value; every sample stands below HELP and TYPE of its name."""
    found, family = {}, None
    for line in open(path, encoding="utf-8"):
        if line.startswith("# HELP "):
            family = line.split()[2]
        elif line.startswith("# TYPE "):
            assert line.split()[2] == family, line
        else:
            sample = re.fullmatch(r'(\w+)\{((?:\w+="(?:[^"\\\n]|\\.)*",?)+)\} (\S+)\n', line)
            assert sample and sample[1] == family, line
            found[line[: line.rindex(" ")]] = float(sample[3])
    return found


def value(metrics, name, label=""):
    series = [v for k, v in metrics.items() if k.startswith(name + "{") and label in k]
    assert len(series) == 1, (name, label, series)
    return series[0]


def spoil(path, amplitude):
    """More noise on one view: the part as a worn sensor would see it."""
    header, points = read_view(path)
    noise = numpy.random.default_rng(1).normal(0, amplitude, points.shape).astype("f4")
    open(path, "wb").write(header + (points + noise).tobytes())


def every_night_leaves_its_files_and_lists_the_worse_scan_first(work):
    make_archive(f"{work}/a", ("sphere", "cube", "torus"))
    os.rename(f"{work}/a/cube", f"{work}/a/cube <1> & 100%#")
    job = write_job(f"{work}/job.yaml", "a", KEYS)
    summary = f"{work}/summary.md"
    os.environ["GITHUB_STEP_SUMMARY"] = summary
    text = run("run", job, "--out", f"{work}/o")
    assert f"| {work}/o/report.html | exit 0" in text.splitlines()[-1], text
    page = Page(f"{work}/o/report.html")
    assert "ALL GOOD" in page.text and "no earlier run to compare with" in page.text
    assert page.after("new").count('class="card"') == 3
    first = metrics_of(f"{work}/o/scanmill.prom")
    assert value(first, "scanmill_run_scans", 'state="done"') == 3 and value(first, "scanmill_run_exit_code") == 0
    success = value(first, "scanmill_last_success_timestamp_seconds")

    spoil(f"{work}/a/torus/s0.ply", 0.4)
    shutil.copytree(f"{work}/a/torus", f"{work}/a/fourth")
    open(f"{work}/a/bad <b>.xyz", "w").write("1 2 3\n4 five 6\n")
    run("run", job, "--out", f"{work}/o", want=3)
    page = Page(f"{work}/o/report.html")
    for link in page.links:  # every link leads somewhere in the tree
        if not link.startswith("#"):
            path = f"{work}/o/{urllib.parse.unquote(link)}"
            assert "://" not in link and os.path.isfile(path), link
    assert not re.search(r"(src|href)=\"[a-z]+:|url\(|@import", page.source)
    worse = page.after("worse")
    then, now = re.search(r"greatest fit error<br/>([\d.]+) mm . <span class=\"up\">([\d.]+) mm", worse).groups()
    assert float(now) > 1.2 * float(then), (then, now)
    assert re.search(r'<th scope="row"><a href="([^"]+)"', worse)[1] == "scans/torus/plan/report.html"
    assert page.source.index('id="worse"') < page.source.index('id="failed"') < page.source.index('id="new"')
    assert "fourth" in page.after("new") and "torus" in page.after("changed") and "sphere" in page.after("unchanged")
    failed = page.after("failed")
    assert "What to do:" in failed and "--only" in failed and "found &quot;4 five 6&quot;" in failed

    suite = xml.etree.ElementTree.parse(f"{work}/o/junit.xml").getroot().find("testsuite")
    assert suite.get("tests") == "5" and suite.get("failures") == "1" and suite.get("errors") == "0"
    faults = [case.get("name") for case in suite.iter("testcase") if case.find("failure") is not None]
    assert len(faults) == 1 and "bad" in faults[0], faults

    rows = [line.rstrip("\n").split("\t") for line in open(f"{work}/o/trace.tsv", encoding="utf-8")]
    assert len(rows) == 6 and {len(row) for row in rows} == {len(rows[0])}
    state = rows[0].index("state")
    assert sorted(row[state] for row in rows[1:]) == ["done", "done", "failed", "unchanged", "unchanged"]
    assert float(rows[[row[0] for row in rows].index("torus/plan")][rows[0].index("reduce_seconds")]) > 0

    second = metrics_of(f"{work}/o/scanmill.prom")
    assert value(second, "scanmill_run_exit_code") == 3 and value(second, "scanmill_run_failures", "bad_input") == 1
    assert value(second, "scanmill_last_success_timestamp_seconds") == success
    text = open(summary, encoding="utf-8").read()
    assert text.count("## scanmill job.yaml") == 2 and "### Worse than the run before" in text and "### Failed" in text
    assert "<b>" not in text

    run("run", job, "--out", f"{work}/o")  # the third night: quarantined, nothing worse
    page = Page(f"{work}/o/report.html")
    assert 'id="quarantined"' in page.source and 'id="worse"' not in page.source and "1 QUARANTINED" in page.text
    assert "ALL GOOD" not in page.text and "exit code 0" in page.text


def notify_tells_and_never_decides(work):
    make_archive(f"{work}/a")
    told = ("notify:\n  - {on: failure, run: 'echo failure $SCANMILL_EXIT >>told'}\n"
            "  - {on: success, run: 'test -s \"$SCANMILL_RUN\" && test -s \"$SCANMILL_OUT/report.html\" && echo \"$SCANMILL_SUMMARY\" >>told'}\n"
            "  - run: 'echo no such host >&2; exit 7'\n")
    job = write_job(f"{work}/job.yaml", "a", KEYS + told)
    text = run("run", job, "--out", f"{work}/o")
    assert "note: notify: echo no such host" in text and "exit code 7: no such host" in text, text
    assert text.splitlines()[-1].endswith("exit 0"), text
    lines = open(f"{work}/told").read().splitlines()
    assert len(lines) == 1 and lines[0].startswith("1 scan: 0 unchanged, 1 done") and lines[0].endswith("exit 0"), lines
    open(f"{work}/a/bad.xyz", "w").write("1 2 three\n")
    run("run", job, "--out", f"{work}/o", want=3)
    assert open(f"{work}/told").read().splitlines()[1:] == ["failure 3"]
    os.rename(f"{work}/a", f"{work}/gone")  # the archive is not mounted tonight
    run("run", job, "--out", f"{work}/o", want=2)
    run("run", job, "--out", f"{work}/o", "--dry-run", want=2)
    assert open(f"{work}/told").read().splitlines()[2:] == ["failure 2"]
    bad = write_job(f"{work}/bad.yaml", "gone", KEYS + "notify: [{webhook: 'https://example.org'}]\n")
    assert "curl" in run("check", bad, want=2)


def bench_of_a_job_measures_and_compares(work):
    make_archive(f"{work}/a")
    job = write_job(f"{work}/job.yaml", "a", KEYS + "notify: [{run: touch told}]\n")
    text = run("bench", job, "--repeat", 2, "--out", f"{work}/b.json", "--threads", 1)
    assert "scans/h" in text and not os.path.exists(f"{work}/told"), text
    bench = json.load(open(f"{work}/b.json"))
    assert bench["input"]["scans"] == 1 and bench["runs"][0]["scans_per_hour"] > 0
    assert {"reduce", "stars", "verify"} <= {stage["name"] for stage in bench["runs"][0]["stages"]}
    for key in ("median", "least"):  # an earlier build that took a twentieth
        bench["runs"][0]["yardsticks"][key] /= 20
    json.dump(bench, open(f"{work}/faster.json", "w"))
    text = run("bench", job, "--repeat", 1, "--against", f"{work}/faster.json", "--threads", 1, want=4)
    assert "rejected: bench of" in text and "confirmed" in text, text
    assert "names its archive itself" in run("bench", job, "--file", "x.ply", want=2)
    for line in subprocess.run([SCANMILL, "bench", job, "--repeat", "1", "--threads", "1", "--json"], capture_output=True,
                               text=True, check=True).stdout.splitlines():
        json.loads(line)


def example_jobs_are_valid(work):
    root = os.environ["SCANMILL_ROOT"]
    for name in ("nightly", "ci", "throughput", "cluster"):
        text = open(f"{root}/jobs/{name}.yaml", encoding="utf-8").read()
        make_archive(f"{work}/{name}", ("sphere",))
        os.rename(f"{work}/{name}/sphere", f"{work}/{name}/handset")
        for archive in ("/srv/scans", "../archive/demo"):
            text = text.replace(f"archive: {archive}\n", f"archive: {name}\n")
        os.makedirs(f"{work}/{name}/castings")
        shutil.copytree(f"{work}/{name}/handset", f"{work}/{name}/x/castings/handset")
        os.rmdir(f"{work}/{name}/castings")
        open(f"{work}/{name}.yaml", "w").write(text)
        run("check", f"{work}/{name}.yaml")


if __name__ == "__main__":
    os.environ.pop("GITHUB_STEP_SUMMARY", None)
    with tempfile.TemporaryDirectory(prefix="scanmill-") as place:
        globals()[sys.argv[1]](place)
