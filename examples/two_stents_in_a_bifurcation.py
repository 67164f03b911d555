"""Two overlapping stents in a branching pulmonary artery, as one treatment with one certificate."""

from SDFStentLib import BetweenPoints, Stent, Treatment
from SDFStentLib.phantoms import branching_pulmonary_artery


def main():
    vessel = branching_pulmonary_artery()
    stents = [
        Stent(7.5, placement=BetweenPoints(*vessel.axis_at(ends)), name=name)
        for name, ends in (("main", (19, 40)), ("left", (36, 46)))
    ]
    treatment = Treatment(vessel.surface, stents, vessel.centerline)
    for state in treatment:  # stop iterating to cancel
        print(f"stent {state.number}: {100 * state.fraction:.0f} %")
    assert treatment.result.certificate.passed
    return min(stent.after.minimum for stent in treatment.result.stents)


if __name__ == "__main__":
    minimum = main()
    assert abs(minimum - 7.5) < 0.1
    print(f"narrowest lumen under the two stents: {minimum:.2f} mm")
