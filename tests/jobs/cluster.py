#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Jobs on a real Slurm of four nodes on this machine, and what befalls clusters: each ends with the bytes of a local run.

cluster.py CASE        (SCANMILL: the program, SCANMILL_ROOT: the source tree)
"""
import glob
import hashlib
import json
import math
import os
import resource
import signal
import subprocess
import sys
import time

from cases import run_case

SCANMILL, ROOT = os.environ["SCANMILL"], os.environ["SCANMILL_ROOT"]
CLUSTER = f"{ROOT}/scripts/test_cluster.sh"
KEYS = "settle_s: 0\nlattice: {bin_mm: 1.5}\nretry: {wait_s: 0.05}\npreviews: [shaded]\n"
QUICK = "poll_s: 0.3, lease_s: 4"


class Lab:
    """An archive, a job and a cluster in a folder; the cluster ends with the block."""

    def __init__(self, work, scans, cluster="", side=40, nodes=4, quick=QUICK):
        self.work, self.nodes, self.quick = work, nodes, quick
        os.makedirs(f"{work}/archive/deep")
        self.scans = [f"{'deep/' if k % 3 == 0 else ''}part-{k:03d}" for k in range(scans)]
        for k, scan in enumerate(self.scans):
            rows = side + k % 7
            with open(f"{work}/archive/{scan}.xyz", "w") as out:
                out.writelines(f"{0.5 * i} {0.5 * j} {math.sin(0.07 * i + k) * math.cos(0.05 * j):.6f}\n"
                               for i in range(rows) for j in range(rows))
        with open(f"{work}/wrap.sh", "w") as out:  # the fault, until the file `once` is there
            out.write(f'#!/bin/sh\n[ -e "{work}/once" ] || export SCANMILL_TEST_FAULT="$LAB_FAULT"\n'
                      'sleep "${LAB_SLEEP:-0}"\nexec "$@"\n')
        os.chmod(f"{work}/wrap.sh", 0o755)
        self.write_job(cluster)
        self.environment = dict(os.environ, SLURM_CONF=f"{work}/slurm/slurm.conf")

    def write_job(self, cluster, more=""):
        with open(f"{self.work}/job.yaml", "w") as out:
            out.write(f"scanmill: 1\narchive: archive\n{KEYS}{more}executor: slurm\n"
                      f"cluster: {{{self.quick}, wrap: [{self.work}/wrap.sh]{', ' if cluster else ''}{cluster}}}\n")

    def __enter__(self):
        subprocess.run([CLUSTER, "start", f"{self.work}/slurm", str(self.nodes)], check=True)
        return self

    def __exit__(self, *_):
        subprocess.run([CLUSTER, "stop", f"{self.work}/slurm"], check=True)

    def local(self):
        done = subprocess.run([SCANMILL, "run", "job.yaml", "--out", "local", "--executor", "local", "--quiet"], cwd=self.work,
                              capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr

    def start(self, *words, fault="", sleep=0, out="out"):
        environment = dict(self.environment, LAB_FAULT=fault, LAB_SLEEP=str(sleep))
        return subprocess.Popen([SCANMILL, "run", "job.yaml", "--out", out, "--progress", "none", *words], cwd=self.work, text=True,
                                env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def call(self, *words, check=True):
        return subprocess.run(words, env=self.environment, cwd=self.work, capture_output=True, text=True, check=check, timeout=60).stdout

    def queue(self, *words):
        """Rows of (array element, state, node) of everything that Slurm remembers."""
        text = self.call("squeue", "-h", "-r", "-t", "all", "-o", "%i|%T|%N", *words)
        return [tuple(line.split("|")) for line in text.splitlines()]

    def hanging(self, scan):
        """(element, node) of the scan that hangs, once it does."""
        found = []

        def look():
            for path in glob.glob(f"{self.work}/out/work/*/*.alive"):
                try:
                    with open(path) as file:
                        beat = json.load(file)
                    with open(f"{os.path.dirname(path)}/tasks.json") as file:
                        tasks = json.load(file)["tasks"]
                except (OSError, ValueError):
                    continue
                job, index = beat["engine"].split()[1].split("_")
                if tasks[int(index)]["items"][beat["item"]]["scan"] == scan:
                    rows = [row for row in self.queue() if row[0] == f"{job}_{index}" and row[1] == "RUNNING"]
                    found.extend((row[0], row[2]) for row in rows)
            return bool(found) and time.sleep(0.7) is None
        wait_for(look)
        return found[-1]

    def states(self, out="out"):
        with open(f"{self.work}/{out}/run.json") as file:
            return {scan["name"]: scan for scan in json.load(file)["scans"]}

    def same_as_local(self, out="out"):
        mine, wanted = results(f"{self.work}/{out}"), results(f"{self.work}/local")
        assert mine.keys() == wanted.keys(), mine.keys() ^ wanted.keys()
        different = [name for name in wanted if mine[name] != wanted[name]]
        assert not different, f"other bytes: {different[:5]}"
        left = [path for path in glob.glob(f"{self.work}/{out}/scans/**/.*", recursive=True) if os.path.isdir(path)]
        assert not left, left
        assert not glob.glob(f"{self.work}/{out}/work/*"), "waves are put away"

    def all_done_once(self, text=""):
        states = self.states()
        assert {scan["state"] for scan in states.values()} == {"done"}, (text, states)
        twice = [name for name, scan in states.items() if scan["attempts"] != 1]
        assert not twice, f"counted twice: {twice}\n{text}"


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def results(tree):
    """Every file of every scan but those that say when it was made."""
    return {os.path.relpath(f"{folder}/{name}", tree): digest(f"{folder}/{name}")
            for folder, _, names in os.walk(f"{tree}/scans") for name in names if name not in ("report.html", ".state.json")}


def ended(run, want, seconds=180):
    text = run.communicate(timeout=seconds)[0]
    assert run.returncode == want, f"exit {run.returncode}, wanted {want}\n{text}"
    return text


def wait_for(what, seconds=120):
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)


def an_archive_of_50_scans_gives_the_bytes_of_a_local_run(work):
    with Lab(work, 50, "spread: 12", side=24) as lab:
        lab.local()
        text = ended(lab.start(), 0)
        lab.same_as_local()
        lab.all_done_once(text)
        assert len(lab.queue()) == 12, lab.queue()
        assert "50 unchanged" in ended(lab.start(), 0), "a second night has nothing to do"


def one_scan_as_bricks_gives_the_bytes_of_a_local_run(work, disturb=None):
    """Inputs, four passes over pieces, their joining, 27 batches of bricks, four passes more, all points, 27 batches
    thinned, what is left settled, 27 batches of stars, the mesh, 27 batches of swaps, all joined, four passes of
    verification, and the scan: each an element."""
    with Lab(work, 1, side=150) as lab:
        lab.local()
        lab.write_job("spread: 27", "brick: {edge_bins: 8, pieces: 4, batches: 27}\n")
        run = lab.start(sleep=0.2 if disturb else 0)
        if disturb:
            run = disturb(lab, run) or run
        text = ended(run, 0)
        assert "1 done" in text, text
        lab.same_as_local()
        assert not os.path.exists(f"{work}/out/work"), "parts stay behind"
        if not disturb:
            assert len(lab.queue()) == 1 + 4 + 1 + 27 + 4 + 1 + 27 + 1 + 27 + 1 + 27 + 1 + 4 + 1, lab.queue()


def a_driver_that_is_killed_between_bricks_goes_on(work):
    def kill_driver(lab, run):
        wait_for(lambda: len(glob.glob(f"{work}/out/work/parts/**/frame-*.part", recursive=True)) >= 3)
        run.kill()
        run.wait()
        return lab.start(sleep=0.2)
    one_scan_as_bricks_gives_the_bytes_of_a_local_run(work, kill_driver)


def a_node_lost_between_bricks_costs_time_only(work):
    def lose_node(lab, run):
        wait_for(lambda: len(glob.glob(f"{work}/out/work/parts/**/frame-*.part", recursive=True)) >= 3)
        busy = [row[2] for row in lab.queue() if row[1] == "RUNNING" and row[2]]
        lab.call("scontrol", "update", f"nodename={busy[0] if busy else 'n1'}", "state=down", "reason=test")
    one_scan_as_bricks_gives_the_bytes_of_a_local_run(work, lose_node)


def a_driver_inside_a_batch_job_hands_work_in(work):
    with Lab(work, 6, "spread: 3") as lab:
        lab.local()
        script = f"{work}/inner.sh"
        with open(script, "w") as out:
            out.write(f'#!/bin/sh\ncd "{work}" && "{SCANMILL}" run job.yaml --out out --progress none >inner.log 2>&1\necho $? >inner.code\n')
        # Variables that sbatch and squeue would take for options, as a job or a profile sets them.
        lab.environment.update(SBATCH_PARTITION="nowhere", SQUEUE_STATES="FAILED", LAB_FAULT="", LAB_SLEEP="0")
        lab.call("sbatch", "-p", "main", "--mem=300", "-t", "5", "-n", "1", "-o", f"{work}/batch.log", script)
        wait_for(lambda: os.path.exists(f"{work}/inner.code") and open(f"{work}/inner.code").read().strip())
        assert open(f"{work}/inner.code").read().strip() == "0", open(f"{work}/inner.log").read()
        lab.same_as_local()


def hang_and(work, disturb, want_note, label="part-004", cluster=""):
    """The scan hangs, something befalls its element, and the run goes on."""
    with Lab(work, 8, f"spread: 4{', ' if cluster else ''}{cluster}") as lab:
        lab.local()
        run = lab.start(fault=f"hang:{label}")
        element, node = lab.hanging(label)
        open(f"{work}/once", "w").close()
        disturb(lab, element, node)
        text = ended(run, 0)
        assert want_note in text, text
        lab.same_as_local()
        lab.all_done_once(text)


def a_node_that_goes_down_costs_time_only(work):
    hang_and(work, lambda lab, element, node: lab.call("scontrol", "update", f"nodename={node}", "state=down", "reason=test"),
             "was lost (NODE_FAIL) on n")


def a_node_that_dies_costs_time_only(work):
    hang_and(work, lambda lab, element, node: lab.call(CLUSTER, "kill", f"{work}/slurm", node), "submitted again")


def an_element_that_somebody_cancels_is_submitted_again(work):
    hang_and(work, lambda lab, element, node: lab.call("scancel", element), "was cancelled by somebody else; submitted again")


def an_administrators_requeue_changes_nothing(work):
    def requeue(lab, element, node):
        job = [word.split("=")[1] for word in lab.call("scontrol", "show", "job", element).split() if word.startswith("JobId=")][0]
        lab.call("scontrol", "requeue", job)
    hang_and(work, requeue, "8 done", cluster="extra: --requeue")


def a_controller_that_is_killed_forgets_and_nothing_is_lost(work):
    with Lab(work, 8, "spread: 4") as lab:
        lab.local()
        run = lab.start(sleep=1)
        wait_for(lambda: lab.queue())
        time.sleep(0.5)
        lab.call(CLUSTER, "kill-controller", f"{work}/slurm")
        time.sleep(2)
        lab.call(CLUSTER, "start-controller", f"{work}/slurm")
        text = ended(run, 0)
        lab.same_as_local()
        lab.all_done_once(text)


def forgetful_controller(work, want_note, before=lambda lab: None):
    """Killed so soon after the submission that nothing of it is saved, while elements wait for a place, and down for 20 s."""
    with Lab(work, 40, "scans_per_element: 1") as lab:
        lab.local()
        before(lab)
        run = lab.start(sleep=8)
        wait_for(lambda: sum(row[1] == "RUNNING" for row in lab.queue()) >= 12)
        assert any(row[1] == "PENDING" for row in lab.queue()), lab.queue()
        time.sleep(0.2)
        lab.call(CLUSTER, "kill-controller", f"{work}/slurm")
        time.sleep(20)
        lab.call(CLUSTER, "start-controller", f"{work}/slurm")
        try:
            text = ended(run, 0, 240)
        finally:
            run.kill()
        assert want_note in text and "please report" not in text, text
        lab.same_as_local()
        lab.all_done_once(text)
        drained = lab.call("sinfo", "-h", "--list-reasons", "-o", "%N %E")
        assert not drained, f"{drained}\n{text}"


def a_controller_that_forgets_what_began_costs_time_only(work):
    """It knows the array from before its elements began, and would start them again under numbers that the nodes know."""
    forgetful_controller(work, "Slurm forgot that 16 elements of array 1 began")


def a_controller_that_forgets_a_whole_array_costs_time_only(work):
    """It saved its state just before, and would give the array's numbers out again."""
    def save(lab):
        lab.call("sbatch", "--hold", "-p", "main", "--mem=100", "-o", "/dev/null", "--wrap", "true")
        time.sleep(0.3)
    forgetful_controller(work, "vanished without a sign; submitted again", save)


