"""The strict readers of VTK's files: what is damaged is a sentence, all else as VTK reads it."""

import base64
import re
import zlib
from itertools import product

import numpy as np
import pytest
from mesh_files import octahedron
from polydata_cases import everything_of, legacy_bytes, random_polydata, read_by_vtk, xml_bytes
from vtkmodules.vtkFiltersCore import vtkTriangleFilter

from SDFStentLib.files import polydata_from_arrays, read_surface, set_frame_of_polydata
from SDFStentLib.files.content import read_content
from SDFStentLib.files.formats.vtk_files import read_vtk_polydata
from SDFStentLib.validation import InputError


def surface():
    points, triangles = octahedron(rounds=1)
    arrays = {"label": np.arange(len(points), dtype=np.int32), "vector": np.ones((len(points), 3))}
    polydata = polydata_from_arrays(points, triangles, arrays)
    set_frame_of_polydata(polydata, "RAS")
    return polydata


def text_vtp():
    return xml_bytes(surface(), "Ascii", "None", "UInt32", "Little", True, 32768)


def appended_vtp(compressor="ZLib", encoded=True):
    return xml_bytes(surface(), "Appended", compressor, "UInt32", "Little", encoded, 128)


def sentence_of(folder, data, suffix=".vtp"):
    path = folder / f"a{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_surface(path)
    sentence = str(caught.value)
    assert str(path) in sentence
    assert "\n" not in sentence
    assert len(sentence) < 400
    return sentence


def replaced(data, old, new, count=1):
    assert old in data
    return data.replace(old, new, count)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (b'NumberOfComponents="3"', b'NumberOfComponents="-3"', "expected a number from 0 as Num"),
        (b'NumberOfComponents="3"', b'NumberOfComponents="0"', "expected 1 to 10000 components"),
        (b'NumberOfPoints="18"', b'NumberOfPoints="-1"', "expected a number from 0 as NumberOfP"),
        (b'NumberOfPoints="18"', b'NumberOfPoints="8589934592"', "expected 25769803776 values"),
        (b'NumberOfPoints="18"', b'NumberOfPoints="%s"' % (b"9" * 5000), "from 0 as NumberOfP"),
        (b'NumberOfPolys="32"', b'NumberOfPolys="33"', "array offsets: expected 33 values, got 32"),
        (b'type="Int32" Name="label"', b'type="String" Name="label"', "array label: expected"),
        (b'type="Int32" Name="label"', b'type="Bit" Name="label"', "expected bits 0 and 1, got 17"),
        (b'type="Int32" Name="label"', b'type="Int7" Name="label"', "expected Int8.*as type"),
        (b'type="Float64" Name="Points"', b'type="String" Name="Points"', "array Points: expected"),
        (b'type="Float64" Name="Points"', b'type="Bit" Name="Points"', "expected"),
        (b'Name="offsets" format="ascii"', b'Name="off" format="ascii"', "expected offsets and"),
        (b'"SPACE" NumberOfTuples="1"', b'"SPACE" NumberOfTuples="2"', "expected 2 values"),
        (b"82 65 83 0", b"82 65 83", "expected texts that end with a null"),
        (b"<Points>", b"<Points></Points><Points>", "expected one element Points, got 2"),
        (b'Name="vector"', b'Name="label"', "expected arrays of different names"),
        (b'byte_order="LittleEndian"', b'byte_order="Middle"', "expected LittleEndian, BigEndian"),
        (b"<VTKFile", b"<!DOCTYPE a><VTKFile", "got a document type"),
    ],
)
def test_a_damaged_markup_is_said(tmp_path, old, new, words):
    sentence = sentence_of(tmp_path, replaced(text_vtp(), old, new, 9 if b"offsets" in old else 1))
    assert re.search(words, sentence), sentence


@pytest.mark.parametrize("encoded", [True, False])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZ4", "LZMA"])
def test_wrong_places_of_appended_arrays_are_said(tmp_path, compressor, encoded):
    data = appended_vtp(compressor, encoded)
    start = data.index(b'offset="', data.index(b'Name="Points"')) + len(b'offset="')
    end = data.index(b'"', start)
    offset = int(data[start:end])
    for wrong in (offset + 1, offset - 1, offset + 4, 2**33, 2**70, -1):
        sentence = sentence_of(tmp_path, data[:start] + b"%d" % wrong + data[end:])
        assert "array Points: expected" in sentence, sentence


def test_only_one_block_of_appended_data_is_taken(tmp_path):
    data = appended_vtp()
    second = b'<AppendedData encoding="base64">_AAAA</AppendedData></VTKFile>'
    assert "expected one AppendedData" in sentence_of(
        tmp_path, replaced(data, b"</VTKFile>", second)
    )


def test_nested_elements_and_long_tags_are_bounded(tmp_path):
    head = b'<VTKFile type="PolyData">'
    deep = head + b"<a>" * 200_000 + b"</a>" * 200_000 + b"</VTKFile>"
    assert "got more than 100 levels" in sentence_of(tmp_path, deep)
    many = head + b"<a/>" * 300_000 + b"</VTKFile>"
    assert "got more than 100 levels or 200000 elements" in sentence_of(tmp_path, many)
    long = head + b'<a b="' + b"x" * 5_000_000 + b'"/></VTKFile>'
    assert "got a tag of more than" in sentence_of(tmp_path, long)


