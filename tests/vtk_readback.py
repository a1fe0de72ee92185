"""Reads a directory of lateen output with VTK's own readers and compares it with expected.json.

    python vtk_readback.py DIRECTORY

Exit code 0: equal; 1: different; 77: VTK is not installed.
"""

import json
import sys
from pathlib import Path
from xml.etree import ElementTree

try:
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkDataArray
    import numpy as np
except ImportError as error:
    print(f"VTK is not installed: {error}")
    sys.exit(77)

READERS = {".vtp": vtkXMLPolyDataReader, ".vtu": vtkXMLUnstructuredGridReader}


def read(path):
    reader = READERS[path.suffix]()
    if not reader.CanReadFile(str(path)):
        sys.exit(f"{path}: VTK can't read it")
    reader.SetFileName(str(path))
    reader.Update()
    if reader.GetErrorCode() != 0:
        sys.exit(f"{path}: VTK error {reader.GetErrorCode()}")
    return reader.GetOutput()


def compare(place, computed, expected, tolerance):
    computed, expected = np.asarray(computed, float).ravel(), np.asarray(expected, float).ravel()
    if computed.shape != expected.shape:
        sys.exit(f"{place}: {computed.size} numbers, expected {expected.size}")
    scale = np.abs(expected).max(initial=0.0) or 1.0
    deviation = np.abs(computed - expected).max(initial=0.0) / scale
    if not deviation <= tolerance:
        sys.exit(f"{place}: deviates by {deviation:.3e}, allowed {tolerance:.1e}")


def cells(data):
    types = [data.GetCellType(i) for i in range(data.GetNumberOfCells())]
    if data.IsA("vtkPolyData"):
        kinds = [data.GetVerts(), data.GetLines(), data.GetPolys()]
        cell_array = next((kind for kind in kinds if kind.GetNumberOfCells() > 0), data.GetVerts())
    else:
        cell_array = data.GetCells()
    return (
        vtk_to_numpy(cell_array.GetConnectivityArray()),
        vtk_to_numpy(cell_array.GetOffsetsArray()),
        types,
    )


def check_arrays(place, attributes, expected, tolerance):
    names = [attributes.GetArrayName(i) for i in range(attributes.GetNumberOfArrays())]
    if names != [array["name"] for array in expected]:
        sys.exit(f"{place}: arrays {names}")
    for array in expected:
        values = attributes.GetArray(array["name"])
        where = f"{place}: {array['name']}"
        if values.GetNumberOfComponents() != array["components"]:
            sys.exit(f"{where}: {values.GetNumberOfComponents()} components")
        unit = values.GetInformation().Get(vtkDataArray.UNITS_LABEL()) or ""
        if unit != array["unit"]:
            sys.exit(f"{where}: unit {unit!r}, expected {array['unit']!r}")
        compare(where, vtk_to_numpy(values), array["values"], tolerance)


def check_file(path, expected):
    data, tolerance = read(path), expected["tolerance"]
    compare(f"{path}: time", vtk_to_numpy(data.GetFieldData().GetArray("TimeValue")), [expected["time"]], 0.0)
    points = data.GetPoints()
    position = vtk_to_numpy(points.GetData()) if points is not None else []
    compare(f"{path}: points", position, expected["points"], tolerance)
    connectivity, offsets, types = cells(data)
    compare(f"{path}: connectivity", connectivity, expected["connectivity"], 0.0)
    compare(f"{path}: offsets", offsets, expected["offsets"], 0.0)
    compare(f"{path}: types", types, expected["types"], 0.0)
    check_arrays(f"{path}: point data", data.GetPointData(), expected["point-data"], tolerance)
    check_arrays(f"{path}: cell data", data.GetCellData(), expected["cell-data"], tolerance)


def main(directory):
    expected = json.loads((directory / "expected.json").read_text())
    for name, frames in expected.items():
        entries = ElementTree.parse(directory / f"{name}.pvd").getroot().find("Collection").findall("DataSet")
        compare(f"{name}.pvd", [float(e.get("timestep")) for e in entries], [f["time"] for f in frames], 0.0)
        for entry, frame in zip(entries, frames):
            check_file(directory / entry.get("file"), frame)
        print(f"{name}: {len(frames)} files read back")


main(Path(sys.argv[1]))
