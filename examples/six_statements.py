"""The six statements, from files to numbers; the same six as in the README."""

# ruff: noqa: I001 (two import lines read better than ten)

import sys
from pathlib import Path

from SDFStentLib import AtCenter, CapsuleChain, Stent, deploy, diameter_profile
from SDFStentLib import read_centerline, read_surface, stent_axis


def main(folder, center=(-5.0, 0.0, 30.0)):
    # 1. Read a surface and a centerline.
    vessel = read_surface(Path(folder) / "surface.vtp")
    centerline = read_centerline(Path(folder) / "centerline.vtp")
    # 2. Choose a stent, and 3. place it: that gives the stent axis.
    stent = Stent(7.5, length=20.0, placement=AtCenter(center))
    axis = stent_axis(stent, centerline)
    # 4. Build the capsule chain.
    chain = CapsuleChain.along(axis.points)
    # 5. Deploy.
    result = deploy(vessel.surface, chain, stent.radius)
    # 6. Measure and certify.
    profile = diameter_profile(result.surface, axis.points)
    print(result.certificate.sentence())
    return profile.minimum


if __name__ == "__main__":
    minimum = main(sys.argv[1] if len(sys.argv) > 1 else "sdfstent-demo")
    assert abs(minimum - 7.5) < 0.1
    print(f"narrowest lumen under the stent: {minimum:.2f} mm")
