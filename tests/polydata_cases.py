"""Random polydata of every kind, and the files and results of VTK's own writers and readers."""

import numpy as np
from vtkmodules import vtkCommonCore
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import (
    VTK_CHAR,
    VTK_ID_TYPE,
    VTK_LONG,
    VTK_LONG_LONG,
    VTK_SIGNED_CHAR,
    VTK_UNSIGNED_LONG,
    VTK_UNSIGNED_LONG_LONG,
    vtkLongArray,
    vtkPoints,
)
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkIOLegacy import vtkPolyDataReader, vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

KINDS = ("Verts", "Lines", "Polys", "Strips")
NUMBERS = ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")
LETTERS = [*"abcXYZ019 %:;.-_äé€\U0001f600"]


def random_polydata(seed, *, as_text=False):
    """Points and cells of all four kinds, with arrays of all types, in roles and with component
    names.

    Polydata for text files have no infinity and NaN, which VTK 9.6 writes but cannot read.
    """
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 60))
    polydata = vtkPolyData()
    points = vtkPoints()
    coordinates = random.normal(size=(count, 3)) * 10.0 ** random.integers(-3, 4)
    points.SetData(numpy_to_vtk(coordinates.astype(random.choice(["f4", "f8"])), deep=True))
    polydata.SetPoints(points)
    for kind in KINDS:
        cells = vtkCellArray()
        for _ in range(random.integers(0, 8) if kind != "Polys" else random.integers(1, 8)):
            size = {"Verts": 1, "Lines": 2, "Polys": 3, "Strips": 3}[kind] + random.integers(0, 3)
            corners = random.integers(0, count, size)
            cells.InsertNextCell(len(corners), corners.tolist())
        getattr(polydata, f"Set{kind}")(cells)
    add_random_arrays(polydata.GetPointData(), count, random, as_text)
    add_random_arrays(polydata.GetCellData(), polydata.GetNumberOfCells(), random, as_text)
    add_random_arrays(polydata.GetFieldData(), int(random.integers(0, 5)), random, as_text)
    return polydata


def add_random_arrays(data, count, random, as_text):
    for number in range(random.integers(0, 7)):
        kind = str(random.choice([*NUMBERS, "id", "bit", "text", "char"]))
        array = random_array(kind, count, int(random.integers(1, 5)), random, as_text)
        array.SetName(f"{kind} {random_text(random)} {number}")
        data.AddArray(array)
        role = random.choice(["", "Scalars", "Vectors", "Normals", "TCoords"])
        fits = {"Vectors": (3,), "Normals": (3,), "TCoords": (1, 2, 3), "Scalars": (1, 2, 3, 4)}
        may_have = hasattr(data, "SetActiveAttribute") and kind not in ("bit", "text")
        if role and may_have and array.GetNumberOfComponents() in fits[role]:
            getattr(data, f"SetActive{role}")(array.GetName())


def random_array(kind, count, components, random, as_text):
    if kind in ("bit", "text", "char"):
        name = {"bit": "vtkBitArray", "text": "vtkStringArray", "char": "vtkCharArray"}[kind]
        array = getattr(vtkCommonCore, name)()
        components = (
            1 if kind == "bit" else components
        )  # VTK writes only a part of several components
        array.SetNumberOfComponents(components)
        array.SetNumberOfTuples(count)
        for number in range(count * components):
            bit = int(random.integers(0, 2))
            value = {"bit": bit, "text": random_text(random), "char": chr(65 + bit)}[kind]
            array.SetValue(number, value)
        return array
    if kind.startswith("f"):
        values = (random.normal(size=(count, components)) * 1e3).astype(kind)
        special = [-0.0] if as_text else [np.nan, np.inf, -np.inf, -0.0]
        values[random.random(values.shape) < 0.05] = random.choice(special)
    else:
        limits = np.iinfo(np.int32 if kind == "id" else kind)
        values = random.integers(
            limits.min, limits.max, (count, components), dtype=limits.dtype, endpoint=True
        )
    is_id = kind == "id"
    values = values.astype(np.int64) if is_id else values
    array = numpy_to_vtk(values, deep=True, array_type=VTK_ID_TYPE if is_id else None)
    array.SetNumberOfComponents(components)
    if random.random() < 0.4:
        for number in range(components):
            array.SetComponentName(number, f"part {number} %")
    return array


def random_text(random):
    return "".join(random.choice(LETTERS, int(random.integers(0, 9))))


def xml_bytes(polydata, mode, compressor, words, order, encoded, block):
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(polydata)
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeTo{words}")()
    getattr(writer, f"SetByteOrderTo{order}Endian")()
    writer.SetEncodeAppendedData(encoded)
    writer.SetBlockSize(block)
    return written(writer, "GetOutputString")


def legacy_bytes(polydata, kind, version):
    writer = vtkPolyDataWriter()
    writer.SetInputData(polydata)
    getattr(writer, f"SetFileTypeTo{kind}")()
    writer.SetFileVersion(version)
    return written(writer, "GetOutputStdString")


def written(writer, result):
    writer.SetWriteToOutputString(True)
    assert writer.Write()
    data = getattr(writer, result)()
    return data.encode() if isinstance(data, str) else bytes(data)


def read_by_vtk(path):
    if path.suffix == ".vtp":
        reader = vtkXMLPolyDataReader()
    else:
        reader = vtkPolyDataReader()
        for kind in ("Scalars", "Vectors", "Normals", "Tensors", "ColorScalars", "TCoords"):
            getattr(reader, f"ReadAll{kind}On")()
        reader.ReadAllFieldsOn()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0
    return reader.GetOutput()


def everything_of(polydata):
    """All content of polydata as plain values: bits of numbers, types, names and
    roles, in order."""
    found = {"points": array_values(polydata.GetPoints().GetData())[1:]}
    for kind in KINDS:
        cells = vtkCellArray()
        cells.DeepCopy(getattr(polydata, f"Get{kind}")())
        cells.ConvertTo64BitStorage()
        found[kind] = [
            vtk_to_numpy(part).tolist()
            for part in (cells.GetOffsetsArray(), cells.GetConnectivityArray())
        ]
    for group in ("Point", "Cell", "Field"):
        data = getattr(polydata, f"Get{group}Data")()
        for index in range(data.GetNumberOfArrays()):
            array = data.GetAbstractArray(index)
            role = data.IsArrayAnAttribute(index) if group != "Field" else -1
            found[group, index] = (*array_values(array), role)
    return found


_SAME = {VTK_CHAR: VTK_SIGNED_CHAR}
"""Types of which VTK's readers take one for the other."""
if vtkLongArray().GetDataTypeSize() == 8:
    # From NumPy's 64-bit integers VTK 9.7 makes the first type; older VTK and all readers make the
    # second.
    _SAME |= {VTK_LONG: VTK_LONG_LONG, VTK_UNSIGNED_LONG: VTK_UNSIGNED_LONG_LONG}


def array_values(array):
    count = array.GetNumberOfComponents()
    kind = array.GetDataType()
    if array.IsA("vtkStringArray") or array.IsA("vtkBitArray"):
        values = [array.GetValue(number) for number in range(array.GetNumberOfValues())]
    else:
        values = vtk_to_numpy(array).tobytes()
    return (
        array.GetName(),
        _SAME.get(kind, kind),
        count,
        array.GetNumberOfTuples(),
        [array.GetComponentName(number) for number in range(count)],
        values,
    )
