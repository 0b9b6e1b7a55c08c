#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Walks records and fails on any group, dataset, attribute or link that schemas/record.schema.json does not name, names
otherwise, or wants and does not find.

usage: record_schema.py check [--any-counters] RECORD...   one line per fault; exit code 1 when there is one
       record_schema.py document              docs/record.md, made from the schema
       record_schema.py self-test RECORD FOLDER   that damaged copies of the record in FOLDER are noticed
"""
import json
import os
import shutil
import sys

import h5py
import numpy

ROOT = os.environ.get("SCANMILL_ROOT", os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
SCHEMA = json.load(open(f"{ROOT}/schemas/record.schema.json"))


def type_of(item):
    """As the schema writes it; of a dataset or of an attribute's type."""
    kind = item.dtype
    if kind.kind in "SO":
        return "text"
    return kind.name if kind.byteorder in "=<|" else "big-endian " + kind.name


def attributes_of(item):
    """name -> (type, shape); an empty text has neither length nor shape."""
    found = {}
    for name in item.attrs:
        told = item.attrs.get_id(name)
        found[name] = (type_of(told), tuple(told.shape or ()))
    return found


class Walk:
    def __init__(self, record):
        self.record, self.faults, self.sizes = record, [], {}
        text = [g.attrs["version"] for name, g in record.get("stages", {}).items() if name.endswith("_record")]
        self.version = int(text[0]) if text else None

    def fault(self, place, sentence):
        self.faults.append(f"{place}: {sentence}")

    def may_be_absent(self, entry):
        new = entry.get("since", 1) > (self.version or 1)
        parent = entry["path"].rsplit("/", 1)[0] or "/"
        if entry["kind"] == "attribute":
            parent = entry["path"]
        return "when" in entry or new or parent not in self.record

    def shape(self, place, wanted, found):
        if len(wanted) != len(found):
            return self.fault(place, f"has shape {list(found)}, wanted {wanted}")
        for want, size in zip(wanted, found):
            if isinstance(want, int):
                if want != size:
                    self.fault(place, f"has shape {list(found)}, wanted {wanted}")
                continue
            name = want.removesuffix(" + 1")
            assert name in SCHEMA["dimensions"], f"{place}: the schema has no dimension {name}"
            rows = size - (name != want)
            known, where = self.sizes.setdefault(name, (rows, place))
            if known != rows:
                self.fault(place, f"has {rows} {name}, {where} has {known}")

    def typed(self, place, entry, kind, shape):
        if kind != entry["type"]:
            self.fault(place, f"is {kind}, wanted {entry['type']}")
        self.shape(place, entry["shape"], shape)

    def objects(self):
        """path -> object by every name, and the paths that are further names of another."""
        found, first, again = {"/": self.record}, {}, {}

        def below(group, path):
            for name in group:
                inner = f"{path}{name}"
                item = group[name]
                found[inner] = item
                if isinstance(item, h5py.Group):
                    below(item, inner + "/")
                elif (place := h5py.h5o.get_info(item.id).addr) in first:
                    again[inner] = first[place]
                else:
                    first[place] = inner

        below(self.record, "/")
        return found, again

    def stages(self, found):
        known = {stage["stage"]: stage for stage in SCHEMA["stages"]}
        for path in [p for p in found if p.startswith("/stages/")]:
            item, name = found.pop(path), path.split("_", 1)[-1]
            if name not in known:
                self.fault(path, "is a stage that the schema does not name")
                continue
            counters = {c["name"]: c for c in known[name]["counters"]}
            there = attributes_of(item)
            if there.pop("version", None) is None:
                self.fault(path, "has no version")
            for counter, (kind, shape) in there.items():
                place = f"{path} @{counter}"
                if counter not in counters:
                    self.fault(place, "is not named by the schema")
                    continue
                wanted = counters[counter]["type"]
                # A count that is not known is NaN, which only float64 has.
                unknown = wanted == "int64" and kind == "float64" and not numpy.isfinite(item.attrs[counter])
                if shape or (kind != wanted and not unknown):
                    self.fault(place, f"is {kind} {list(shape)}, wanted {wanted}")
            if there:
                for counter in set(counters) - set(there):
                    if "when" not in counters[counter]:
                        self.fault(f"{path} @{counter}", "is missing")

    def run(self, counters=True):
        found, again = self.objects()
        stages = {p: i for p, i in found.items() if p.startswith("/stages/")}
        found = {p: i for p, i in found.items() if p not in stages}
        if counters:
            self.stages(stages)
        attributes = {path: attributes_of(item) for path, item in found.items() if path not in again}
        for entry in SCHEMA["objects"]:
            path, place = entry["path"], entry["path"]
            if entry["kind"] == "attribute":
                place = f"{path} @{entry['name']}"
                there = attributes.get(path, {}).pop(entry["name"], None)
                if there is not None:
                    self.typed(place, entry, *there)
                    if "value" in entry and self.record[path].attrs[entry["name"]].decode() != entry["value"]:
                        self.fault(place, f"is not {entry['value']}")
                elif not self.may_be_absent(entry):
                    self.fault(place, "is missing")
                continue
            item = found.pop(path, None)
            if item is None:
                if not self.may_be_absent(entry):
                    self.fault(place, "is missing")
            elif isinstance(item, h5py.Group) != (entry["kind"] == "group"):
                self.fault(place, f"is no {entry['kind']}")
            elif entry["kind"] == "dataset":
                self.typed(place, entry, type_of(item), item.shape)
            elif entry["kind"] == "link" and item != self.record[entry["target"]]:
                self.fault(place, f"is not {entry['target']} under another name")
        for path in found:
            self.fault(path, "is not named by the schema")
        for path, names in attributes.items():
            for name in names:
                self.fault(f"{path} @{name}", "is not named by the schema")
        return self.faults


