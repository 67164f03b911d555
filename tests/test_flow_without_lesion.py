"""A vessel without a lesion has a drop along it, and that is told."""

import json
import re

import numpy as np
import pytest
from tube_files import write_vessel

from benchmarks.phantoms import straight_tube

VISCOSITY, MMHG = 4e-3, 133.322
"""Pa s, and Pa."""


@pytest.mark.parametrize(("radius", "length"), [(3.0, 50.0), (5.0, 90.0)])
def test_flow_without_a_lesion_tells_the_drop_along_the_vessel(tmp_path, shell, radius, length):
    vessel = straight_tube(radius, length, edge_length=radius / 6)
    write_vessel(tmp_path, vessel)
    run = shell(
        "flow", "pa.vtp", "--units", "cm", "--centerline", "line.vtp", "--mean-flow", "3L/min",
        "--json", "f.json", folder=tmp_path,
    )  # fmt: skip
    assert run.returncode == 0
    found = re.search(
        r"At the mean flow of 50 mL/s \(3 L/min\):\n  drop over (\d+) mm of vessel from the inlet "
        r"to the farthest end: recovered ([\d.]+) \(",
        run.stdout,
    )
    assert float(found[1]) == pytest.approx(length, abs=1)
    # Hagen and Poiseuille.
    drop = 8 * VISCOSITY * length * 1e-3 * 50e-6 / (np.pi * (radius * 1e-3) ** 4) / MMHG
    assert float(found[2]) == pytest.approx(drop, rel=0.05)
    document = json.loads((tmp_path / "f.json").read_text(encoding="utf-8"))
    (narrowing,) = document["before"]["mean"]["narrowings"]
    assert narrowing["recovered_mmhg"]["value"] == pytest.approx(drop, rel=0.03)
