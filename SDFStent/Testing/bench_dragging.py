"""Frames per second while a stent is dragged over a real artery, in the test host.

usage: bench_dragging.py [SURFACE CENTERLINE] [--units cm]

Moves the placement point 60 times along the centerline, with stents of 6 to 20 mm, and prints redeployments per second, radius
steps per second when every step is drawn, and where the time goes: the library, the scene (MRML, normals, markups), the
drawing (off-screen, software rendering unless there is a GPU). Without arguments the synthetic pulmonary artery is used.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from sdfstent_host import Host

MOVES = 60
LENGTHS = (6.0, 10.0, 14.0, 20.0)


class Clock:
    """Seconds per name."""

    def __init__(self):
        self.seconds = {}

    def timed(self, name, function):
        def run(*arguments, **keywords):
            start = time.perf_counter()
            try:
                return function(*arguments, **keywords)
            finally:
                self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

        return run


def theArtery(arguments):
    from SDFStentSlicer import SampleVessels

    if not arguments.surface:
        return SampleVessels.addSampleVessel("branching_pulmonary_artery", "Artery")
    import slicer

    from SDFStentLib.centerline_files import read_centerline
    from SDFStentLib.polydata import polydata_from_arrays
    from SDFStentLib.surface_files import read_surface

    surface = read_surface(arguments.surface, arguments.units)
    centerline = read_centerline(arguments.centerline, arguments.units)
    polyDatas = (
        polydata_from_arrays(surface.points.astype(np.float32), surface.triangles),
        SampleVessels.centerlinePolyData(getattr(centerline, "centerline", centerline)),
    )
    nodes = [slicer.mrmlScene.AddNewNodeByClass("vtkMRMLModelNode") for _ in polyDatas]
    for node, polyData in zip(nodes, polyDatas, strict=True):
        node.SetAndObservePolyData(polyData)
        node.CreateDefaultDisplayNodes()
    return nodes


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surface", nargs="?")
    parser.add_argument("centerline", nargs="?")
    parser.add_argument("--units", default="mm")
    arguments = parser.parse_args()
    host = Host.start()
    entry = host.loadModule(Path(__file__).parents[1] / "SDFStent.py")
    from SDFStentSlicer.Display import SurfaceOutput

    logic = entry.python.SDFStentLogic()
    parameters = logic.getParameterNode()
    parameters.vessel, parameters.centerline = theArtery(arguments)
    handle = logic.addStent(parameters, length=14.0)
    tree = logic._inputs.centerline(parameters)
    leaf = tree.leaves[np.argmax(tree.arc_length[tree.leaves])]
    chain = tree.points[tree.ancestry(leaf)]
    places = chain[np.linspace(0.2 * len(chain), 0.8 * len(chain), MOVES).astype(int)]
    logic.deploy(parameters)
    view = host.application.view
    view.render(parameters.outputVessel.GetPolyData().GetBounds())
    triangles = parameters.outputVessel.GetPolyData().GetNumberOfPolys()
    print(
        f"{triangles:,} triangles, {MOVES} moves, stents of {min(LENGTHS):g} to {max(LENGTHS):g} mm"
    )

    clock = Clock()
    SurfaceOutput.show = clock.timed("scene", SurfaceOutput.show)
    render = clock.timed("drawing", view.render)
    for drawn in ("end", "every step"):
        clock.seconds.clear()
        steps, start = 0, time.perf_counter()
        for move, place in enumerate(places):
            handle.SetNthControlPointPositionWorld(0, *place)
            parameters.stent.length = LENGTHS[move % len(LENGTHS)]
            logic.stentList(parameters).replace(
                [{**logic.stentList(parameters).values()[0], "length": parameters.stent.length}], 0
            )
            for _fraction in logic.steps(parameters, live=True):
                steps += 1
                if drawn == "every step":
                    render()
            if drawn == "end":
                render()
        seconds = time.perf_counter() - start
        shares = {name: value / seconds for name, value in clock.seconds.items()}
        shares["library and module"] = 1 - sum(shares.values())
        print(
            f"drawn at {drawn}: {MOVES / seconds:.1f} redeployments per second, {steps / seconds:.0f} radius steps per second"
        )
        print("   " + ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items()))


if __name__ == "__main__":
    main()
