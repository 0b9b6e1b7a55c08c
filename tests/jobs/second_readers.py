#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What a job writes, through readers that are not ours. A reader that is not installed: exit 77, skipped.
usage: second_readers.py CASE"""
import ctypes
import io
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
import zipfile

import numpy

from end_to_end import make_archive, run, values_of, write_job


def skip(why):
    print("skipped:", why)
    sys.exit(77)


def scans(work, outputs, with_views=("sphere", "open")):
    """Folders of a closed sphere, one that two eyes did not see, and the bunny where its data is at hand."""
    make_archive(f"{work}/a", ("sphere",))
    shutil.copytree(f"{work}/a/sphere", f"{work}/a/open")
    plan = open(f"{work}/a/open/plan.yaml").read()
    cut = plan.index("  - name: s3")
    open(f"{work}/a/open/plan.yaml", "w").write(plan[:cut].replace("name: sphere", "name: open"))
    for unseen in range(3, 6):
        os.remove(f"{work}/a/open/s{unseen}.ply")
    run("run", write_job(f"{work}/job.yaml", "a", f"lattice: {{bin_mm: 1.5}}\noutputs: {outputs}\n"), "--out", f"{work}/o")
    found = [f"{work}/o/scans/{name}/plan" for name in with_views]
    data = os.environ.get("SCANMILL_DATA", "")
    if os.path.isdir(f"{data}/range-views/bunny"):
        text = f"units: m\nlattice: {{target_points: 3000}}\noutputs: {outputs}\n"
        run("run", write_job(f"{work}/bunny.yaml", f"{data}/range-views/bunny", text), "--out", f"{work}/b")
        found.append(f"{work}/b/scans/bun")
    return found


def corners_of(folder):
    """Corners of the job's own STL, which its tests prove."""
    raw = open(f"{folder}/mesh.stl", "rb").read()
    record = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return numpy.frombuffer(raw, record, offset=84)["corners"].astype(float)


def recorded(folder):
    """What the stages found of the mesh in memory, before any file of it was written."""
    import h5py

    with h5py.File(f"{folder}/record.h5") as record:
        figures = dict(next(group.attrs.items() for name, group in record["stages"].items() if name.endswith("_verify")))
    faults = ("boundary_edges", "nonmanifold_edges", "nonmanifold_vertices", "misoriented_edges")
    return {**figures, "closed_manifold": not any(figures[name] for name in faults)}


def same_triangles(found, wanted):
    """The same triangles in any order, by exact corners."""
    key = lambda rows: sorted(map(tuple, numpy.asarray(rows, dtype=float).reshape(-1, 9).tolist()))
    assert key(found) == key(wanted)


def dxf_by_ezdxf(work):
    try:
        import ezdxf
    except ImportError:
        skip("no python3-ezdxf")
    for style in ("faces", "polyface"):
        place = f"{work}/{style}"
        os.makedirs(place)
        for folder in scans(place, f"[stl, {{dxf: {{style: {style}}}}}]"):
            drawing = ezdxf.readfile(f"{folder}/mesh.dxf")
            audit = drawing.audit()
            assert not audit.errors and not audit.fixes, (audit.errors, audit.fixes)
            assert drawing.units == 4, "millimetres"
            found, layers = [], set()
            for entity in drawing.modelspace():
                layers.add(entity.dxf.layer)
                if style == "faces":
                    assert entity.dxftype() == "3DFACE" and entity.dxf.vtx3 == entity.dxf.vtx2
                    found.append([tuple(entity.dxf.vtx0), tuple(entity.dxf.vtx1), tuple(entity.dxf.vtx2)])
                else:
                    assert entity.is_poly_face_mesh
                    found += [[tuple(v.dxf.location) for v in face[:3]] for face in entity.faces()]
            same_triangles(found, corners_of(folder))
            assert all(name.startswith("PATCH_") and drawing.layers.has_entry(name) for name in layers), layers


