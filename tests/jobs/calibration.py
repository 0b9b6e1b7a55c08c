#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A mount that is not where the plan says, found from views of a sphere or plane.  usage: calibration.py CASE"""
import math
import os
import re
import sys
import tempfile

import numpy
import yaml

from closed_loop import head_over_part
from virtual_scanner import plan_file, run

PLANNED = "mount_offset: {rotation_deg: [0, 0, 0], translation: [0, 0, 0]}"
# 0.5 mm and 0.3 degrees in all
TRUE = "mount_offset: {rotation_deg: [0.2, -0.2, 0.1], translation: [0.3, -0.34641016, 0.2]}"


def stations(height, lift):
    """Sixteen views from all round, the target now here, now there in field and depth band. `lift`: of the surface over
    the target's middle, towards the sensor."""
    out = []
    for i in range(16):
        azimuth, elevation = 360 * i / 8 + (22.5 if i >= 8 else 0), (35 if i < 8 else 65)
        a, e = math.radians(azimuth), math.radians(elevation)
        away = (math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e))
        shift = [(-9, 0, 5), (9, 4, -4), (0, 9, 6), (4, -9, -6)][i % 4]
        target = [shift[k] + lift * away[k] + (height if k == 2 else 0) for k in range(3)]
        out.append(head_over_part(f"s{i + 1}", target, azimuth, elevation).replace("}}", "}, data: views/s%d.ply}" % (i + 1)))
    return out


def archive(work, name, object_, height=0, lift=18, taken=(PLANNED, TRUE), seed=1):
    """Views taken by the true machine, the plan beside them that of the planned one."""
    planned, true = taken
    plan = plan_file(f"{work}/making/{name}.yaml", stations(height, lift), (350, 250), [taken])
    run("simulate", plan, "--object", object_, "--out", f"{work}/{name}", "--seed", seed)
    path = f"{work}/{name}/{name}.yaml"
    text = open(path).read()
    assert true in text
    open(path, "w").write(text.replace(true, planned))
    return path


def mount_of(path):
    """4x4 of the mount offset of a plan that calibrate wrote."""
    return numpy.array(yaml.safe_load(open(path))["sensor"]["mount_offset"]["matrix"]).reshape(4, 4)


def true_mount(text=TRUE):
    numbers = [float(n) for n in re.findall(r"-?\d+\.?\d*", text)]
    x, y, z = numpy.radians(numbers[:3])
    rx = numpy.array([[1, 0, 0], [0, numpy.cos(x), -numpy.sin(x)], [0, numpy.sin(x), numpy.cos(x)]])
    ry = numpy.array([[numpy.cos(y), 0, numpy.sin(y)], [0, 1, 0], [-numpy.sin(y), 0, numpy.cos(y)]])
    rz = numpy.array([[numpy.cos(z), -numpy.sin(z), 0], [numpy.sin(z), numpy.cos(z), 0], [0, 0, 1]])
    out = numpy.eye(4)
    out[:3, :3] = rz @ ry @ rx
    out[:3, 3] = numbers[3:]
    return out


def gap(a, b):
    turn = a[:3, :3].T @ b[:3, :3]
    skew = numpy.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    return numpy.linalg.norm(a[:3, 3] - b[:3, 3]), numpy.degrees(numpy.linalg.norm(skew))


def judge(path, mm=0.05, deg=0.03, truth=TRUE):
    shift, turn = gap(mount_of(path), true_mount(truth))
    print(f"off by {shift:.4f} mm and {turn:.4f} deg")
    assert shift <= mm and turn <= deg, (shift, turn)


def a_sphere_tells_the_mount(work):
    shift, turn = gap(true_mount(), numpy.eye(4))
    assert abs(shift - 0.5) < 1e-3 and abs(turn - 0.3) < 1e-3, (shift, turn)
    plan = archive(work, "ball", "sphere")
    for radius in ([], ["--radius-mm", "20"]):
        text = run("plan", "calibrate", plan, "--target", "sphere", *radius, "-o", f"{work}/found.yaml")
        print(text)
        judge(f"{work}/found.yaml")
    # With what was found nothing is left to find.
    os.replace(f"{work}/found.yaml", plan)
    again = run("plan", "calibrate", plan, "--target", "sphere")
    left = [float(v) for v in re.findall(r"mount (?:turn )?[xyz] +(-?[\d.]+(?:e-\d+)?) \+-", again)]
    assert len(left) == 6 and all(abs(v) < 0.002 for v in left), again


