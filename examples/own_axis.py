"""A stent along a curve of one's own; every step of the expansion stays addressable."""

from SDFStentLib import AlongAxis, Deployment, DeploymentSettings, Stent, stent_axis
from SDFStentLib.phantoms import bent_tube


def main():
    vessel = bent_tube(radius=3.0, bend_radius=15.0)
    stent = Stent(7.0, placement=AlongAxis(vessel.axis_at(range(12, 32))))
    axis = stent_axis(stent)
    settings = DeploymentSettings(smoothing_width=0.2)
    deployment = Deployment(vessel.surface, settings.chain(axis.points), stent.radius, settings)
    widest = [state.radius for state in deployment]
    assert widest == sorted(widest)  # a slider can go back and forth over `deployment.states`
    return deployment.states[-1].radius


if __name__ == "__main__":
    radius = main()
    assert radius == 3.5
    print(f"final radius: {radius} mm")
