"""Phantoms as files, mainly a stenosed tube in cm, and the command line with them."""

import numpy as np

from benchmarks.phantoms import stenosed_tube
from SDFStentLib.cli import main
from SDFStentLib.files import add_arrays, encode_vtp, polydata_from_arrays, polydata_from_lines

INPUTS = {"units": "cm", "surface": {"file": "tube.vtp"}, "centerline": {"file": "line.vtp"}}
PLACE = ["--center", "0", "0", "2", "--length", "20"]  # cm; the throat of the tube


def write_wall(path, *surface):
    """Write what `polydata_from_arrays` makes a surface of."""
    path.write_bytes(encode_vtp(polydata_from_arrays(*surface)))


def write_line(path, points):
    """Write one line through some points."""
    path.write_bytes(encode_vtp(polydata_from_lines(points, [np.arange(len(points))])))


def write_tube(folder):
    """Write the tube, its centerline and an axis through its throat."""
    vessel = stenosed_tube(edge_length=1.0)
    surface = polydata_from_arrays(
        (vessel.points / 10).astype(np.float32),
        vessel.triangles,
        cell_arrays={"ModelFaceID": vessel.face_ids},
    )
    tree = vessel.centerline
    count = len(tree.points)
    line = polydata_from_lines(tree.points / 10, [np.arange(count)])
    add_arrays(line, {"MaximumInscribedSphereRadius": tree.inscribed_radius / 10}, {})
    axis = polydata_from_lines([[0, 0, 1.2], [0, 0, 2.8]], [np.arange(2)])
    for name, data in (("tube", surface), ("line", line), ("axis", axis)):
        (folder / f"{name}.vtp").write_bytes(encode_vtp(data))


def write_vessel(folder, vessel, surface="pa.vtp", line="line.vtp", *, per_mm=0.1, radii=False):
    """Write a phantom in cm: its wall, with ids of faces but without names, and its centerline."""
    wall = polydata_from_arrays(per_mm * vessel.points, vessel.triangles)
    add_arrays(wall, {}, {"ModelFaceID": vessel.face_ids.astype(np.int32)})
    tree = vessel.centerline
    lines = polydata_from_lines(per_mm * tree.points, [tree.ancestry(leaf) for leaf in tree.leaves])
    if radii:
        add_arrays(lines, {"MaximumInscribedSphereRadius": per_mm * tree.inscribed_radius}, {})
    for name, data in ((surface, wall), (line, lines)):
        (folder / name).write_bytes(encode_vtp(data))


def plan_of(*stents, **more):
    """The document of a plan for the tube."""
    plan = {"schema": "sdfstent-plan", "version": 2, "inputs": INPUTS, "stents": [*stents]}
    return {**plan, **more}


def deploy(*more, place=PLACE, surface="tube.vtp", line="line.vtp", out="out.vtp", diameter="6"):
    arguments = ["deploy", surface, "--units", "cm", *place]
    if diameter:
        arguments += ["--diameter", diameter]
    if line:
        arguments += ["--centerline", line]
    return main([*arguments, "-o", out, *more])