def faults_of(path, counters=True):
    with h5py.File(path, "r") as record:
        return Walk(record).run(counters)


def document():
    text = ["# Every object of record.h5", "",
            "Made from `schemas/record.schema.json` by `tests/provenance/record_schema.py document`; a test compares, and another",
            "walks real records and fails on whatever is not listed, missing, or of another type or shape. What a record is for, how",
            "identity and content are worked out, and how to make the STL again: [formats.md](formats.md).", "",
            "Lengths are mm and places are in the job's global frame where nothing else is said. `since` is the version of the stage `record`",
            "that wrote the object first (`version` of `/stages/NN_record`); empty: the first. Text has a fixed length, padded with NUL, UTF-8.",
            "An object with a condition is there only then; with a group its members are absent.", "",
            "ParaView 5.11 chooses readers by name: open a record by *VTKHDF Files* of *Open Data With...*, or give it a second name that",
            "ends in `.hdf`. VTK and h5py open it as it is.", "",
            "| dimension | counts |", "|---|---|"]
    text += [f"| {name} | {meaning} |" for name, meaning in SCHEMA["dimensions"].items()]
    section = None
    for entry in SCHEMA["objects"]:
        head = "/" + entry["path"].split("/")[1]
        if head in ("/notes", "/note_kinds"):
            head = "/notes"
        if head != section:
            section = head
            text += ["", f"## {head}", "", "| object | type and shape | unit, frame | since | holds |", "|---|---|---|---|---|"]
        name = entry["path"] + (f" @{entry['name']}" if entry["kind"] == "attribute" else "")
        kind = entry["kind"] if entry["kind"] == "group" else f"link to `{entry['target']}`" if entry["kind"] == "link" else entry["type"]
        if entry.get("shape"):
            kind += " [" + ", ".join(map(str, entry["shape"])) + "]"
        where = ", ".join(v for v in (entry.get("unit"), entry.get("frame")) if v)
        held = entry["meaning"] + (f" Only when {entry['when']}." if "when" in entry else "")
        text.append(f"| `{name}` | {kind} | {where} | {entry.get('since', '')} | {held} |")
    text += ["", "## Counters of the stages", "", "Attributes of `/stages/NN_name`, beside the text `version`. A count is int64; NaN (float64) where it is not known."]
    for stage in SCHEMA["stages"]:
        text += ["", f"### {stage['stage']}", "", stage["meaning"] + (f" Only when {stage['when']}." if "when" in stage else "")]
        if not stage["counters"]:
            continue
        text += ["", "| counter | type | unit | holds |", "|---|---|---|---|"]
        text += [f"| `{c['name']}` | {c['type']} | {c['unit']} | {c['meaning']}" + (f" Only when {c['when']}." if "when" in c else "") + " |"
                 for c in stage["counters"]]
    return "\n".join(text) + "\n"