def threemf_by_lib3mf(work):
    try:
        lib = ctypes.CDLL("lib3MF.so.1")
    except OSError:
        skip("no lib3mf1")
    for folder in scans(work, "[stl, 3mf]"):
        path = f"{folder}/mesh.3mf"
        handle = ctypes.c_void_p
        model, reader, meshes, mesh = handle(), handle(), handle(), handle()
        more, count, triangles, warnings = ctypes.c_int(), ctypes.c_uint32(), ctypes.c_uint32(), ctypes.c_uint32()
        corner = (ctypes.c_float * 3)
        index = (ctypes.c_uint32 * 3)
        assert lib.lib3mf_createmodel(ctypes.byref(model)) == 0
        assert lib.lib3mf_model_queryreader(model, b"3mf", ctypes.byref(reader)) == 0
        assert lib.lib3mf_reader_readfromfileutf8(reader, path.encode()) == 0
        assert lib.lib3mf_reader_getwarningcount(reader, ctypes.byref(warnings)) == 0 and warnings.value == 0
        assert lib.lib3mf_model_getmeshobjects(model, ctypes.byref(meshes)) == 0
        assert lib.lib3mf_resourceiterator_movenext(meshes, ctypes.byref(more)) == 0 and more.value == 1
        assert lib.lib3mf_resourceiterator_getcurrent(meshes, ctypes.byref(mesh)) == 0
        lib.lib3mf_meshobject_getvertexcount(mesh, ctypes.byref(count))
        lib.lib3mf_meshobject_gettrianglecount(mesh, ctypes.byref(triangles))
        vertices, found = [], []
        for v in range(count.value):
            place = corner()
            assert lib.lib3mf_meshobject_getvertex(mesh, v, ctypes.byref(place)) == 0
            vertices.append(list(place))
        for t in range(triangles.value):
            rows = index()
            assert lib.lib3mf_meshobject_gettriangle(mesh, t, ctypes.byref(rows)) == 0
            found.append([vertices[row] for row in rows])
        same_triangles(found, corners_of(folder))


def threemf_by_zip_and_xml(work):
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    for folder in scans(work, "[stl, 3mf]"):
        with zipfile.ZipFile(f"{folder}/mesh.3mf") as package:
            assert package.testzip() is None
            assert package.namelist()[0] == "[Content_Types].xml"
            relations = xml.etree.ElementTree.fromstring(package.read("_rels/.rels"))
            target = relations[0].attrib["Target"].lstrip("/")
            model = xml.etree.ElementTree.fromstring(package.read(target))
        assert model.attrib["unit"] == "millimeter"
        vertices = [[float(v.attrib[axis]) for axis in "xyz"] for v in model.iter(f"{core}vertex")]
        faces = [[vertices[int(t.attrib[c])] for c in ("v1", "v2", "v3")] for t in model.iter(f"{core}triangle")]
        same_triangles(faces, corners_of(folder))
        kind = next(model.iter(f"{core}object")).attrib["type"]
        assert kind == ("model" if recorded(folder)["closed_manifold"] else "surface")
        names = [base.attrib["name"] for base in model.iter(f"{core}base")]
        assert names and all(re.fullmatch(r"patch_\d+", name) for name in names), names


def stl_by_admesh(work):
    if shutil.which("admesh") is None:
        skip("no admesh")
    for folder in scans(work, "[stl]"):
        told = recorded(folder)
        figures = {}
        for option in ("-e", "-d"):
            text = subprocess.run(["admesh", option, f"{folder}/mesh.stl"], capture_output=True, text=True, check=True).stdout
            figures[option] = lambda name, text=text: [float(v) for v in re.findall(rf"{name}\s*:\s*([-0-9.]+)(?:\s+([-0-9.]+))?", text)[0] if v]
        exact = figures["-e"]
        open_edges = sum(n * exact(f"Facets with {n} disconnected edges?")[0] for n in (1, 2, 3))
        assert open_edges == told["boundary_edges"], (open_edges, told["boundary_edges"])
        assert exact("Number of facets")[0] == told["triangles"]
        assert exact("Degenerate facets")[0] == 0
        assert figures["-d"]("Facets reversed")[0] == 0
        if told["closed_manifold"]:
            assert abs(exact("Volume")[0] / told["volume_mm3"] - 1) < 1e-4, (exact("Volume"), told["volume_mm3"])


