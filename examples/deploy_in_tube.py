"""The six statements on a synthetic vessel: a stenosed tube of 6 mm gets a stent of 6 mm."""

from SDFStentLib import CapsuleChain, certify, deploy, diameter_profile
from SDFStentLib.phantoms import stenosed_tube
from SDFStentLib.stent import AtCenter, Stent, stent_axis


def main():
    vessel = stenosed_tube(radius=3.0, throat_radius=1.8)
    stent = Stent(6.0, length=20.0, placement=AtCenter(vessel.throat.point))
    axis = stent_axis(stent, vessel.centerline)
    chain = CapsuleChain.along(axis.points)
    result = deploy(vessel.surface, chain, stent.radius)
    profile = diameter_profile(result.surface, axis.points)
    assert certify(vessel.surface, result.surface).passed
    return profile.minimum


if __name__ == "__main__":
    minimum = main()
    assert abs(minimum - 6.0) < 0.06  # 1 %
    print(f"narrowest lumen under the stent: {minimum:.2f} mm")
