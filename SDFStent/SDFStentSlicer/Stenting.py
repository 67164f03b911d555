"""One pass over the plan's stents on arrays: every step recorded, then measured and certified. No nodes in here."""

from dataclasses import dataclass

import numpy as np

from SDFStentLib.certificate import certify
from SDFStentLib.deployment import Deployment
from SDFStentLib.metrics import diameter_profile, stenosis
from SDFStentLib.stent import stent_axis
from SDFStentLib.stretch import displacements, face_stretches
from SDFStentLib.untangle import Precision

PROFILE_SPACING = 1.0


@dataclass(frozen=True)
class RecordedStep:
    """What one radius step of one stent left: coordinates of the points that this stent has moved so far."""

    stent: int
    fraction: float
    radius: float
    indices: np.ndarray
    coordinates: np.ndarray


@dataclass(frozen=True)
class StentResult:
    """Diameters along one stent before any stent and after all of them, and what to know about its axis."""

    label: str
    diameter: float
    before: object
    after: object
    warnings: tuple

    def summary(self):
        """The sentence that a clinician reads first."""
        narrow = stenosis(self.after, reference_profile=self.before)
        was = stenosis(self.before)
        return (
            f"{self.label}: minimum lumen {self.before.minimum:.1f} \N{RIGHTWARDS ARROW} {self.after.minimum:.1f} mm, "
            f"mean {self.before.mean:.1f} \N{RIGHTWARDS ARROW} {self.after.mean:.2f} mm ({self.diameter:.1f} prescribed), "
            f"diameter stenosis {was.percent_diameter:.0f} \N{RIGHTWARDS ARROW} {narrow.percent_diameter:.0f} %"
        )


class Stenting:
    """Deploys stents in order, each into the vessel as the ones before have left it."""

    def __init__(
        self,
        points,
        triangles,
        centerline,
        stents,
        settings,
        *,
        straightening=0.0,
        dtype=np.float32,
    ):
        """`stents` is a list of (label, library stent); `dtype` is the type in which the result is stored."""
        self.original = self.points = points
        self.triangles, self.centerline = triangles, centerline
        self._stents, self._straightening, self._precision = (
            stents,
            straightening,
            Precision(dtype=np.dtype(dtype)),
        )
        self._settings = settings.with_changes(
            certify=False
        )  # the whole plan gets one certificate, in `measure`
        self.bases, self.axes, self.recorded, self.warnings = [], [], [], []
        self.results, self.certificate, self.shownMap = (), None, None

    def steps(self):
        """Deploy; yields the fraction done after every radius step, with the step in `recorded`."""
        for number, (label, stent) in enumerate(self._stents):
            axis = stent_axis(stent, self.centerline, straightening_fraction=self._straightening)
            self.bases.append(self.points)
            self.axes.append(axis)
            self.warnings += [f"{label}: {warning}" for warning in axis.warnings]
            yield from self._expand(number, label, axis, stent)

    def _expand(self, number, label, axis, stent):
        deployment = Deployment(
            self.points,
            self.triangles,
            axis.points,
            stent.radius,
            self._settings,
            companions=None if self.centerline is None else self.centerline.points,
            precision=self._precision,
        )
        for state in deployment:
            fraction = (number + state.fraction) / len(self._stents)
            self.recorded.append(
                RecordedStep(number, fraction, state.radius, state.indices, state.coordinates)
            )
            yield fraction
        result = deployment.result
        self.points = result.points
        self.warnings += [f"{label}: {warning}" for warning in result.warnings]
        if self.centerline is not None:
            self.centerline = self.centerline.with_points(result.state.companions)

    def measure(self):
        """Diameters, then the certificate; yields between the parts so that others get a turn."""
        results = []
        for (label, stent), axis in zip(self._stents, self.axes, strict=True):
            before = diameter_profile(self.original, self.triangles, axis.points, PROFILE_SPACING)
            yield
            after = diameter_profile(self.points, self.triangles, axis.points, PROFILE_SPACING)
            results.append(StentResult(label, stent.diameter, before, after, axis.warnings))
            yield
        self.results = tuple(results)
        self.certificate = certify(
            self.original, self.points, self.triangles, dtype=self._precision.dtype
        )
        yield

    def at(self, percent):
        """All points at a percentage of the way, and the (axis points, radius) of every stent that is there by then.

        Between two recorded steps of a stent both are interpolated.
        """
        reached = [step for step in self.recorded if step.fraction <= percent / 100]
        if not reached:
            return self.original, []
        step = reached[-1]
        points, radius = self._pointsOf(step), step.radius
        if len(reached) < len(self.recorded) and self.recorded[len(reached)].stent == step.stent:
            following = self.recorded[len(reached)]
            share = (percent / 100 - step.fraction) / (following.fraction - step.fraction)
            points = points + share * (self._pointsOf(following) - points)
            radius += share * (following.radius - radius)
        return points, self._tubes(step.stent, radius)

    def end(self):
        """The final points and tubes."""
        return self.points, self._tubes(len(self._stents) - 1, self._stents[-1][1].radius)

    def _pointsOf(self, step):
        points = self.bases[step.stent].copy()
        points[step.indices] = step.coordinates
        return points

    def _tubes(self, stent, radius):
        done = [(self.axes[i].points, self._stents[i][1].radius) for i in range(stent)]
        return [*done, (self.axes[stent].points, radius)]

    def map(self, name):
        """Values of a surface map and whether they belong to the cells."""
        if name == "Displacement":
            return displacements(self.original, self.points), False
        return face_stretches(self.original, self.points, self.triangles).area, True