def a_controller_that_is_down_at_submission_is_waited_for(work):
    with Lab(work, 4, "spread: 2") as lab:
        lab.local()
        lab.call(CLUSTER, "kill-controller", f"{work}/slurm")
        lab.write_job("spread: 2", "resources: {memory: 1G}\n")
        run = lab.start()
        time.sleep(3)
        lab.call(CLUSTER, "start-controller", f"{work}/slurm")
        ended(run, 0)
        lab.same_as_local()


def a_driver_that_is_killed_is_started_again_and_takes_over(work):
    with Lab(work, 12, "spread: 6") as lab:
        lab.local()
        run = lab.start(sleep=3)
        wait_for(lambda: len(lab.queue()) == 6)
        time.sleep(0.3)
        run.kill()
        run.wait()
        before = lab.queue()
        text = ended(lab.start(sleep=3), 0)
        assert "taking over 6 elements of 1 array" in text, text
        assert {row[0] for row in lab.queue()} == {row[0] for row in before}, "nothing is submitted twice"
        lab.same_as_local()
        lab.all_done_once(text)


def cancel_takes_back_what_a_dead_driver_left(work):
    with Lab(work, 6, "spread: 3") as lab:
        run = lab.start(sleep=60)
        wait_for(lambda: len(lab.queue()) == 3)
        run.kill()
        run.wait()
        said = lab.call(SCANMILL, "cancel", "out")
        assert "took back 1 array" in said, said
        wait_for(lambda: not lab.queue("-t", "RUNNING,PENDING"))
        assert not os.path.exists(f"{work}/out/work"), os.listdir(f"{work}/out/work")


