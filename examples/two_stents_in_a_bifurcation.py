"""Two overlapping stents in a branching pulmonary artery, as one treatment with one certificate."""

from SDFStentLib import BetweenPoints, Stent, Treatment, read_centerline, read_surface
from SDFStentLib.samples import sample


def main():
    surface, centerline = sample("branching_pulmonary_artery")
    stents = [
        Stent(7.5, placement=BetweenPoints((0.0, 0, 19.0), (-11.8, 0, 34.9)), name="main"),
        Stent(7.5, placement=BetweenPoints((-8.3, 0, 33.1), (-17.7, 0, 36.0)), name="left"),
    ]
    treatment = Treatment(read_surface(surface).surface, stents, read_centerline(centerline))
    for state in treatment:  # stop iterating to cancel
        print(f"stent {state.number}: {100 * state.fraction:.0f} %")
    assert treatment.result.certificate.passed
    return min(stent.after.minimum for stent in treatment.result.stents)


if __name__ == "__main__":
    minimum = main()
    assert abs(minimum - 7.5) < 0.1
    print(f"narrowest lumen under the two stents: {minimum:.2f} mm")