def meshes_by_vtk(work):
    try:
        import vtk
    except ImportError:
        skip("no python3-vtk9")
    readers = {"mesh.stl": vtk.vtkSTLReader, "mesh.ply": vtk.vtkPLYReader, "mesh.obj": vtk.vtkOBJReader}
    for folder in scans(work, "[stl, ply, obj]"):
        told = recorded(folder)
        for name, kind in readers.items():
            reader = kind()
            reader.SetFileName(f"{folder}/{name}")
            reader.Update()
            mesh = reader.GetOutput()
            assert mesh.GetNumberOfCells() == told["triangles"], name
            area = volume = 0.0
            for cell in range(mesh.GetNumberOfCells()):
                a, b, c = (numpy.array(mesh.GetCell(cell).GetPoints().GetPoint(i)) for i in range(3))
                area += numpy.linalg.norm(numpy.cross(b - a, c - a)) / 2
                volume += numpy.dot(a, numpy.cross(b, c)) / 6
            assert abs(area / told["area_mm2"] - 1) < 1e-5 and abs(volume / told["volume_mm3"] - 1) < 1e-5, name
            if told["closed_manifold"]:
                properties = vtk.vtkMassProperties()
                properties.SetInputData(mesh)
                assert abs(properties.GetVolume() / told["volume_mm3"] - 1) < 1e-5 and told["volume_mm3"] > 0


def sections_by_ezdxf_and_h5py(work):
    try:
        import ezdxf
    except ImportError:
        skip("no python3-ezdxf")
    import h5py

    make_archive(f"{work}/a", ("sphere",))
    keys = ("lattice: {bin_mm: 1.5}\nverify:\n  sections:\n    - {axis: z, at_mm: 3, slab_mm: 2}\n    - {axis: [1, 1, 0], count: 2}\n"
            "    - {axis: x, through: worst, name: worst}\n    - {axis: y, through: loop}\n    - {axis: x, at_mm: 900}\n")
    job = write_job(f"{work}/job.yaml", "a", keys)
    text = run("run", job, "--out", f"{work}/o", "--threads", 1)
    assert "there is no open loop to cut through" in text and "section x = 900 mm does not meet the mesh" in text, text
    run("run", job, "--out", f"{work}/o2", "--threads", 2)
    folder = f"{work}/o/scans/sphere/plan"
    for name in ("sections.svg", "sections.dxf", "record.h5", "section-1.png", "section-4.png"):
        assert open(f"{folder}/{name}", "rb").read() == open(f"{work}/o2/scans/sphere/plan/{name}", "rb").read(), name
    assert "id=\"sections\"" in open(f"{folder}/report.html").read()
    xml.etree.ElementTree.parse(f"{folder}/sections.svg")
    drawing = ezdxf.readfile(f"{folder}/sections.dxf")
    audit = drawing.audit()
    assert not audit.errors and not audit.fixes
    with h5py.File(f"{folder}/record.h5") as record:
        s = record["sections"]
        names = [name.decode() for name in s["name"][:]]
        assert names[0] == "z = 3 mm" and names[3].startswith("worst: x = ") and len(names) == 5, names
        assert s["worst_signed_mm"][3] == max(s["worst_signed_mm"], key=abs)
        radius = 0
        for n in range(5):
            lines = [i for i, owner in enumerate(s["line_section"][:]) if owner == n]
            drawn = drawing.modelspace().query(f'POLYLINE[layer=="SECTION_{n + 1}_MESH"]')
            assert len(drawn) == len(lines) == (1 if n < 4 else 0)
            for i, polyline in zip(lines, drawn):
                places = s["line_points"][s["line_offsets"][i]:s["line_offsets"][i + 1]]
                assert polyline.is_closed == bool(s["line_closed"][i]) == True
                numpy.testing.assert_allclose([tuple(v.dxf.location) for v in polyline.vertices], places, atol=1e-12)
                off = (places - s["origin"][n]) @ s["normal"][n]
                assert abs(off).max() < 1e-9
                radius = max(radius, numpy.linalg.norm(places, axis=1).max())
            dots = drawing.modelspace().query(f'POINT[layer=="SECTION_{n + 1}_POINTS"]')
            assert len(dots) == min(4000, s["points"][n])
            if n < 4:
                heights = (numpy.array([tuple(p.dxf.location) for p in dots]) - s["origin"][n]) @ s["normal"][n]
                assert abs(heights).max() <= s["slab_mm"][n] / 2 and len(dots) > 50
        assert 19 < radius < 31, radius


