"""A stent along a curve of one's own; every step of the expansion stays addressable."""

from SDFStentLib import (
    AlongAxis,
    Deployment,
    DeploymentSettings,
    Stent,
    read_centerline,
    read_surface,
    stent_axis,
)
from SDFStentLib.samples import sample


def main():
    surface, centerline = sample("branching_pulmonary_artery")
    vessel, tree = read_surface(surface).surface, read_centerline(centerline)
    way = tree.path_around((-5.4, 0.0, 29.7), 20.0).points
    stent = Stent(7.0, placement=AlongAxis(way))
    axis = stent_axis(stent)
    settings = DeploymentSettings(smoothing_width=0.2)
    deployment = Deployment(vessel, settings.chain(axis.points), stent.radius, settings)
    widest = [state.radius for state in deployment]
    assert widest == sorted(widest)  # a slider can go back and forth over `deployment.states`
    return deployment.states[-1].radius


if __name__ == "__main__":
    radius = main()
    assert radius == 3.5
    print(f"final radius: {radius} mm")
