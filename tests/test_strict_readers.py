"""The strict readers of VTP and legacy VTK against VTK's own."""

from __future__ import annotations

from itertools import product

import pytest
from polydata_cases import (
    everything_of,
    legacy_bytes,
    random_polydata,
    read_by_vtk,
    xml_bytes,
)

from SDFStentLib.files.content import read_content
from SDFStentLib.files.formats.vtk_files import read_vtk_polydata

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


@pytest.mark.parametrize("layout", LAYOUTS, ids=str)
def test_random_polydata_of_every_xml_layout_is_read_as_it_was_and_as_vtk_reads_it(
    tmp_path, layout
):
    path = tmp_path / "a.vtp"
    is_text = layout[0] == "Ascii"
    for seed in range(2):
        original = random_polydata(seed + 100 * LAYOUTS.index(layout), as_text=is_text)
        path.write_bytes(xml_bytes(original, *layout))
        found = assert_read_like_vtk_does(path, with_bits=is_text)
        assert found == everything_of(original)


@pytest.mark.parametrize("version", [42, 51])
@pytest.mark.parametrize("kind", ["ASCII", "Binary"])
def test_random_polydata_of_every_legacy_form_is_read_as_vtk_reads_it(tmp_path, kind, version):
    path = tmp_path / "a.vtk"
    for seed in range(40):
        path.write_bytes(
            legacy_bytes(random_polydata(seed, as_text=kind == "ASCII"), kind, version)
        )
        assert_read_like_vtk_does(path)


def test_the_anatomies_are_read_as_vtk_reads_them(data_dir):
    for path in sorted(data_dir.glob("*.vtp")):
        assert_read_like_vtk_does(path)