def a_request_to_stop_drains_and_the_next_run_goes_on(work):
    with Lab(work, 16, "scans_per_element: 1", nodes=1) as lab:
        lab.local()
        run = lab.start(sleep=0.3)
        wait_for(lambda: any(row[1] == "COMPLETED" for row in lab.queue()))
        assert any(row[1] == "PENDING" for row in lab.queue())
        run.send_signal(signal.SIGTERM)
        ended(run, 143)
        assert not [row for row in lab.queue() if row[1] in ("PENDING", "RUNNING")]
        made = [name for name, scan in lab.states().items() if scan["state"] == "done"]
        waits = [name for name, scan in lab.states().items() if scan["state"] == "pending"]
        assert made and waits and len(made) + len(waits) == 16, lab.states()
        text = ended(lab.start(), 0)
        assert f"{len(made)} unchanged, {len(waits)} done" in text, text
        lab.same_as_local()


def what_slurm_refuses_ends_with_6_and_its_words(work):
    with Lab(work, 2, "partition: nowhere") as lab:
        text = ended(lab.start("--set", "resources.memory=1G"), 6)
        assert "invalid partition specified: nowhere" in text and "exit 6" in text, text
        lab.write_job("program: /no/such/scanmill")
        text = ended(lab.start(), 6)
        assert "cluster.program" in text and "not found" in text, text
        for option, words in ("--frobnicate", "unrecognized option"), ("--mem=lots", "Invalid --mem"):  # sbatch ends with 255
            lab.write_job(f"extra: [{option}]")
            text = ended(lab.start(), 6, 30)
            assert words in text and "sbatch refused the work" in text, text


