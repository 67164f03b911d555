"""Read, place, deploy, measure, certify: a stent of 7 mm in the narrow part of a sample vessel."""

from SDFStentLib import (
    CapsuleChain,
    certify,
    deploy,
    diameter_profile,
    read_centerline,
    read_surface,
)
from SDFStentLib.samples import sample
from SDFStentLib.stent import AtCenter, Stent, stent_axis


def main():
    surface, centerline = sample("branching_pulmonary_artery")
    vessel = read_surface(surface).surface
    stent = Stent(7.0, length=18.0, placement=AtCenter((-5.4, 0.0, 29.7)))
    axis = stent_axis(stent, read_centerline(centerline))
    chain = CapsuleChain.along(axis.points)
    result = deploy(vessel, chain, stent.radius)
    profile = diameter_profile(result.surface, axis.points)
    assert certify(vessel, result.surface).passed
    return profile.minimum


if __name__ == "__main__":
    minimum = main()
    assert abs(minimum - 7.0) < 0.07  # 1 %
    print(f"narrowest lumen under the stent: {minimum:.2f} mm")
