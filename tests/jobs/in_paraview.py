# SPDX-License-Identifier: Apache-2.0
"""Run by ParaView's own Python (second_readers.py): opens a record as its reader does and tells what it sees, as JSON.
usage: pvpython in_paraview.py RECORD NAME.hdf"""
import json
import sys

from paraview.simple import OpenDataFile, servermanager


def seen(reader):
    reader.UpdatePipeline()
    about = reader.GetDataInformation()
    ranges = lambda arrays: {a.GetName(): [a.GetNumberOfComponents(), *a.GetRange(0)] for a in arrays}
    return {"kind": about.GetDataSetTypeAsString(), "cells": about.GetNumberOfCells(), "points": about.GetNumberOfPoints(),
            "bounds": about.GetBounds(), "cell_data": ranges(reader.CellData), "point_data": ranges(reader.PointData)}


# By the reader, as a user chooses it, and by a name that ParaView knows.
by_reader = seen(servermanager.sources.VTKHDFReader(FileName=sys.argv[1]))
by_name = seen(OpenDataFile(sys.argv[2]))
print(json.dumps({"by_reader": by_reader, "by_name": by_name}))