def plate(path, slope):
    """A square of 120 mm, z = 2 + slope x - slope y, as STL."""
    with open(path, "w") as out:
        out.write("solid plate\n")
        corners = [(x, y, 2 + slope * (x - y)) for x, y in ((-60, -60), (60, -60), (60, 60), (-60, 60))]
        for a, b, c in ((0, 1, 2), (0, 2, 3)):
            out.write("facet normal 0 0 1\nouter loop\n" + "".join("vertex %g %g %g\n" % corners[k] for k in (a, b, c)) +
                      "endloop\nendfacet\n")
        out.write("endsolid plate\n")
    return path


def a_plane_tells_the_mount(work):
    """One that is not level: a machine that cannot roll its sensor sees a level one the same from all round."""
    plan = archive(work, "plate", plate(f"{work}/plate.stl", 0.35), 2, 0)
    print(run("plan", "calibrate", plan, "--target", "plane", "-o", f"{work}/found.yaml"))
    judge(f"{work}/found.yaml")
    plan = archive(work, "level", plate(f"{work}/level.stl", 0), 2, 0)
    text = run("plan", "calibrate", plan, "--target", "plane", "-o", f"{work}/found.yaml")
    print(text)
    assert "mount x           as planned: these views do not tell it" in text, text
    assert gap(mount_of(f"{work}/found.yaml"), true_mount())[1] < 0.03


def drift_over_nights_is_told(work):
    later = TRUE.replace("[0.3,", "[0.38,")
    nights = [archive(work, "mon", "sphere"), archive(work, "tue", "sphere", seed=2),
              archive(work, "wed", "sphere", taken=(PLANNED, later), seed=3)]
    text = run("plan", "calibrate", *nights, "--target", "sphere", "-o", f"{work}/found.yaml")
    print(text)
    drift = [float(m) for m in re.findall(r"drift ([\d.]+) mm", text)]
    assert len(drift) == 2 and drift[0] < 0.03 and abs(drift[1] - 0.08) < 0.03, drift
    judge(f"{work}/found.yaml", truth=later)
    assert "allowed sphere, plane" in run("plan", "calibrate", nights[0], "--target", "cube", want=2)
    assert "has no joint 'q'" in run("plan", "calibrate", nights[0], "--target", "sphere", "--axes", "q", want=2)
    assert "is linear" in run("plan", "calibrate", nights[0], "--target", "sphere", "--axes", "x", want=2)
    assert "the radius right" in run("plan", "calibrate", nights[0], "--target", "sphere", "--radius-mm", "9", want=3)


def axes_are_found_too(work):
    """The tilt axis 0.4 mm from where the plan says: the mount alone cannot make up for it."""
    planned = "axis: [0, -1, 0]\n      limits: [-90, 0]"
    path = archive(work, "ball", "sphere", taken=(planned, planned.replace("\n", "\n      origin: [0.4, 0, 0]\n")))
    words = ["plan", "calibrate", path, "--target", "sphere", "--radius-mm", "20"]
    alone, both = run(*words), run(*words, "--axes", "b", "-o", f"{work}/ball/found.yaml")
    print(alone, both)
    left = [float(re.search(r"-> ([\d.]+) mm", text).group(1)) for text in (alone, both)]
    assert left[1] < 0.027 < left[0], left
    # The plan that was written says the same as was found.
    again = run("plan", "calibrate", f"{work}/ball/found.yaml", "--target", "sphere", "--radius-mm", "20")
    before = float(re.search(r"rms ([\d.]+) ->", again).group(1))
    assert before < 0.027, again


CASES = {f.__name__: f for f in (a_sphere_tells_the_mount, a_plane_tells_the_mount, drift_over_nights_is_told, axes_are_found_too)}

if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-calibration-") as folder:
        CASES[sys.argv[1]](folder)