def bad_scans_cost_only_themselves(work):
    with Lab(work, 5, "spread: 3") as lab:
        with open(f"{work}/archive/broken.ply", "w") as out:
            out.write("ply\nformat ascii 1.0\nelement vertex 100\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2\n")
        lab.write_job("spread: 3", "resources: {memory: 400M}\n")
        text = ended(lab.start(fault="crash:part-001,hog:part-002"), 3)
        states = lab.states()
        got = {name: (scan["state"], scan["error"]["class"] if "error" in scan else "") for name, scan in states.items()}
        assert got == {"broken": ("failed", "bad_input"), "part-001": ("failed", "internal"), "part-002": ("failed", "resource"),
                       "deep/part-000": ("done", ""), "deep/part-003": ("done", ""), "part-004": ("done", "")}, (got, text)
        assert states["part-001"]["attempts"] == 2, states["part-001"]


def a_time_limit_ends_a_scan_that_hangs(work):
    with Lab(work, 4, "spread: 4, time: 1m") as lab:
        text = ended(lab.start(fault="hang:part-002"), 3, 400)
        scan = lab.states()["part-002"]
        assert scan["state"] == "failed" and "cluster.time" in scan["error"]["text"], (scan, text)
        assert sum(one["state"] == "done" for one in lab.states().values()) == 3


def three_hundred_elements_cost_the_driver_little(work):
    with Lab(work, 300, "scans_per_element: 1", side=24, quick="poll_s: 2, lease_s: 30") as lab:
        begun = time.monotonic()
        run = lab.start()
        text = run.communicate(timeout=900)[0]
        spent = resource.getrusage(resource.RUSAGE_CHILDREN)  # the driver with its sbatch, squeue and scancel; nothing else was waited for
        cpu = spent.ru_utime + spent.ru_stime
        assert run.returncode == 0, text[-2000:]
        print(f"300 elements: {time.monotonic() - begun:.1f} s, driver with its commands {cpu:.2f} s of CPU (with the cluster's start)")
        assert cpu < 5, cpu
        assert len(lab.queue()) == 300
        lab.all_done_once()


if subprocess.run([CLUSTER, "is-there"]).returncode == 77:
    print("skipped: Slurm is not installed (./test.sh installs it)")
    sys.exit(77)
run_case([value for value in list(globals().values()) if callable(value) and getattr(value, "__module__", "") == "__main__"])
