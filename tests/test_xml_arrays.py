from base64 import b64encode
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from mesh_files import octahedron
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from SDFStentLib.files.content import FileContent
from SDFStentLib.files.formats.vtk_files import read_vtk_polydata
from SDFStentLib.files.formats.xml_arrays import check_arrays
from SDFStentLib.files.polydata import polydata_from_arrays
from SDFStentLib.validation import InputError

MODES = ("Ascii", "Binary", "Appended")
COMPRESSORS = ("None", "ZLib", "LZ4", "LZMA")


def vtp(mode="Appended", compressor="ZLib", words="UInt32", order="Little", encoded=True, rounds=3):
    points, triangles = octahedron(rounds=rounds)
    arrays = {"zero": np.zeros((len(points), 9)), "name of ä>b": np.arange(len(points))}
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(polydata_from_arrays(points, triangles, arrays))
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeTo{words}")()
    getattr(writer, f"SetByteOrderTo{order}Endian")()
    writer.SetEncodeAppendedData(encoded)
    writer.SetBlockSize(1024 if rounds == 3 else 2**22)
    writer.WriteToOutputStringOn()
    writer.Write()
    written = writer.GetOutputString()
    return written.encode() if isinstance(written, str) else written


@pytest.mark.parametrize(("mode", "compressor"), list(product(MODES, COMPRESSORS)))
def test_whole_files_of_every_layout_pass(mode, compressor):
    for words, order, encoded, rounds in product(
        ("UInt32", "UInt64"), ("Little", "Big"), (True, False), (1, 3)
    ):
        check_arrays(vtp(mode, compressor, words, order, encoded, rounds), "a.vtp")


@pytest.mark.parametrize("compressor", COMPRESSORS)
@pytest.mark.parametrize("encoded", [True, False])
def test_lost_bytes_are_noticed_before_vtk_asks_for_memory(compressor, encoded):
    data = vtp(compressor=compressor, encoded=encoded)
    start = data.index(b"<AppendedData")
    for lost in (1, 7, 165):
        cut = data[: start + 300] + data[start + 300 + lost :]
        # Without coding, a shifted word may be a small one by chance; VTK notices then.
        words = "the file is damaged" if not encoded else "announces more than the file holds"
        with pytest.raises(InputError, match=words):
            read_vtk_polydata(FileContent(Path("a.vtp"), cut, ""))


@pytest.mark.parametrize(
    ("compressor", "words"),
    [
        (b"", [10**9]),
        (b'compressor="vtkZLibDataCompressor"', [2**31, 32768, 0, 9]),
        (b'compressor="vtkZLibDataCompressor"', [1, 2**31, 0, 9]),
        (b'compressor="vtkZLibDataCompressor"', [1, 32, 2**31, 9]),
        (b'compressor="vtkZLibDataCompressor"', [1, 32, 0, 2**31]),
        (b'compressor="vtkZLibDataCompressor"', [2, 32, 0]),
    ],
)
@pytest.mark.parametrize("kind", ["<u4", ">u4", "<u8"])
def test_every_word_of_a_header_is_compared_with_the_file(compressor, words, kind):
    order = b"BigEndian" if kind[0] == ">" else b"LittleEndian"
    bits = b"UInt64" if kind[2] == "8" else b"UInt32"
    head = b'<VTKFile type="PolyData" byte_order="%s" header_type="%s" %s>' % (
        order, bits, compressor,
    )  # fmt: skip
    array = b64encode(np.array(words, kind).tobytes())
    for inner in (
        b'<DataArray Name="one" format="binary">%s</DataArray>' % array,
        b"<DataArray Name='one' format='appended' offset='0'/><AppendedData encoding='base64'> _"
        + array,
        b"<DataArray Name='one' format='appended' offset='0'/><AppendedData encoding='raw'> _"
        + np.array(words, kind).tobytes(),
    ):
        with pytest.raises(InputError, match="its array one announces more than the file holds"):
            check_arrays(head + inner + b"</VTKFile>", "a.vtp")


@pytest.mark.parametrize(
    "inner",
    [
        b'<Array format="appended" offset="0"/>',
        b'<Array format="appended" offset="99"/><AppendedData encoding="raw">_1234</AppendedData>',
        b'<Array format="appended" offset="-1"/><AppendedData encoding="raw">_1234</AppendedData>',
        b'<Array format="appended"/><AppendedData encoding="raw">_1234</AppendedData>',
        b'<Array format="binary">&amp;</Array>',
        b'<Array format="binary"></Array>',
    ],
)
def test_an_array_that_is_nowhere_is_damage(inner):
    with pytest.raises(InputError, match="its array without a name announces more"):
        check_arrays(b"<VTKFile>" + inner + b"</VTKFile>", "a.vtp")


@pytest.mark.parametrize("compressor", [b"", b'compressor="vtkZLibDataCompressor"'])
def test_an_empty_list_of_cells_is_damage_only_where_there_are_cells(compressor):
    array = b64encode(np.zeros(3, "<u4").tobytes())
    text = (
        b'<VTKFile %s><Piece NumberOfPolys="%%d"><Polys><DataArray Name="offsets" '
        b'format="binary">%s</DataArray></Polys></Piece></VTKFile>' % (compressor, array)
    )
    check_arrays(text % 0, "a.vtp")
    with pytest.raises(InputError, match=r"its array offsets announces .*, or is empty"):
        check_arrays(text % 1, "a.vtp")


@pytest.mark.parametrize("lost", [3, 20])
@pytest.mark.parametrize("encoded", [True, False])
def test_bytes_lost_from_the_last_array_are_noticed(encoded, lost):
    data = vtp(compressor="None", encoded=encoded)
    end = data.rindex(b"</AppendedData")
    cut = data[: end - 200] + data[end - 200 + lost :]
    with pytest.raises(InputError, match="its array offsets announces more"):
        check_arrays(cut, "a.vtp")
