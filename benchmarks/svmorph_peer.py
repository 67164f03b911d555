"""Runs svmorph 0.1.2 (`pip install svmorph==0.1.2`) through a deployment without its window."""

from __future__ import annotations

import numpy as np

from SDFStentLib.field import CapsuleChain


class SvmorphPeer:
    """One stent in one vessel, deployed by svmorph's own contact function.

    It gets our axis nodes in the order in which we fold them, the same radii as rule `published`
    (last partial step included), and drags the same centerline points. Arrays are single
    precision, as svmorph reads them.
    """

    def __init__(
        self, points: np.ndarray, centerline: np.ndarray, axis: np.ndarray, start: float, end: float
    ) -> None:
        import jax.numpy as jnp
        from svmorph.core import units

        units.set_unit_scale(10.0)  # its constants are in cm, our coordinates in mm
        self.points = points.astype(np.float32)
        self.centerline = centerline.astype(np.float32)
        self.nodes = jnp.array(CapsuleChain.along(axis).nodes[::-1])
        self.end = end
        count = int(np.ceil(round((end - start) / 0.1, 9)))
        self.radii = np.minimum(start + 0.1 * np.arange(count + 1), end)

    def deployed(self) -> np.ndarray:
        """The surface points after all steps, mm."""
        from svmorph.core.deformation import compute_sdf_contact_displacements

        now = {"surface": self.points.copy(), "centerline": self.centerline.copy()}
        data = {"points": now, "nodes": {"force_center_point_id": 0}}
        for radius, growth in zip(self.radii, np.diff(self.radii), strict=False):
            surface, line, _ = compute_sdf_contact_displacements(
                data,
                self.nodes,
                s=-1.0,
                target_stent_radius=self.end,
                current_stent_radius=float(radius),
                f_scale=float(growth),
            )
            now["surface"] += surface.astype(np.float32)
            now["centerline"] += line.astype(np.float32)
        return now["surface"]
