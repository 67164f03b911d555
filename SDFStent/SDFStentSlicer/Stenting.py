"""A pass over the plan's stents on arrays: every step recorded, then measured and certified. No nodes in here."""

from functools import partial
from typing import Any, NamedTuple

from slicer.i18n import tr as _

from SDFStentLib.scan import moved_cases, range_of_walls
from SDFStentLib.validation import DeploymentError, InputError

from . import Calculating
from .PlanFields import REMEDIES
from .Portions import inPortions, isPortion


class DrawnStent(NamedTuple):
    """The library's `PlacedStent`, at the largest radius that it has just now, mm."""

    placed: Any
    radius: float

    @classmethod
    def whole(cls, placed):
        """The stent as wide as it becomes."""
        return cls(placed, placed.stent.widest_diameter / 2)

    @property
    def stent(self):
        """The stent with all of its sizes."""
        return self.placed.stent

    @property
    def axis(self):
        """The axis on which it lies."""
        return self.placed.axis


def lying(drawn):
    """The stents by their numbers, from the first one on, that no later one has dilated again: it is as wide by now."""
    outgrown = {
        one.placed.earlier
        for one in drawn.values()
        if one.placed.earlier is not None and one.radius >= drawn[one.placed.earlier].radius
    }
    return [one for number, one in drawn.items() if number not in outgrown]


class Stenting:
    """The library's treatment with all its states kept, so that a slider can go back and forth over them.

    `result` is the library's `TreatmentResult` once `measure` was run to its end, `case` its `TreatedCase`; `points` and `centerline` are current after
    `steps`.
    """

    def __init__(self, case, *, places=(), search=None, remark="", halfVoxel=None):
        """Hold the stents of the library's `Case`.

        `places` says for every stent by what the caller finds it again. `search` is the `LesionSearch` of the vessel, `remark`
        what to know of its surface, `halfVoxel` half a voxel, mm, where it was made of voxels.
        """
        self._calculation, self._treatment = Calculating.calculation(case)
        self._planned, self._half, self._walls = case, halfVoxel, ()
        self.surface, self.centerline = case.vessel.surface, case.vessel.centerline
        self.points = self.surface.points
        self.recorded, self._axes = [], {}
        self.places, self.result, self.case = list(places), None, None
        self.search, self.remark = search, remark
        self.flow, self.flowRemark = None, ""
        self.voxels, self.voxelRemark = None, ""
        self.shownMap = self.shownStent = self.shownFlow = None

    def steps(self):
        """Deploy; yields a `TreatmentState` after every radius step.

        And a portion about every 5 ms while a step is being computed: the last one of a stent also finishes and certifies
        the lumen, which may take a second.
        """
        for state in self._calculation.states():
            if not isPortion(state):
                if state.number not in self._axes:
                    self._follow()
                    self._axes[state.number] = DrawnStent.whole(state.placed)
                self.recorded.append(state)
            yield state
        self._follow()

    @property
    def measured(self):
        """The library's stents with what was measured of them; none before `measure` has come to its end."""
        return () if self.result is None else self.result.stents

    def label(self, number):
        """Name of a stent of the plan in messages."""
        return self._treatment.label(number)

    def lines(self):
        """The ways down the moved centerline, as rows of its points; yields None until they are found."""
        tree = self.centerline
        if tree is None:
            return []
        return (yield from inPortions(lambda: [tree.ancestry(leaf) for leaf in tree.leaves]))

    def survey(self):
        """Measure what does not depend on the steps; yields None until it is done."""
        yield from self._calculation.survey()

    def measure(self):
        """Diameters, certificate and lesions of the finished treatment; yields None until it is done."""
        if self.search is not None:
            yield from self.search.portions()
        found = None if self.search is None else self.search.found
        case = yield from self._calculation.told(found)
        self.result, self.case = case.told, case

    @property
    def lesions(self):
        """Lesions of the vessel before and after, the library's `TreatedLesion`; None before they are known, and without a centerline."""
        return None if self.case is None else self.case.lesions

    def findFlow(self, known):
        """Find pressures and flows for flow data; yields None until they are found. Once `measure` was run to its end.

        `flow` is the library's `FlowAnswer` then, or None, and `flowRemark` says why.
        """
        self.shownFlow, self.flow, self.flowRemark = known, None, ""
        if known is None:
            return
        search, result = self.search, self.result
        try:
            if search is None:
                raise InputError(
                    _(
                        "Results: expected a centerline to know the flow by, got none; choose it, or no flow."
                    )
                )
            self.flow = yield from inPortions(lambda: search.flow(known, result))
        except InputError as error:
            self.flowRemark = error.sentence(REMEDIES)
        except DeploymentError as error:
            self.flowRemark = str(error)

    def findRange(self):
        """Find the range that half a voxel makes of the numbers; yields None until it is found. Once `measure` was run to its end.

        `voxels` is the library's `VoxelRange` then, None for a vessel that was not made of voxels, or `voxelRemark` says why. Pressures
        are in there as `findFlow` was asked for them last.
        """
        treated = self._planned, self.case
        half, flow = self._half, self.flow
        if half is None:
            return
        self.voxels, self.voxelRemark = None, ""
        try:
            if not self._walls:
                moved = yield from inPortions(lambda: moved_cases(*treated, half))
                self._walls = yield from _treatedWalls(moved)
            walls = self._walls
            self.voxels = yield from inPortions(lambda: range_of_walls(*treated, walls, half, flow))
        except InputError as error:
            self.voxelRemark = error.sentence(REMEDIES)
        except DeploymentError as error:
            self.voxelRemark = str(error)

    def at(self, percent):
        """Points at a percentage of the way, and a `DrawnStent` for every stent that is there by then.

        Between two recorded steps of a stent both are interpolated.
        """
        reached = [state for state in self.recorded if state.fraction <= percent / 100 + 1e-9]
        if not reached:
            return self.surface.points, []
        state = reached[-1]
        points, radius = state.points(), state.deployment.radius
        if len(reached) < len(self.recorded) and self.recorded[len(reached)].number == state.number:
            following = self.recorded[len(reached)]
            share = (percent / 100 - state.fraction) / (following.fraction - state.fraction)
            points = points + share * (following.points() - points)
            radius += share * (following.deployment.radius - radius)
        done = {number: tube for number, tube in self._axes.items() if number < state.number}
        return points, lying(
            {**done, state.number: self._axes[state.number]._replace(radius=radius)}
        )

    def end(self):
        """The final points, and every stent as a `DrawnStent`."""
        return self.points, lying(self._axes)

    @property
    def drawn(self):
        """`DrawnStent`s of all stents, also of one that is dilated again later."""
        return list(self._axes.values())

    def _follow(self):
        """Take over surface and centerline from the last recorded state."""
        if self.recorded:
            self.points = self.recorded[-1].points()
            if self.centerline is not None:
                self.centerline = self.centerline.with_points(
                    self.recorded[-1].deployment.companions
                )


def _alone(case):
    """Calculation of a case beside which previews go on."""
    return Calculating.calculation(case, mayShare=False)


def _treatedWalls(moved):
    """`TreatedCase`s of the library's `MovedCase`s; yields portions until all are measured."""
    walls = []
    for one in moved:
        calculation, _treatment = yield from inPortions(partial(_alone, one.case))
        for state in calculation.states():
            yield state if isPortion(state) else None
        walls.append((yield from calculation.told(one.lesions)))
    return walls