def bins_by_vdb_print(work):
    if shutil.which("vdb_print") is None:
        skip("no libopenvdb-tools")
    import h5py

    make_archive(f"{work}/a", ("sphere",))
    job = write_job(f"{work}/job.yaml", "a", "lattice: {bin_mm: 1.5}\noutputs: [stl, vdb]\n")
    run("run", job, "--out", f"{work}/o", "--threads", 1)
    run("run", job, "--out", f"{work}/o2", "--threads", 2)
    path = f"{work}/o/scans/sphere/plan/bins.vdb"
    assert open(path, "rb").read() == open(f"{work}/o2/scans/sphere/plan/bins.vdb", "rb").read()
    text = subprocess.run(["vdb_print", "-l", path], capture_output=True, text=True, check=True).stdout
    with h5py.File(f"{work}/o/scans/sphere/plan/record.h5") as record:
        count = len(record["reduced/bin"])
        low, high = record["reduced/bin"][:].min(axis=0), record["reduced/bin"][:].max(axis=0)
    for grid in ("points", "row", "drop"):
        assert f"Name: {grid}" in text, text
    plain = text.replace(",", "")
    assert plain.count(f"activeVoxelCount: {count}") + plain.count(f"Active Voxel Count: {count}") + len(re.findall(rf"Number of active voxels:\s+{count}\b", plain)) == 3, (count, text)
    assert "scanmill:bin_mm: 1.5" in text, text


def record_by_h5py_and_vtk(work):
    try:
        import vtk
    except ImportError:
        skip("no python3-vtk9")
    import h5py

    check = f"{os.environ['SCANMILL_ROOT']}/tests/provenance/check_record.py"
    for folder in scans(work, "[stl]"):
        archive = f"{work}/a" if folder.startswith(f"{work}/o/") else f"{os.environ['SCANMILL_DATA']}/range-views/bunny"
        subprocess.run([sys.executable, check, f"{folder}/record.h5", "--stl", f"{folder}/mesh.stl", "--archive", archive], check=True)
        reader = vtk.vtkHDFReader()
        assert reader.CanReadFile(f"{folder}/record.h5")
        reader.SetFileName(f"{folder}/record.h5")
        reader.Update()
        grid = reader.GetOutput()
        with h5py.File(f"{folder}/record.h5") as record:
            for kind, data in (("CellData", grid.GetCellData()), ("PointData", grid.GetPointData())):
                assert data.GetNumberOfArrays() == len(record[f"VTKHDF/{kind}"]) > 0
                for name, values in record[f"VTKHDF/{kind}"].items():
                    low, high = data.GetArray(name).GetRange()
                    assert (low, high) == (values[()].min(), values[()].max()), (kind, name)
        # Its surface is the mesh: area and open edges as the program tells them.
        surface = vtk.vtkGeometryFilter()
        surface.SetInputData(grid)
        edges = vtk.vtkFeatureEdges()
        edges.SetInputConnection(surface.GetOutputPort())
        edges.FeatureEdgesOff()
        edges.NonManifoldEdgesOff()
        edges.Update()
        assert edges.GetOutput().GetNumberOfCells() == recorded(folder)["boundary_edges"]


def record_by_paraview(work):
    program = f"{os.environ.get('SCANMILL_PARAVIEW', '')}/pvpython"
    if not os.path.exists(program):
        program = shutil.which("pvpython")
    if not program:
        skip("no pvpython; scripts/unpack_paraview.sh puts one beside the system")
    import h5py

    script = f"{os.environ['SCANMILL_ROOT']}/tests/jobs/in_paraview.py"
    for folder in scans(work, "[stl]"):
        shutil.copy(f"{folder}/record.h5", f"{work}/record.hdf")
        done = subprocess.run([program, script, f"{folder}/record.h5", f"{work}/record.hdf"], capture_output=True, text=True,
                              timeout=300, env={**os.environ, "DISPLAY": ""})
        assert done.returncode == 0, done.stderr[-2000:]
        told = json.loads(done.stdout.strip().splitlines()[-1])
        assert told["by_reader"] == told["by_name"]
        told = told["by_reader"]
        with h5py.File(f"{folder}/record.h5") as record:
            mesh = record["VTKHDF"]
            places = mesh["Points"][()]
            assert told["kind"] == "vtkUnstructuredGrid"
            assert told["cells"] == len(record["mesh/triangles"]) and told["points"] == len(places)
            wanted = [bound for axis in range(3) for bound in (places[:, axis].min(), places[:, axis].max())]
            numpy.testing.assert_allclose(told["bounds"], wanted, rtol=1e-12)
            for kind, found in (("CellData", told["cell_data"]), ("PointData", told["point_data"])):
                assert set(found) == set(mesh[kind]), (found, list(mesh[kind]))
                for name, values in mesh[kind].items():
                    assert found[name] == [1, values[()].min(), values[()].max()], (name, found[name])


