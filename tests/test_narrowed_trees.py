"""Trees of a patient's radii that others narrowed: each narrowing once, as it is."""

import numpy as np
import pytest

from SDFStentLib.plan import read_input_files

pytestmark = pytest.mark.bench

# Narrowest place, mm, its diameter, and those proximal and distal before it was narrowed.
KNOWN = {
    "tree_b": [
        ((-46.8, -273.3, -129.2), 1.98, 4.3, 4.5), ((3.7, -258.9, -123.0), 2.69, 5.1, 5.9),
        ((3.8, -232.5, -117.7), 2.03, 5.9, 4.3), ((16.2, -234.2, -145.0), 2.11, 4.8, 4.2),
    ],
    "tree_c": [
        ((14.5, -237.2, -141.3), 1.69, 4.9, 4.1), ((-62.9, -281.0, -135.8), 2.53, 5.6, 4.8),
        ((-4.8, -234.6, -131.3), 2.43, 4.5, 4.3), ((-58.8, -268.7, -117.3), 1.59, 4.5, 4.5),
    ],
    "tree_d": [
        # One more lies at the end of the trunk, 26 % against the vessel beyond: no more than the
        # widest vessel beyond a division has by itself.
        ((-55.0, -279.9, -130.3), 1.97, 4.1, 5.5), ((-4.1, -242.8, -127.4), 2.29, 4.6, 4.3),
        ((2.0, -231.4, -145.7), 2.11, 4.8, 4.7),
    ],
    "tree_e": [
        ((-0.8, -270.3, -117.5), 3.57, 10.1, 5.0), ((14.2, -246.3, -141.8), 3.59, 6.2, 6.1),
        ((1.8, -239.4, -120.0), 2.97, 6.3, 5.6), ((-24.3, -280.9, -124.9), 1.90, 6.1, 4.3),
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", list(KNOWN))
def test_narrowings_where_the_vessel_tapers_or_divides_are_told_once(name, data_dir):
    files = data_dir / f"{name}_surface_mm.vtp", data_dir / "tree_narrowed_centerline_mm.vtp"
    if not files[0].is_file():
        pytest.skip(f"no {files[0]}")
    lesions = read_input_files(*map(str, files)).vessel.lesions
    for place, narrowest, *sides in KNOWN[name]:
        near = [one for one in lesions if np.linalg.norm(np.subtract(one.point, place)) < 3.0]
        assert len(near) == 1, (place, near)
        assert near[0].minimum_diameter == pytest.approx(narrowest, rel=0.03)
        degrees = [100 * (1 - narrowest / side) for side in sides]
        assert min(degrees) - 5 <= near[0].percent_diameter <= max(degrees) + 5
