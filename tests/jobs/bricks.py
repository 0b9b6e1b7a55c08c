#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scans that are cut into pieces and bricks, and scans that do not fit under the memory cap: the same bytes, nothing
lost by a kill, and never more memory than allowed.

bricks.py CASE        (environment: SCANMILL)
"""
import datetime
import glob
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import numpy

SCANMILL = os.environ["SCANMILL"]
FILES = ["mesh.stl", "mesh.ply", "record.h5", "preview-shaded.png"]


def make_cloud(path, points, radius=20.0, seed=1):
    """A noisy bumpy ball in scan lines, float32 binary PLY, written block by block."""
    rng = numpy.random.default_rng(seed)
    with open(path, "wb") as out:
        out.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
                  b"property float z\nend_header\n" % points)
        done = 0
        while done < points:
            n = numpy.arange(done, min(done + 1000000, points), dtype=numpy.float64)
            # A spiral from pole to pole; two turns back and forth, so that bins are met twice.
            t = (n * 2 / points) % 1.0
            z = 1 - 2 * t
            phi = n * 2.399963229728653 if points < 1000000 else n * (2 * numpy.pi / 3000.37)
            r = numpy.sqrt(numpy.maximum(0, 1 - z * z))
            d = numpy.stack([r * numpy.cos(phi), r * numpy.sin(phi), z], axis=1)
            bump = radius * (1 + 0.06 * d[:, 0] * d[:, 1] + 0.04 * d[:, 2] ** 3)
            p = d * bump[:, None] + rng.normal(0, 0.01, d.shape)
            out.write(p.astype("<f4").tobytes())
            done += len(n)


def write_job(path, archive, bin_mm, more=""):
    with open(path, "w") as out:
        out.write(f"scanmill: 1\narchive: {archive}\nsettle_s: 0\nlattice: {{bin_mm: {bin_mm}}}\n"
                  f"outputs: [stl, ply]\n{more}")


def run(job, out, *more, code=0):
    done = subprocess.run([SCANMILL, "run", job, "--out", out, "--progress", "none", *more], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == code, f"exit {done.returncode}, wanted {code}\n{done.stdout}"
    return done.stdout


def counts(out):
    with open(f"{out}/run.json") as file:
        return [scan["counts"] for scan in json.load(file)["scans"]]


def cpu_seconds(out):
    with open(f"{out}/run.json") as file:
        return sum(scan["cpu_seconds"] for scan in json.load(file)["scans"])


def same(a, b, name="part"):
    for file in FILES:
        with open(f"{a}/scans/{name}/{file}", "rb") as x, open(f"{b}/scans/{name}/{file}", "rb") as y:
            assert x.read() == y.read(), f"{file} of {b} differs from {a}"
    assert counts(a) == counts(b)


def check_times(out, pieces, batches):
    """Log and stages are those of all parts."""
    with open(f"{out}/run.json") as file:
        scan = json.load(file)["scans"][0]
    kinds = ["inputs", "map", "gather", "frame", "pick", "points", "thin", "settle", "stars", "mesh", "swap"]
    assert [stage for stage in scan["stage_seconds"] if stage in kinds] == kinds, scan
    assert list(scan["stage_cpu_seconds"]) == list(scan["stage_seconds"]), scan
    with open(f"{out}/run.json") as file:
        run_of = json.load(file)
    assert run_of["started"] <= scan["started"] <= scan["ended"] <= run_of["ended"], scan
    told = datetime.datetime.fromisoformat(scan["ended"]) - datetime.datetime.fromisoformat(scan["started"])
    assert abs(told.total_seconds() - scan["seconds"]) <= 1.1 and scan["seconds"] <= run_of["seconds"], scan
    assert scan["attempts"] == 1, scan
    stages = sum(scan["stage_cpu_seconds"].values())
    assert 0.8 * scan["cpu_seconds"] < stages <= scan["cpu_seconds"] + 0.01, scan
    with open(f"{out}/logs/part.log") as file:
        parts = [line.split()[2:4] for line in file if line.split()[1] == "part"]
    assert len([part for part in parts if part[0] == "map"]) == pieces, parts
    assert sorted(int(part[1]) for part in parts if part[0] == "frame") == list(range(batches)), parts


def cuts_change_no_byte(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 300000)
    write_job(f"{work}/job.yaml", "archive", 0.5)
    run(f"{work}/job.yaml", f"{work}/whole", "--threads", "1")
    for number, (edge, pieces, batches, threads, executor) in enumerate(
            [(8, 5, 64, 2, "local"), (32, 12, 7, 1, "local"), (64, 1, 3, 7, "inline"), (256, 3, 1, 2, "local")]):
        out = f"{work}/cut{number}"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        text = run(f"{work}/job.yaml", out, "--threads", str(threads), "--executor", executor, "--set",
                   f"brick.edge_bins={edge}", "--set", f"brick.pieces={pieces}", "--set", f"brick.batches={batches}")
        assert text.count("cut into 1 inputs") == 1, text
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        same(f"{work}/whole", out)
        check_times(out, pieces, batches)
        assert 0 < cpu_seconds(out) < 0.1 + spent, f"{cpu_seconds(out)} of {spent} CPU seconds of the {executor} run"
        assert not os.path.exists(f"{out}/work"), "parts stay behind"
        # Another time, the same content: no part is made, and none stays.
        os.utime(f"{work}/archive/part.ply")
        text = run(f"{work}/job.yaml", out, "--executor", executor, "--set", f"brick.edge_bins={edge}")
        assert "1 unchanged" in text and "cut into" not in text, text
        assert not os.path.exists(f"{out}/work"), "parts of a scan that is unchanged"
    # The paper's rules pick in one pass; edges are kept by a median over all bins.
    for number, keys in enumerate(["profile: paper\n", "reduce: {edge_aware: true}\n"]):
        write_job(f"{work}/job.yaml", "archive", 0.5, keys)
        run(f"{work}/job.yaml", f"{work}/whole{number}")
        run(f"{work}/job.yaml", f"{work}/keys{number}", "--set", "brick.edge_bins=16", "--set", "brick.pieces=4")
        same(f"{work}/whole{number}", f"{work}/keys{number}")


def parts_in(folder):
    """Files whose being there says that a task is done; those of `gather` come with its own, which is the last."""
    return [path for path in glob.glob(f"{folder}/*.part") if not os.path.basename(path).startswith("link")]


def kills_cost_the_parts_in_flight(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 300000)
    write_job(f"{work}/job.yaml", "archive", 0.5)
    run(f"{work}/job.yaml", f"{work}/whole")
    cut = ["--set", "brick.edge_bins=8", "--set", "brick.pieces=9", "--set", "brick.batches=16", "--threads", "2"]
    out = f"{work}/cut"
    folder = f"{out}/work/parts/part"
    there, gone = {}, set()
    # Killed when this many parts of a kind are there.
    for kind, wanted in [("map", 1), ("map", 4), ("gather", 1), ("frame", 3), ("frame", 9), ("frame", 16), ("pick", 2),
                         ("pick", 7), ("points", 1), ("thin", 2), ("thin", 11), ("settle", 1), ("stars", 5), ("stars", 14),
                         ("mesh", 1), ("swap", 3), ("swap", 12), ("join", 1), ("verify", 1), ("verify", 3)]:
        running = subprocess.Popen([SCANMILL, "run", f"{work}/job.yaml", "--out", out, "--progress", "none", *cut],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        while running.poll() is None and len(glob.glob(f"{folder}/{kind}*.part")) < wanted:
            time.sleep(0.001)
        os.killpg(running.pid, signal.SIGKILL)
        running.wait()
        time.sleep(0.05)
        if wanted > 1:  # cleaning up costs no part of a scan that is to be made
            text = subprocess.run([SCANMILL, "gc", out], text=True, stdout=subprocess.PIPE, check=True).stdout
            assert "of parts of 1 scan to be made" in text, text
        now = {path: os.stat(path).st_mtime_ns for path in parts_in(folder)}
        assert now, "everything was done before the kill"
        for path, stamp in there.items():
            assert now.get(path, stamp) == stamp, f"{path} was there before the kill and was made again"
        gone |= set(there) - set(now)
        assert not gone & set(now), f"{gone & set(now)} had no reader left and was made again"
        there = now
        short = {("frame", 3): "map-4", ("thin", 2): "gather", ("stars", 5): "points", ("verify", 1): "settle"}.get((kind, wanted))
        if short:  # what a sick disk cut short is not believed, and what it was made of is made again
            os.truncate(f"{folder}/{short}.part", os.path.getsize(f"{folder}/{short}.part") // 2)
            there, gone = {}, set()
    names = {os.path.basename(path) for path in now}
    assert not [name for name in names if name.split("-")[0] in ("map", "frame", "pick", "thin", "stars", "mesh.part", "swap")], names
    run(f"{work}/job.yaml", out, *cut)
    same(f"{work}/whole", out)


def two_workers_share_the_tasks(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 300000)
    write_job(f"{work}/job.yaml", "archive", 0.5, "brick: {edge_bins: 8, pieces: 6, batches: 64}\n")
    write_job(f"{work}/plain.yaml", "archive", 0.5)
    run(f"{work}/plain.yaml", f"{work}/whole")
    out = f"{work}/out"
    done = subprocess.run([SCANMILL, "worklist", f"{work}/job.yaml", "--out", out, "--tasks", "3"], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    assert done.returncode == 0 and "--tasks 3 holds for scans in one piece" in done.stdout, done.stdout
    path = glob.glob(f"{out}/work/*/tasks.json")[0]
    with open(path) as file:
        tasks = json.load(file)["tasks"]
    assert len(tasks) == 1 + 6 + 1 + 64 + 6 + 1 + 64 + 1 + 64 + 1 + 64 + 1 + 4 + 1, len(tasks)

    def begin(index):
        return subprocess.Popen([SCANMILL, "task", path, str(index), "--threads", "1", "--quiet"],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    # A task whose time has not come says what is missing, and that it can be tried again.
    early = begin(7)  # gather, behind inputs and the six pieces
    text = early.communicate()[0]
    assert early.returncode == 75 and "the task 'map" in text, (early.returncode, text)
    assert f"part gather comes too early; the task 'map 0' is first: scanmill task {path} 1, then" in text, text
    assert "failed" not in text, text
    killed = 0
    for wave in sorted({task["wave"] for task in tasks}):
        left = [index for index, task in enumerate(tasks) if task["wave"] == wave]
        running = {}
        while left or running:
            while left and len(running) < 2:
                index = left.pop()
                running[index] = begin(index)
                if killed < 5 and index % 3 == 0:  # one of the two is killed, now and then, and redone
                    time.sleep(0.004 * killed)
                    running[index].kill()
                    killed += 1
            for index, process in list(running.items()):
                if process.poll() is None:
                    continue
                text = process.communicate()[0]
                del running[index]
                if process.returncode < 0:
                    left.append(index)
                else:
                    assert process.returncode == 0, f"task {index}: exit {process.returncode}\n{text}"
            time.sleep(0.002)
    assert killed == 5
    text = run(f"{work}/job.yaml", out)
    assert "1 unchanged" in text, text
    gone = begin(7)
    text = gone.communicate()[0]
    assert gone.returncode == 2 and "a run, a cancel or another worklist of this output takes it back" in text, text
    assert not os.path.exists(f"{out}/work/parts"), "parts of a scan that is done"
    for file in FILES:
        with open(f"{work}/whole/scans/part/{file}", "rb") as x, open(f"{out}/scans/part/{file}", "rb") as y:
            assert x.read() == y.read(), file


def tree_memory(pid):
    """Resident bytes of a process and all below it."""
    total, todo = 0, [pid]
    while todo:
        at = todo.pop()
        try:
            with open(f"/proc/{at}/statm") as file:
                total += int(file.read().split()[1]) * 4096
            for children in glob.glob(f"/proc/{at}/task/*/children"):
                with open(children) as file:
                    todo += [int(child) for child in file.read().split()]
        except (FileNotFoundError, ProcessLookupError):
            pass
    return total


def peak_of(job, out, *more):
    running = subprocess.Popen([SCANMILL, "run", job, "--out", out, "--progress", "none", *more],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    peak = 0
    while running.poll() is None:
        peak = max(peak, tree_memory(running.pid))
        time.sleep(0.01)
    text = running.stdout.read()
    assert running.returncode == 0, f"exit {running.returncode}\n{text}"
    return peak


def memory_stays_under_the_cap(work):
    cap = 256 << 20
    os.mkdir(f"{work}/archive")
    write_job(f"{work}/job.yaml", "archive", 0.13)  # about 400,000 bins
    peaks = []
    for points in [10000000, 20000000]:
        make_cloud(f"{work}/archive/part.ply", points)
        peaks.append(peak_of(f"{work}/job.yaml", f"{work}/out", "--threads", "2", "--memory", "256M"))
        print(f"{points} points: {peaks[-1] / (1 << 20):.1f} MiB at the most, {counts(work + '/out')[0]['bins']} bins")
    assert max(peaks) <= cap, peaks
    assert peaks[1] <= 1.05 * peaks[0], peaks
    with open(f"{work}/out/logs/part.log") as file:
        assert "memory beyond the cap" in file.read(), "this did not need the cap"
    run(f"{work}/job.yaml", f"{work}/free", "--threads", "2")
    same(f"{work}/free", f"{work}/out")


def points_in_no_order_are_gathered(work):
    os.mkdir(f"{work}/archive")
    path = f"{work}/archive/part.ply"
    make_cloud(path, 1500000)
    with open(path, "rb") as file:
        head, points = file.read().split(b"end_header\n", 1)
    points = numpy.random.default_rng(5).permutation(numpy.frombuffer(points, "V12"))
    with open(path, "wb") as file:
        file.write(head + b"end_header\n" + points.tobytes())
    write_job(f"{work}/job.yaml", "archive", 0.15)
    run(f"{work}/job.yaml", f"{work}/free", "--threads", "2")
    peak = peak_of(f"{work}/job.yaml", f"{work}/out", "--threads", "2", "--memory", "144M")
    assert peak <= 144 << 20, peak
    same(f"{work}/free", f"{work}/out")
    with open(f"{work}/out/logs/part.log") as file:
        log = file.read()
    assert "stage gather" in log and "memory beyond the cap" in log, log


def wrong_units_are_said_once_all_was_seen(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 100000, radius=0.2)
    write_job(f"{work}/job.yaml", "archive", 0.004)
    text = run(f"{work}/job.yaml", f"{work}/out", "--set", "brick.edge_bins=32", "--set", "brick.pieces=2", code=3)
    assert "set units to" in text, text
    with open(f"{work}/out/logs/part.log") as file:
        log = file.read()
    assert "part gather failed" in log and "frame" not in log, log


def a_cap_below_the_processes_is_refused(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 1000)
    write_job(f"{work}/job.yaml", "archive", 2)
    text = run(f"{work}/job.yaml", f"{work}/out", "--threads", "2", "--memory", "64M", code=2)
    assert "64 MiB" in text and "needs 124 MiB" in text, text


def disk_beside_memory_is_limited(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 3000000)
    write_job(f"{work}/job.yaml", "archive", 0.1)
    text = run(f"{work}/job.yaml", f"{work}/out", "--threads", "2", "--memory", "160M", "--disk", "100M", code=3)
    assert "more than the 100 MiB of disk allowed" in text, text
    assert not glob.glob(f"{work}/out/scans/*/mesh.stl")
    run(f"{work}/job.yaml", f"{work}/out", "--threads", "2", "--memory", "160M", "--only", "part")
    assert glob.glob(f"{work}/out/scans/*/mesh.stl")


def a_scan_that_will_not_fit_is_refused_with_numbers(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 20000000)
    write_job(f"{work}/job.yaml", "archive", 0.1)
    begin = time.monotonic()
    text = run(f"{work}/job.yaml", f"{work}/out", "--threads", "2", "--memory", "256M", "--disk", "300M", code=3)
    assert "bins are occupied, which need" in text and "300 MiB of disk beside it" in text, text
    with open(f"{work}/out/logs/part.log") as file:
        assert "stage reduce" not in file.read()
    said = int(text.split("about ")[1].split(" bins")[0].replace(",", ""))
    assert 500000 < said < 1000000, said
    print(f"{said} bins forecast, refused after {time.monotonic() - begin:.1f} s")


def dry(work, *more):
    tree = json.loads(run(f"{work}/job.yaml", f"{work}/dry", "--dag", "json", "--quiet", *more))
    assert not os.path.exists(f"{work}/dry"), "a dry run wrote something"
    return tree["tasks"][0]


def bytes_below(folder):
    total = 0
    for place, _, files in os.walk(folder):
        for file in files:
            try:
                total += os.stat(os.path.join(place, file)).st_blocks * 512
            except FileNotFoundError:
                pass
    return total


def parts_take_what_was_forecast(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 300000)
    write_job(f"{work}/job.yaml", "archive", 0.2)
    out = f"{work}/out"
    for edge, pieces, batches in [(64, 7, 8), (8, 1, 3)]:
        cut = ["--set", f"brick.edge_bins={edge}", "--set", f"brick.pieces={pieces}", "--set", f"brick.batches={batches}"]
        task = dry(work, *cut)
        running = subprocess.Popen([SCANMILL, "run", f"{work}/job.yaml", "--out", out, "--progress", "none", "--threads", "1",
                                    *cut], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        peak = 0
        while running.poll() is None:
            peak = max(peak, bytes_below(f"{out}/work"))
            time.sleep(0.005)
        text = running.communicate()[0]
        assert running.returncode == 0, text
        told = re.search(r"cut into (.*): \d+ parts", text)[1]
        waves = [f"{wave['tasks']} {wave['kind']}" for wave in task["waves"]]
        assert waves[-1] == "1 the scan itself" and ", ".join(waves[:-1]) == told, (waves, told)
        assert task["disk_bytes"] == max(wave["disk_bytes"] for wave in task["waves"])
        assert all(wave["memory_bytes"] > 0 for wave in task["waves"]) and task["waves"][1]["cpu_seconds"] is None, task
        print(f"forecast {task['disk_bytes']} bytes, {peak} seen")
        assert peak <= task["disk_bytes"] <= 2 * peak, (task, peak)
        again = dry(work, "--set", "lattice.bin_mm=0.3", *cut)
        shutil.copytree(f"{out}/journal", f"{work}/dry/journal")  # the speed of a run is known then
        known = json.loads(run(f"{work}/job.yaml", f"{work}/dry", "--dag", "json", "--quiet", *cut))
        shares = sum(wave["cpu_seconds"] for wave in known["tasks"][0]["waves"])
        assert abs(shares / (known["seconds"] * known["cores"]) - 1) < 1e-6, known
        assert again["disk_bytes"] < task["disk_bytes"]
        shutil.rmtree(f"{work}/dry")
        shutil.rmtree(out)


def parts_that_will_not_fit_are_refused_with_numbers(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 300000)
    write_job(f"{work}/job.yaml", "archive", 0.2, "brick: {edge_bins: 32, pieces: 5, batches: 6}\n")
    run(f"{work}/job.yaml", f"{work}/whole", "--set", "brick.edge_bins=auto")
    out = f"{work}/out"
    wants = dry(work)["disk_bytes"]
    text = run(f"{work}/job.yaml", out, "--disk", "20M", code=3)
    said = re.search(r"disk: about ([\d,]+) bins are occupied: parts and results need ([\d.]+) MiB of disk at one time; "
                     r"found ([\d.]+) MiB of the 20 MiB that resources.disk \(--disk\) allows the run", text)
    assert said, text
    assert 1 <= int(said[1].replace(",", "")) / counts(f"{work}/whole")[0]["bins"] < 1.01, text
    assert 0.99 * wants < float(said[2]) * (1 << 20) < 1.01 * wants, (text, wants)
    assert "tried again" not in text and not glob.glob(f"{out}/work/parts/part/map*"), text
    with open(f"{out}/run.json") as file:
        assert json.load(file)["scans"][0]["error"]["class"] == "resource"
    assert "1 quarantined" in run(f"{work}/job.yaml", out, "--disk", "20M")
    text = run(f"{work}/job.yaml", out, "--disk", f"{wants * 2}")
    assert "1 done" in text, text
    same(f"{work}/whole", out)


def a_disk_that_fills_up_stops_the_run_and_it_goes_on(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 1000000)
    write_job(f"{work}/job.yaml", "archive", 0.15, "brick: {edge_bins: 32, pieces: 5, batches: 40}\n")
    run(f"{work}/job.yaml", f"{work}/whole", "--set", "brick.edge_bins=auto")
    out = f"{work}/out"
    folder = f"{out}/work/parts/part"
    running = subprocess.Popen([SCANMILL, "run", f"{work}/job.yaml", "--out", out, "--progress", "none", "--threads", "1",
                                "--disk", "1G"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    while running.poll() is None and not glob.glob(f"{folder}/map-0.part"):
        time.sleep(0.001)
    with open(f"{work}/other", "wb") as other:  # somebody else's
        os.posix_fallocate(other.fileno(), 0, 2 << 30)
    text = running.communicate()[0]
    os.remove(f"{work}/other")
    assert running.returncode == 1, (running.returncode, text)
    assert "resources.disk (--disk) allows the run" in text and "run again: what is done is kept" in text, text
    there = {path: os.stat(path).st_mtime_ns for path in parts_in(folder)}
    assert f"{folder}/map-0.part" in there, there
    kept = sum(os.path.getsize(path) for path in glob.glob(f"{folder}/*"))
    text = run(f"{work}/job.yaml", out, "--disk", str(kept + (4 << 20)), code=1)
    left = re.search(r"allows the run ([\d.]+) MiB are left", text)
    assert left and 3 < float(left[1]) <= 4, f"{kept} bytes of parts are there, {text}"
    run(f"{work}/job.yaml", out, "--disk", "1G")
    same(f"{work}/whole", out)
    with open(f"{out}/run.json") as file:
        took = json.load(file)["scans"][0]
    assert took["cpu_seconds"] < sum(took["stage_cpu_seconds"].values()), "parts of the run before are left out"


def a_file_that_changes_is_made_by_the_next_run(work):
    os.mkdir(f"{work}/archive")
    path = f"{work}/archive/part.ply"
    make_cloud(path, 1000000)
    write_job(f"{work}/job.yaml", "archive", 0.3, "brick: {edge_bins: 32, pieces: 4, batches: 6}\n")
    for executor in ["local", "inline"]:
        os.utime(path, (1e9, 1e9))
        out = f"{work}/{executor}"
        running = subprocess.Popen([SCANMILL, "run", f"{work}/job.yaml", "--out", out, "--progress", "none", "--threads", "1",
                                    "--executor", executor], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        while running.poll() is None and len(glob.glob(f"{out}/work/parts/part/stars*.part")) < 6:
            time.sleep(0.001)
        time.sleep(0.1)  # `mesh`, which takes long, is at work by now
        with open(path, "r+b") as file:
            file.seek(-5, os.SEEK_END)
            byte = file.read(1)
            file.seek(-5, os.SEEK_END)
            file.write(bytes([byte[0] ^ 1]))
        text = running.communicate()[0]
        assert running.returncode == 3 and "the file changed while it was read" in text, (running.returncode, text)
        with open(f"{out}/run.json") as file:
            error = json.load(file)["scans"][0]["error"]
        assert error["class"] == "bad_input", error
        mixed = f"{out}/work/parts/part/{error['stage'].replace(' ', '-')}.part"
        assert not os.path.exists(mixed), f"{mixed} is made of two states of the file"
        text = run(f"{work}/job.yaml", out, "--threads", "2")
        assert "1 done" in text, text
        with open(f"{out}/quarantine.json") as file:
            assert json.load(file) == {}
        run(f"{work}/job.yaml", f"{work}/whole", "--set", "brick.edge_bins=auto")
        same(f"{work}/whole", out)


def progress_counts_the_parts(work):
    os.mkdir(f"{work}/archive")
    make_cloud(f"{work}/archive/part.ply", 300000)
    write_job(f"{work}/job.yaml", "archive", 0.5, "brick: {edge_bins: 8, pieces: 5, batches: 6}\n")
    out = f"{work}/out"
    running = subprocess.Popen([SCANMILL, "run", f"{work}/job.yaml", "--out", out, "--progress", "none", "--threads", "1"],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    while running.poll() is None and not glob.glob(f"{out}/work/parts/part/stars*.part"):
        time.sleep(0.001)
    for request in (signal.SIGUSR1, signal.SIGUSR1, signal.SIGUSR1, signal.SIGTERM):  # one may fall between two parts
        running.send_signal(request)
        time.sleep(0.015)
    text = running.communicate()[0]
    assert running.returncode == 143, (running.returncode, text)
    shown = re.search(r"(\d+) of (\d+) parts done", text)
    assert shown and 0 < int(shown[1]) < int(shown[2]), text
    percent = re.search(r"(\d+) % of ", text)
    run(f"{work}/job.yaml", f"{work}/full")
    shutil.copytree(f"{work}/full/journal", f"{work}/dry/journal")  # the speed of a run is known then
    known = json.loads(run(f"{work}/job.yaml", f"{work}/dry", "--dag", "json", "--quiet"))["tasks"][0]["waves"]
    each = [wave["cpu_seconds"] / wave["tasks"] for wave in known for _ in range(wave["tasks"])]
    assert percent and abs(int(percent[1]) - 100 * sum(each[:int(shown[1])]) / sum(each)) <= 1, (text, each)
    assert "stopping" not in text or "stopping: 1 part of 1 scan is brought to the end" in text, text
    assert "0 done, 1 running (" in text and "0 waiting |" in text, text
    said = subprocess.run([SCANMILL, "status", out], text=True, stdout=subprocess.PIPE, check=True).stdout
    assert re.search(r"partly made: part \(\d+ parts, [\d.]+ MiB\); the next run goes on from there", said), said


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-") as folder:
        globals()[sys.argv[1]](folder)