def test_little_data_cannot_fill_the_memory(tmp_path):
    """Blocks that expand to more than they announce end there."""
    bomb = zlib.compress(bytes(10**8))
    header = np.array([1, 128, 128, len(bomb)], "<u4").tobytes()
    array = base64.b64encode(header) + base64.b64encode(bomb)
    data = (
        b'<VTKFile type="PolyData" compressor="vtkZLibDataCompressor"><PolyData><FieldData>'
        b'<DataArray type="UInt8" Name="bomb" format="binary">' + array + b"</DataArray>"
        b'</FieldData><Piece NumberOfPoints="0"/></PolyData></VTKFile>'
    )
    assert "array bomb: expected compressed data" in sentence_of(tmp_path, data)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (b"POINTS 18", b"POINTS -1", "expected a number from 0, got '-1'"),
        (b"POINTS 18", b"POINTS 8589934592", "up to the end of the file"),
        (b"POINTS 18 double", b"POINTS 18 string", "expected"),
        (b"POLYGONS 33 96", b"POLYGONS 33 95", "expected"),
        (b"POLYGONS 33 96", b"POLYGONS 32 96", "expected"),
        (b"FIELD FieldData 2\nlabel", b"FIELD FieldData\nlabel", "a number from 0, got 'la"),
        (b"FIELD FieldData 1\nSPACE", b"FIELD FieldData 9\nSPACE", "expected a number from 0"),
        (b"label 1 18", b"label 1 17", "expected"),
        (b"label 1 18 int", b"label 1 18 string", "expected"),
        (b"label 1 18 int", b"label 1 18 bit", "expected"),
        (b"label 1 18 int", b"label 0 18 int", "1 to 10000 components, got 0"),
        (b"POINT_DATA 18", b"POINT_DATA 17", "expected"),
        (b"DATASET POLYDATA", b"DATASET POLYDATA\nLINES 1 2 3", "expected"),
    ],
)
@pytest.mark.parametrize("kind", ["ASCII", "Binary"])
def test_a_damaged_legacy_header_is_said(tmp_path, kind, old, new, words):
    data = legacy_bytes(surface(), kind, 51)
    sentence = sentence_of(tmp_path, replaced(data, old, new), ".vtk")
    assert words in sentence


def test_long_words_and_lines_of_a_legacy_file_are_bounded(tmp_path):
    data = legacy_bytes(surface(), "ASCII", 51)
    for old, new in (
        (b"POINT_DATA", b"x" * 1_000_000 + b" POINT_DATA"),
        (b"POINTS 18", b"POINTS " + b"1" * 1_000_000),
        (b"RAS\n", b"R" * 1_000_000 + b"\n"),
    ):
        sentence_of(tmp_path, replaced(data, old, new), ".vtk")


@pytest.mark.parametrize("seed", range(3))
def test_several_pieces_are_joined_as_vtk_joins_them(tmp_path, seed):
    files = []
    for part in range(3):  # without strips, whose data VTK puts among those of the polygons
        random = random_polydata(seed, as_text=True)
        cut = vtkTriangleFilter()
        cut.SetInputData(random)
        cut.PassVertsOff() if part == 1 else cut.PassVertsOn()
        cut.Update()
        files.append(xml_bytes(cut.GetOutput(), "Ascii", "None", "UInt32", "Little", True, 9))
    pieces = [re.search(rb"<Piece.*</Piece>", data, re.DOTALL)[0] for data in files]
    path = tmp_path / "a.vtp"
    path.write_bytes(replaced(files[0], pieces[0], b"".join(pieces)))
    found = everything_of(read_vtk_polydata(read_content(path))[0])
    expected = everything_of(read_by_vtk(path))
    assert found == expected


# The strict readers of VTP and legacy VTK against VTK's own.


LAYOUTS = [
    *product(("Ascii",), ("None",), ("UInt32",), ("Little",), (True,), (32768,)),
    *product(
        ("Binary",), ("None", "ZLib", "LZ4", "LZMA"), ("UInt32", "UInt64"), ("Little", "Big"),
        (True,), (64, 32768),
    ),
    *product(
        ("Appended",), ("None", "ZLib", "LZ4", "LZMA"), ("UInt32", "UInt64"), ("Little", "Big"),
        (True, False), (64, 32768),
    ),
]  # fmt: skip


def assert_read_like_vtk_does(path, *, with_bits=True):
    """What is read by both; gives all of it."""
    whole = everything_of(read_vtk_polydata(read_content(path))[0])
    found = dict(whole)
    expected = everything_of(read_by_vtk(path))
    if not with_bits:  # VTK 9.6 fills bits of XML files with what the memory held
        for key in [key for key in found if str(found[key][0]).startswith("bit ")]:
            assert found.pop(key)[:4] == expected.pop(key)[:4]
    assert found == expected
    return whole


@pytest.mark.parametrize(
    "layout",
    [pytest.param(one, marks=[pytest.mark.bench] * (k % 3 > 0)) for k, one in enumerate(LAYOUTS)],
    ids=str,
)
def test_random_polydata_of_every_xml_layout_is_read_as_it_was_and_as_vtk_reads_it(
    tmp_path, layout
):
    path = tmp_path / "a.vtp"
    is_text = layout[0] == "Ascii"
    original = random_polydata(100 * LAYOUTS.index(layout), as_text=is_text)
    path.write_bytes(xml_bytes(original, *layout))
    found = assert_read_like_vtk_does(path, with_bits=is_text)
    assert found == everything_of(original)


@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("kind", ["ASCII", "Binary"])
def test_random_polydata_of_every_legacy_form_is_read_as_vtk_reads_it(tmp_path, kind, version):
    path = tmp_path / "a.vtk"
    for seed in range(15):
        path.write_bytes(
            legacy_bytes(random_polydata(seed, as_text=kind == "ASCII"), kind, version)
        )
        assert_read_like_vtk_does(path)


def test_the_anatomies_are_read_as_vtk_reads_them(data_dir):
    for path in sorted(data_dir.glob("*.vtp")):
        assert_read_like_vtk_does(path)
