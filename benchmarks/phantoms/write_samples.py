"""The two sample vessels that the project ships, made of phantoms.

python -m benchmarks.phantoms.write_samples
"""

from __future__ import annotations

from SDFStentLib.files import (
    add_arrays,
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    set_face_names,
    set_frame_of_polydata,
)
from SDFStentLib.samples import Sample, sample

from . import Phantom, arch_with_coarctation, branching_pulmonary_artery


def write(phantom: Phantom, to: Sample) -> None:
    """Write the surface with SimVascular's face ids, and the centerline as VMTK would give it."""
    surface = polydata_from_arrays(
        phantom.points, phantom.triangles, cell_arrays={"ModelFaceID": phantom.face_ids}
    )
    set_face_names(surface, phantom.faces.names)
    tree = phantom.centerline
    lines = polydata_from_lines(tree.points, [tree.ancestry(int(leaf)) for leaf in tree.leaves])
    add_arrays(lines, {"MaximumInscribedSphereRadius": tree.inscribed_radius}, {})
    for path, polydata in ((to.surface, surface), (to.centerline, lines)):
        set_frame_of_polydata(polydata, "RAS")
        path.write_bytes(encode_vtp(polydata))


if __name__ == "__main__":
    for make in (branching_pulmonary_artery, arch_with_coarctation):
        write(make(), sample(make.__name__))