def damaged_files_are_noticed(work):
    """The checks above can fail: each against a file in which one facet is not what it was."""
    import h5py

    folder = scans(f"{work}/good", "[stl, ply, obj, 3mf, dxf]", ("open",))[0]

    def stl(raw):
        return raw[:84 + 12] + struct.pack("<f", 77.5) + raw[84 + 16:]

    def text(raw, line_of):
        """The first number of the first such line, moved."""
        lines = raw.split(b"\n")
        at = next(n for n, line in enumerate(lines) if line_of(lines, n))
        lines[at] = re.sub(rb"-?[\d.]+", b"77.5", lines[at], count=1)
        return b"\n".join(lines)

    def ply(raw):
        body = raw.index(b"end_header\n") + 11
        return raw[:body] + struct.pack("<f", 77.5) + raw[body + 4:]

    def threemf(raw):
        out = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(raw)) as old, zipfile.ZipFile(out, "w") as new:
            for item in old.infolist():
                content = old.read(item)
                new.writestr(item.filename, re.sub(rb' x="[^"]*"', b' x="77.5"', content, count=1) if item.filename.endswith(".model") else content)
        return out.getvalue()

    def record(path):
        with h5py.File(path, "r+") as file:
            file["VTKHDF/PointData/source_row"][:] += 1

    dxf = lambda raw: text(raw, lambda lines, n: n > 0 and lines[n - 1].strip() == b"10" and any(b"3DFACE" in l for l in lines[max(0, n - 12):n]))
    obj = lambda raw: text(raw, lambda lines, n: lines[n].startswith(b"v "))
    for case, name, damage in ((stl_by_admesh, "mesh.stl", stl), (meshes_by_vtk, "mesh.stl", stl), (meshes_by_vtk, "mesh.ply", ply),
                               (meshes_by_vtk, "mesh.obj", obj), (dxf_by_ezdxf, "mesh.dxf", dxf), (threemf_by_lib3mf, "mesh.3mf", threemf),
                               (threemf_by_zip_and_xml, "mesh.3mf", threemf), (record_by_h5py_and_vtk, "record.h5", record)):
        copy = f"{work}/o/{case.__name__}-{name}"
        shutil.copytree(folder, copy)
        path = f"{copy}/{name}"
        if damage is record:
            record(path)
            os.makedirs(f"{work}/a", exist_ok=True)
            shutil.copytree(f"{work}/good/a", f"{work}/a", dirs_exist_ok=True)
        else:
            raw = open(path, "rb").read()
            changed = damage(raw)
            assert changed != raw, name
            open(path, "wb").write(changed)
        globals()["scans"] = lambda *_, copy=copy: [copy]
        place = f"{work}/{case.__name__}-{name}" if case is not record_by_h5py_and_vtk else work
        os.makedirs(place, exist_ok=True)
        try:
            case(place)
        except (AssertionError, subprocess.CalledProcessError):
            continue
        except SystemExit:  # its reader is not installed
            continue
        raise AssertionError(f"{case.__name__} takes a damaged {name}")


def far_meshes_keep_their_digits(work):
    corners = [(4520000.0 + x, 70000.0 + y, z) for x in (0, 0.5) for y in (0, 0.5) for z in (0, 0.5)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    with open(f"{work}/far.obj", "w") as out:
        out.writelines(f"v {x} {y} {z}\n" for x, y, z in corners)
        out.writelines(f"f {a + 1} {b + 1} {c + 1}\nf {a + 1} {c + 1} {d + 1}\n" for a, b, c, d in quads)
    for name in ("far.stl", "far.ply"):
        text = run("convert", f"{work}/far.obj", f"{work}/{name}")
        assert "translated by -4519936 -69632 0 mm" in text, text
        told = values_of(run("info", f"{work}/{name}", "--json"))
        assert abs(told["volume_mm3"] - 0.125) < 1e-9 and told["offset_mm"] == [4519936, 69632, 0], told
    text = run("convert", f"{work}/far.obj", f"{work}/far.igs")
    assert "translated" not in text, "doubles need no offset"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="scanmill-") as place:
        globals()[sys.argv[1]](place)
