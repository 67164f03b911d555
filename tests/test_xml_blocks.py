import pytest

from SDFStentLib.files.formats.xml_blocks import check_announced_sizes
from SDFStentLib.validation import InputError


def vtp(inner):
    return f'<VTKFile type="PolyData"><PolyData>{inner}</PolyData></VTKFile>'.encode()


@pytest.mark.parametrize(
    "inner",
    [
        '<PointData><DataArray Name="hash" RangeMin="100000000" RangeMax="18446744073709551615"/>',
        '<CellData><DataArray Name="offsets" RangeMin="0" RangeMax="99999999999"/></CellData>',
        '<Polys><DataArray Name="offsets" RangeMin="3" RangeMax="9"/></Polys><CellData>'
        '<DataArray Name="connectivity" RangeMax="99999999999"/></CellData>',
        '<Piece NumberOfPoints="3" NumberOfPolys="1"/>',
    ],
)
def test_large_values_are_no_sizes(inner):
    check_announced_sizes(vtp(inner), "a.vtp")


@pytest.mark.parametrize(
    ("inner", "count"),
    [
        ('<Piece NumberOfPoints="99999999999"/>', "99999999999"),
        ("<Piece NumberOfPolys = '99999999999'/>", "99999999999"),
        ('<DataArray NumberOfComponents="99999999999"/>', "99999999999"),
        ('<Polys><DataArray Name="offsets" RangeMax="99999999999"/></Polys>', "99999999999"),
        ('<Lines><DataArray RangeMin="99999999999" Name="connectivity"/>', "99999999999"),
        (f'<Piece NumberOfPoints="{"9" * 5000}"/>', "9" * 25),
    ],
)
def test_counts_and_ranges_of_cells_are_sizes(inner, count):
    with pytest.raises(InputError, match=rf"a.vtp: its header announces {count} elements, too"):
        check_announced_sizes(vtp(inner), "a.vtp")
