"""The paper's figure of three configurations: stents in main branches, daughter branches, or all.

    python -m benchmarks.three_plans DIR [--phantom]

The patient is the pulmonary artery of `SDFSTENT_DATA` (by default ../shared/data beside the
project) where that is present, else, and with --phantom, a synthetic tree whose branches are
narrowed likewise. The stents are those that `sdfstent suggest` proposes for the lesions.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from benchmarks.phantoms import vascular_tree
from SDFStentLib.cli import main as sdfstent
from SDFStentLib.files import add_arrays, encode_vtp, polydata_from_arrays, polydata_from_lines

DATA = Path(os.environ.get("SDFSTENT_DATA", Path(__file__).parents[2] / "shared" / "data"))
SURFACE, CENTERLINE = "pulmonary_surface_cm.vtp", "pulmonary_centerline_cm.vtp"
PLANS = {"main branches": (1, 2), "daughter branches": (3, 4), "all four": (1, 2, 3, 4)}
"""Which lesions each plan treats, the tightest is 1."""

NARROWED = {1: 0.5, 2: 0.45, 3: 0.4, 6: 0.35}
"""Of the tree: the share of its diameter that a branch loses; 1 and 2 are the main ones."""


def patient(folder: Path, is_phantom: bool) -> tuple[Path, Path, str]:
    """Surface, centerline and their unit."""
    if not is_phantom and (DATA / SURFACE).is_file():
        return DATA / SURFACE, DATA / CENTERLINE, "cm"
    tree = vascular_tree(4, 1.0, NARROWED)
    surface, centerline = folder / "surface.vtp", folder / "centerline.vtp"
    surface.write_bytes(encode_vtp(polydata_from_arrays(tree.points, tree.triangles)))
    axis = tree.centerline
    lines = polydata_from_lines(axis.points, [axis.ancestry(int(leaf)) for leaf in axis.leaves])
    add_arrays(lines, {"MaximumInscribedSphereRadius": axis.inscribed_radius}, {})
    centerline.write_bytes(encode_vtp(lines))
    return surface, centerline, "mm"


def main(folder: Path, is_phantom: bool = False) -> int:
    """Write the three plans and the page; the exit code of `sdfstent compare`."""
    folder.mkdir(parents=True, exist_ok=True)
    surface, centerline, units = patient(folder, is_phantom)
    plans = []
    for name, lesions in PLANS.items():
        plans.append(str(folder / f"{name}.json"))
        wanted = [word for number in lesions for word in ("--lesion", str(number))]
        vessel = [str(surface), "--units", units, "--centerline", str(centerline)]
        if sdfstent(["suggest", *vessel, *wanted, "-o", plans[-1], "--quiet"]):
            return 2
    picture = str(folder / "three_plans.png")
    return sdfstent(["compare", *plans, "-o", str(folder / "compared"), "--picture", picture])


if __name__ == "__main__":
    arguments = [word for word in sys.argv[1:] if word != "--phantom"]
    sys.exit(main(Path(arguments[0] if arguments else "three-plans"), "--phantom" in sys.argv))
