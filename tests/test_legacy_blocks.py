import pytest

from SDFStentLib.files.formats.legacy_blocks import check_blocks
from SDFStentLib.validation import InputError

HEAD = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\n"
MESH = HEAD + "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
OLD_CELLS = "POLYGONS 1 4\n3 0 1 2\n"
NEW_CELLS = "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n"
INFORMATION = "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n\n"


@pytest.mark.parametrize(
    "tail",
    [
        OLD_CELLS,
        NEW_CELLS,
        OLD_CELLS.rstrip(),  # some writers leave the last line open
        INFORMATION + OLD_CELLS,
        OLD_CELLS + "POINT_DATA 3\nSCALARS s float 2\nLOOKUP_TABLE default\n1 2 3 4 5 6\n",
        OLD_CELLS + "POINT_DATA 3\nNORMALS n float\n0 0 1 0 0 1 0 0 1\n",
        OLD_CELLS + "CELL_DATA 1\nTENSORS t float\n0 0 0 0 0 0 0 0 0\n",
        OLD_CELLS + "CELL_DATA 1\nFIELD FieldData 2\na 1 1 int\n5\nb 2 1 string\nx\ny\n",
    ],
)
def test_whole_files_pass(tail):
    check_blocks((MESH + tail).encode(), "a.vtk")


@pytest.mark.parametrize(
    "tail",
    [
        "POLYGONS 1 4\n3 0 1",
        "POLYGONS 1 4\n",
        "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1",
        "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64",
        OLD_CELLS + "POINT_DATA 3\nSCALARS s float 2\nLOOKUP_TABLE default\n1 2 3 4 5\n",
        OLD_CELLS + "POINT_DATA 3\nVECTORS n float\n0 0 1 0 0 1 0 0\n",
        OLD_CELLS + "CELL_DATA 1\nFIELD FieldData 2\na 1 1 int\n5\nb 2 1 string\nx",
    ],
)
def test_missing_numbers_and_words_are_noticed(tail):
    with pytest.raises(InputError, match=r"a\.vtk: expected \d+ numbers or words in a block"):
        check_blocks((MESH + tail).encode(), "a.vtk")


def test_missing_arrays_and_points_are_noticed():
    tail = OLD_CELLS + "CELL_DATA 1\nFIELD FieldData 2\na 1 1 int\n5\n"
    with pytest.raises(InputError, match="1 of its arrays are missing"):
        check_blocks((MESH + tail).encode(), "a.vtk")
    with pytest.raises(InputError, match="expected POINTS, found none"):
        check_blocks(HEAD.encode(), "a.vtk")


def test_binary_strings_have_lengths():
    head = HEAD.replace("ASCII", "BINARY").encode() + b"POINTS 1 float\n" + bytes(12)
    head += b"\nPOINT_DATA 1\nFIELD FieldData 1\nname 2 1 string\n"
    long = b"x" * 100
    data = head + bytes([0xC3]) + b"abc" + bytes([0x80, 100]) + long
    check_blocks(data + b"\n", "a.vtk")
    for length in range(len(head), len(data)):
        with pytest.raises(InputError, match="cut short"):
            check_blocks(data[:length], "a.vtk")


def test_a_count_of_thousands_of_digits_is_no_count():
    with pytest.raises(InputError, match="expected POINTS, found none"):
        check_blocks(f"{HEAD}POINTS {'9' * 5000} float\n0 0 0\n".encode(), "a.vtk")
