#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The pages as people open them: in Chromium, from the disk, with mouse, fingers, keys, on paper, on a telephone and
without what a browser may lack. Without Chromium: exit 77, skipped.  usage: report_in_browser.py CASE"""
import os
import re
import sys

import numpy

import browser
from cases import run_case
from end_to_end import make_archive, run, write_job

LIVE = "document.querySelector('.view.live canvas')"
# Of the canvas, in pixels of the window.
PLACE = "(r => ({x: r.x + scrollX, y: r.y + scrollY, width: r.width, height: r.height}))(document.querySelector('.view canvas').getBoundingClientRect())"


def pixels(png):
    """Rows of red, green, blue."""
    reader = vtk.vtkPNGReader()
    reader.SetMemoryBuffer(png)
    reader.SetMemoryBufferLength(len(png))
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    values = vtk_to_numpy(image.GetPointData().GetScalars())
    return values.reshape(height, width, -1)[::-1, :, :3].astype(int)


def drawn(picture):
    """Share of the picture that is not paper."""
    return (picture.min(axis=2) < 245).mean()


def differ(a, b):
    """Share of the pixels that clearly changed."""
    return (abs(a - b).max(axis=2) > 24).mean()


def like(picture, red, green, blue, by=40):
    return (abs(picture - numpy.array([red, green, blue])).max(axis=2) < by).mean()


def scanned(work):
    """The page of a sphere that three eyes saw, so that a third of it is open; with sections and points removed."""
    make_archive(f"{work}/a", ("sphere",))
    plan = open(f"{work}/a/sphere/plan.yaml").read()
    open(f"{work}/a/sphere/plan.yaml", "w").write(plan[:plan.index("  - name: s3")])
    for unseen in range(3, 6):
        os.remove(f"{work}/a/sphere/s{unseen}.ply")
    keys = ("lattice: {bin_mm: 1.5}\nverify: {max_error_mm: 2, sections: [{axis: z, count: 2}]}\n"
            "clean: {remove_plane: {normal: [0, 0, 1], point: [0, 0, -12], distance_mm: 0.5, below: true}}\n")
    job = write_job(f"{work}/job.yaml", "a", keys)
    run("run", job, "--out", f"{work}/o", "--threads", 1)
    run("run", job, "--out", f"{work}/o2", "--threads", 2)
    page = f"{work}/o/scans/sphere/plan/report.html"

    def without_times(path):
        return re.sub(rb'<p id="run">[^\n]*', b"", open(path, "rb").read())

    assert without_times(page) == without_times(page.replace("/o/", "/o2/")), "the same bytes for any threads"
    return page


def shown(chrome, page, address=""):
    chrome.open(page, address)
    chrome.value("document.getElementById('view-box').scrollIntoView()")
    chrome.until(LIVE)
    chrome.value("document.querySelector('.view canvas').scrollIntoView({block: 'center'})")
    return seen(chrome)


def seen(chrome):
    return pixels(chrome.picture(chrome.value(PLACE)))


def the_view_turns(work):
    page = scanned(work)
    with browser.Browser() as chrome:
        chrome.size(1000, 60)
        chrome.open(page)
        assert not chrome.value(f"!!({LIVE})"), "nothing is decoded before it is looked at"
        assert chrome.value("document.getElementById('view-data').textContent.length") > 1000
        chrome.size(1000, 900)
        first = shown(chrome, page)
        assert 0.2 < drawn(first) < 0.9, drawn(first)
        assert like(first, 186, 200, 216) > 0.02, "the outside is blue-grey"
        assert like(first, 205, 0, 30) > 0.0005, "open edges are red"
        assert differ(first, shown(chrome, page)) < 0.001, "the same view twice"

        a, b = shown(chrome, page, "#view=30,20"), shown(chrome, page, "#view=120,-20")
        assert differ(a, b) > 0.03 and differ(a, first) > 0.03, (differ(a, b), differ(a, first))
        near = shown(chrome, page, "#view=30,20,2")
        assert drawn(near) > 1.3 * drawn(a), (drawn(near), drawn(a))
        back = shown(chrome, page, "#view=-135,-35")
        assert like(back, 226, 140, 48, 60) > 0.05, "the inside is orange"
        error = shown(chrome, page, "#view=30,20,1,error")
        assert differ(a, error) > 0.1 and not chrome.value("document.getElementById('view-errors').hidden")
        patches = shown(chrome, page, "#view=30,20,1,patches")
        assert differ(patches, error) > 0.1 and chrome.value("document.getElementById('view-errors').hidden")

        box = (shown(chrome, page), chrome.value(PLACE), chrome.value("scrollY"))[1:]
        middle = (box[0]["x"] + box[0]["width"] / 2, box[0]["y"] - box[1] + box[0]["height"] / 2)
        off = lambda x, y: (middle[0] + x, middle[1] + y)
        last = seen(chrome)

        def changed(what, least=0.01):
            nonlocal last
            now = seen(chrome)
            assert differ(last, now) > least, (what, differ(last, now))
            last = now

        chrome.drag(middle, off(120, 40))
        changed("the mouse turns")
        chrome.drag(middle, off(60, 0), modifiers=8)
        changed("with shift it moves")
        chrome.drag(middle, off(0, 50), button="right")
        changed("so does its right button")
        chrome.mouse("mouseWheel", *middle, deltaX=0, deltaY=-300)
        changed("the wheel zooms once the view was touched")
        scroll = chrome.value("scrollY")
        for key in ("ArrowLeft", "ArrowUp", "+", "2", "3", "1", "0"):
            chrome.key(key)
            changed(f"key {key}", 0.003)
        assert chrome.value("scrollY") == scroll, "keys and wheel of the view do not scroll the page"
        chrome.value("document.querySelector('#view-tools button[value=\"+z\"]').click()")
        changed("from above")
        chrome.value("document.getElementById('view-open').click()")
        changed("without open edges", 0.0005)
        chrome.value("document.querySelector('#view-tools button[value=\"iso\"]').click()")
        chrome.drag(middle, middle)
        told = chrome.value("document.getElementById('view-says').textContent")
        assert re.match(r"At \(-?[\d.]+, -?[\d.]+, -?[\d.]+\) mm; fit error of the nearest vertex.s bin about ", told), told
        place = [float(v) for v in re.findall(r"-?\d+\.\d\d", told)[:3]]
        assert 19.8 < numpy.linalg.norm(place) < 20.2, (told, "a place on the sphere")
        assert not chrome.complaints, chrome.complaints


def fingers_turn_it_on_a_telephone(work):
    page = scanned(work)
    with browser.Browser() as chrome:
        chrome.size(390, 844, mobile=True, dots=2)
        shown(chrome, page)
        assert chrome.value("document.documentElement.scrollWidth") <= 390, "no part of the page is wider than the window"
        assert chrome.value("document.querySelector('.view canvas').width") > 700, "all dots of the screen are used"
        middle = chrome.value("(r => [r.x + r.width / 2, r.y + r.height / 2])(document.querySelector('.view canvas').getBoundingClientRect())")
        off = lambda x, y: (middle[0] + x, middle[1] + y)
        last, scroll = seen(chrome), chrome.value("scrollY")
        for what, steps in (("one finger turns", [[off(-50, 0)], [off(0, 10)], [off(60, 30)]]),
                            ("two move", [[off(-40, 0), off(40, 0)], [off(-20, 20), off(60, 20)], [off(0, 40), off(80, 40)]]),
                            ("and zoom", [[off(-20, 0), off(20, 0)], [off(-40, 0), off(40, 0)], [off(-80, 0), off(80, 0)]])):
            chrome.touch(*steps)
            now = seen(chrome)
            assert differ(last, now) > 0.01, (what, differ(last, now))
            last = now
        assert chrome.value("scrollY") == scroll, "fingers in the view do not scroll the page"
        assert not chrome.complaints, chrome.complaints


def the_picture_stands_for_it(work):
    page = scanned(work)
    picture = "document.querySelector('#view-box figure').getBoundingClientRect().height"
    with browser.Browser() as chrome:
        chrome.size(1000, 900)
        shown(chrome, page)
        assert chrome.value(picture) == 0
        # On paper: the picture in the place of the view, whatever the screen shows.
        chrome.ask("Emulation.setEmulatedMedia", media="print")
        assert chrome.value(picture) > 100
        assert chrome.value("document.querySelector('.view canvas').getBoundingClientRect().height") == 0
        assert chrome.value("document.getElementById('view-tools').getBoundingClientRect().height") == 0
        chrome.ask("Emulation.setEmulatedMedia", media="")
        paper = chrome.paper()
        pages = len(re.findall(rb"/Type\s*/Page\b", paper))
        assert paper.startswith(b"%PDF") and 2 <= pages <= 12, pages
        # A driver that goes away and comes back.
        chrome.value("gone = document.querySelector('.view canvas').getContext('webgl').getExtension('WEBGL_lose_context'); gone.loseContext()")
        chrome.until(f"{picture} > 100")
        chrome.value("gone.restoreContext()")
        chrome.until(f"{picture} === 0")
        assert drawn(seen(chrome)) > 0.2
        assert not [c for c in chrome.complaints if "CONTEXT_LOST" not in c], chrome.complaints
        # Without JavaScript.
        chrome.ask("Emulation.setScriptExecutionDisabled", value=True)
        chrome.open(page)
        assert chrome.value(picture) > 100 and not chrome.value(f"!!({LIVE})")
        assert "The 3-D view needs JavaScript; this is the picture instead." in chrome.value("document.body.innerText")
    with browser.Browser("--disable-3d-apis") as chrome:
        chrome.size(1000, 900)
        chrome.open(page, "#view=30,20")
        chrome.until("document.getElementById('view-says').textContent === 'No 3-D view: this browser offers no WebGL.'")
        assert chrome.value(picture) > 100
        assert not chrome.complaints, chrome.complaints


def the_page_holds_what_it_promises(work):
    page = scanned(work)
    with browser.Browser() as chrome:
        for width, dots in ((1280, 1), (390, 2)):
            chrome.size(width, 900, mobile=width < 500, dots=dots)
            chrome.open(page)
            chrome.until("[...document.images].every(i => i.complete && i.naturalWidth > 0)")
            captions = chrome.value("[...document.querySelectorAll('figcaption')].map(c => c.textContent)")
            for wanted in ("shaded", "fit error", "patches", "removed", "z = "):
                assert any(wanted in caption for caption in captions), (wanted, captions)
            text = chrome.value("document.body.innerText")
            for wanted in ("share of triangles with an input point near", "dropped: remove_plane", "Sections", "PASSED"):
                assert wanted in text, wanted
            assert chrome.value("document.documentElement.scrollWidth") <= width
            lost = chrome.value("[...document.querySelectorAll('nav a')].filter(a => !document.querySelector(a.hash)).length")
            assert lost == 0, "every link of the page leads somewhere"
        night = os.path.join(os.path.dirname(page), "../../../report.html")
        chrome.open(night)
        assert chrome.value("document.documentElement.scrollWidth") <= 390
        assert not chrome.complaints, chrome.complaints


def a_mesh_of_100000_triangles_opens_at_once(work):
    """Under five megabytes, and drawn a few seconds after it is asked for, though a processor does the drawing."""
    make_archive(f"{work}/a", ("sphere",))
    job = write_job(f"{work}/job.yaml", "a", "lattice: {target_points: 60000}\n")
    # Denser than the views of the other cases.
    plan = open(f"{work}/a/sphere/plan.yaml").read().replace("160", "420")
    open(f"{work}/a/sphere/plan.yaml", "w").write(plan)
    run("simulate", f"{work}/a/sphere/plan.yaml", "--object", "sphere", "--out", f"{work}/a/sphere", "--quiet")
    run("run", job, "--out", f"{work}/o")
    page = f"{work}/o/scans/sphere/plan/report.html"
    with browser.Browser() as chrome:
        chrome.size(1000, 900)
        assert drawn(shown(chrome, page)) > 0.2
        triangles = int(chrome.value("document.getElementById('view-box').dataset.triangles"))
        assert 80_000 < triangles <= 200_000, triangles
        assert os.path.getsize(page) < 5_000_000, os.path.getsize(page)
        opened = chrome.value("performance.getEntriesByType('navigation')[0].domContentLoadedEventEnd")
        print(f"{triangles} triangles, {os.path.getsize(page)} bytes, read after {opened:.0f} ms")
        assert not chrome.complaints, chrome.complaints


if __name__ == "__main__":
    if not browser.program():
        print("skipped: no chromium")
        sys.exit(77)
    try:
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
    except ImportError:
        print("skipped: no python3-vtk9")
        sys.exit(77)
    run_case([the_view_turns, fingers_turn_it_on_a_telephone, the_picture_stands_for_it, the_page_holds_what_it_promises,
              a_mesh_of_100000_triangles_opens_at_once])