def self_test(path, folder):
    """Every kind of fault, each in a copy of its own."""
    def damaged(change, wanted):
        copy = f"{folder}/damaged.h5"
        shutil.copy(path, copy)
        with h5py.File(copy, "r+") as record:
            change(record)
        found = faults_of(copy)
        assert any(wanted in line for line in found), (wanted, found)

    def replace(record, name, values):
        del record[name]
        record[name] = values

    assert not faults_of(path), faults_of(path)
    damaged(lambda r: r.create_dataset("inputs/colour", data=[1]), "/inputs/colour: is not named by the schema")
    damaged(lambda r: r.create_group("extra"), "/extra: is not named by the schema")
    damaged(lambda r: r["mesh"].attrs.create("scale", 1.0), "/mesh @scale: is not named by the schema")
    damaged(lambda r: r.__delitem__("loops/centre"), "/loops/centre: is missing")
    damaged(lambda r: r["reduced"].attrs.__delitem__("bin_mm"), "/reduced @bin_mm: is missing")
    damaged(lambda r: replace(r, "inputs/bytes", r["inputs/bytes"][()].astype("i4")), "/inputs/bytes: is int32, wanted uint64")
    damaged(lambda r: replace(r, "inputs/bytes", r["inputs/bytes"][()].astype(">u8")), "/inputs/bytes: is big-endian uint64")
    damaged(lambda r: replace(r, "mesh/triangles", r["mesh/triangles"][()][1:]), "/mesh/triangles: has ")
    damaged(lambda r: replace(r, "mesh/stl_positions", r["mesh/stl_positions"][()][:, :2]), "/mesh/stl_positions: has shape")
    damaged(lambda r: replace(r, "mesh/row", r["mesh/row"][()]), "/mesh/row: is not /VTKHDF/PointData/row")
    damaged(lambda r: r.attrs.modify("units", numpy.bytes_("in")), "/ @units: is not mm")
    damaged(lambda r: r["stages"].create_group("99_polish"), "/stages/99_polish: is a stage that the schema does not name")
    stage = [name for name in h5py.File(path)["stages"] if name.endswith("_reduce")][0]
    damaged(lambda r: r[f"stages/{stage}"].attrs.create("kept", 1.5), f"/stages/{stage} @kept: is float64")
    damaged(lambda r: r[f"stages/{stage}"].attrs.__delitem__("bins"), f"/stages/{stage} @bins: is missing")
    damaged(lambda r: r[f"stages/{stage}"].attrs.create("more", 1), f"/stages/{stage} @more: is not named by the schema")


if __name__ == "__main__":
    if sys.argv[1:] == ["document"]:
        sys.stdout.write(document())
    elif sys.argv[1:2] == ["self-test"]:
        self_test(*sys.argv[2:])
    elif sys.argv[1:2] == ["check"]:
        named = [word for word in sys.argv[2:] if word != "--any-counters"]
        lines = [f"{path}: {line}" for path in named for line in faults_of(path, "--any-counters" not in sys.argv)]
        print("\n".join(lines) or "every object is as the schema says")
        sys.exit(bool(lines))
    else:
        sys.exit(__doc__)
