"""The stents of a plan: what the logic adds, removes and moves of them."""

import numpy as np
import slicer

from SDFStentLib.plan import NEW_STENT, Row, lying, placement_document
from SDFStentLib.validation import InputError

from . import Conversion, Dependencies, Handles, Plans
from .LumenMiddle import middleOn
from .ParameterNode import stentOf, stentsOf
from .PlanFields import STENT_FIELDS, Placement
from .Portions import untilDone
from .StentList import StentList

BESIDE = 2 * Handles.ON_ANOTHER
"""Distance of a stent and its copy, mm, at which points of both can be told apart."""

SHORTEST = 1.0
"""The length to which a stent can be drawn together, mm."""


class Planning:
    """A part of `SDFStentLogic`: every method changes the stents of a parameter node and their handles, at once.

    `self._inputs` are the logic's `Inputs`, `self._snapping` and `self._dragging` what it knows of handles.
    """

    @staticmethod
    def stentList(parameterNode):
        """The ordered list of stents, to add, copy, remove, move and switch them."""
        return StentList(parameterNode)

    def addStent(self, parameterNode, **values):
        """Append a stent, with a handle of its own unless `handle` is given; returns the handle.

        The handle is put at the middle of the centerline. Along a curve, which is the placement where there is no centerline,
        it is a curve without points, for the user to draw.
        """
        unknown = set(values).difference(STENT_FIELDS, NEW_STENT)
        if unknown:
            raise InputError(
                f"Stent: expected values of {', '.join(STENT_FIELDS)}, got {', '.join(sorted(unknown))}."
            )
        stents = StentList(parameterNode)
        if "handle" not in values:
            if parameterNode.centerline is None:
                values.setdefault("placement", Placement.ALONG_CURVE)
            elif "diameter" not in values:  # to measure takes seconds in a large tree
                values["diameter"] = self._inputs.suggestedDiameter(parameterNode)
            values.setdefault("label", stents.freeLabel())
            isCurve = values.get("placement") == Placement.ALONG_CURVE
            centerline = None if isCurve else self._inputs.centerline(parameterNode)
            values["handle"] = Handles.newHandle(centerline, values)
        if values.get("placement", Placement.CENTER).usesHandleLength:
            values.setdefault("foreshortening", 0.0)
        stents.add(**values)
        return values["handle"]

    def addStentAt(self, parameterNode, lesion):
        """Append a stent at a lesion, as wide as the healthy vessel there; returns the handle.

        Expanded it is as long as the lesion, whose ends are where the lumen is within a tenth of the healthy one; in whole mm.
        """
        row = Row(self.landmarks(parameterNode).stent_over(lesion))
        return self.addRow(parameterNode, row)

    def addRow(self, parameterNode, row):
        """Append a stent of the library by a point, a `Row`, under a free name; returns the handle."""
        handle = self.addStent(parameterNode, **_valuesOf(row))
        handle.SetNthControlPointPositionWorld(0, *row.points[0])
        return handle

    def copyStent(self, parameterNode):
        """Append a copy of the selected stent with a handle of its own, beside it: it begins at the other one's end."""
        stents, stent = StentList(parameterNode), parameterNode.stent
        isAgain = stent.placement == Placement.AGAIN
        stents.copy(
            stent.handle if isAgain else Handles.copyHandle(stent.handle, stents.freeLabel())
        )
        self.freePlace(parameterNode)
        if parameterNode.stent.placement.needsCenterline and parameterNode.centerline is not None:
            self._moveBeside(parameterNode)

    def _moveBeside(self, parameterNode):
        """Move the selected stent along the vessel beside its place, to the side with more room."""
        tree, handle = self._inputs.centerline(parameterNode), parameterNode.stent.handle
        found = self.lying(parameterNode, tree)
        if found is None:
            return
        line, former, ways = found.axis.line, Conversion.placedPoints(handle), []
        at = line.nearest(np.array(former)).arc_lengths
        with slicer.util.NodeModify(handle):
            for end, offsets in (
                (line.points[-1], at + BESIDE),
                (line.points[0], at - line.length - BESIDE),
            ):
                points = [Handles.along(tree, end, offset) for offset in offsets]
                Handles.placeAt(handle, points)
                there = self.lying(parameterNode, tree)
                room = 0.0 if there is None else there.axis.deployed_length
                away = np.linalg.norm(np.subtract(points, former), axis=1).min()
                ways.append((min(room, away), points))
            Handles.placeAt(handle, max(ways, key=lambda way: way[0])[1])

    def removeStent(self, parameterNode):
        """Remove the selected stent, and its handle if this module made it; with the last one what was deployed, too."""
        handle = parameterNode.stent.handle
        StentList(parameterNode).remove()
        if handle not in [stent.handle for stent in parameterNode.stents]:
            Handles.removeHandle(handle)
        if not len(parameterNode.stents):
            self.removeResults(parameterNode)

    def fitHandle(self, parameterNode):
        """Give the selected stent's handle the points that its placement needs; one that dilates another again takes that one's."""
        if self.shareHandle(parameterNode):
            return
        if parameterNode.stent.placement.isOfVessel:
            self.findLandmark(parameterNode)
        stent = parameterNode.stent
        stent.foreshortening = 0.0 if stent.placement.usesHandleLength else 10.0
        if stent.handle is not None and parameterNode.centerline is not None:
            tree, length = self._inputs.centerline(parameterNode), stent.draft.length
            Handles.fitHandle(stent.handle, stent.placement, tree, length)

    def leadHandle(self, parameterNode, handle):
        """Keep a handle on the centerline while the mouse moves it; the axis of a stent along a curve is free."""
        stents = stentsOf(parameterNode)
        if any(stent.handle is handle and stent.placement.needsCenterline for stent in stents):
            self._dragging.follow(handle, self._inputs.knownCenterline(parameterNode))

    def findLandmark(self, parameterNode):
        """Set the place of a stent at a lesion, or on a branch, to the one nearest to its handle.

        Raises `InputError` where the vessel has none.
        """
        search = self._inputs.lesions(parameterNode)
        untilDone(search.portions())
        if search.landmarks is None:
            raise InputError(search.sentence)
        stent = parameterNode.stent
        points = [] if stent.handle is None else Conversion.placedPoints(stent.handle)
        point = np.mean(points, axis=0) if points else None
        found = search.landmarks.nearest(stent.draft.kind, point)
        StentList(parameterNode).change(placement=placement_document(found))

    def freePlace(self, parameterNode):
        """Place a stent at a lesion, or on a branch, by its handle instead, where that is: a hand moves it now."""
        stent = stentOf(parameterNode)
        if len(stentsOf(parameterNode)) and stent.placement.isOfVessel:
            isPlaced = not (Dependencies.missingOf(stent) or stent.draft.refusal)
            placed = self._placedKnown(parameterNode, stent) if isPlaced else None
            kind = (
                Placement.CENTER if placed is None else Placement.of(Row(placed).entry["placement"])
            )
            StentList(parameterNode).change(placement=kind)

    def _placedKnown(self, parameterNode, stent):
        """A stent as the library's, by a point, where it is known; None where it is not yet."""
        planned = Plans.plannedStent(stent)
        if not stent.placement.isOfVessel:
            return planned
        search = self.lesionSearch(parameterNode)
        if search is None or search.landmarks is None:
            return None
        try:
            return search.placed(planned)
        except InputError:
            return None  # a deployment says why

    def followLandmarks(self, parameterNode):
        """Bring handles of stents at lesions and on branches to where these lie, once the vessel is known."""
        for stent in stentsOf(parameterNode):
            if stent.draft.place is None or stent.handle is None or stent.draft.refusal:
                continue
            placed = self._placedKnown(parameterNode, stent)
            if placed is not None:
                Handles.bring(stent.handle, placed.placement.point)

    def lying(self, parameterNode, centerline):
        """The selected stent as the library's `PlacedStent`, where it will lie; None for one that cannot."""
        stent = stentOf(parameterNode)
        isThere = len(stentsOf(parameterNode)) and not Dependencies.missingOf(stent)
        if not isThere or stent.draft.refusal:
            return None
        try:
            planned = self._placedKnown(parameterNode, stent)
            return planned and lying(planned, centerline)
        except InputError:
            return None  # a deployment says why

    def knowsCenterline(self, parameterNode):
        """Whether the centerline is converted already, so that asking for it takes no time."""
        return self._inputs.knownCenterline(parameterNode) is not None

    def stentLying(self, parameterNode):
        """The stents that are `lying`; None also before the centerline is known."""
        centerline = self._inputs.knownCenterline(parameterNode)
        return None if centerline is None else self.lying(parameterNode, centerline)

    def stentEnds(self, parameterNode):
        """Ends of the selected stent, (2, 3), the proximal one first.

        None where its length is not its own to set, and before the centerline is known.
        """
        stent = stentOf(parameterNode)
        if not stent.placement.isByPoint or not stent.draft.has_free_length:
            return None
        found = self.stentLying(parameterNode)
        return None if found is None else found.axis.points[[0, -1]]

    def leadEnds(self, parameterNode, ends):
        """Keep a markups node with the ends of the selected stent on the centerline while the mouse moves one."""
        self._dragging.follow(ends, self._inputs.knownCenterline(parameterNode))

    def stretchStent(self, parameterNode, ends):
        """Let the selected stent reach from one to the other of two places (2, 3) on the centerline."""
        stent, centerline = parameterNode.stent, self._inputs.centerline(parameterNode)
        first, last = sorted(map(centerline.project, ends), key=lambda place: place.arc_length)
        line = centerline.path(first, last).line
        if line.length < SHORTEST:
            return
        length = line.length / (1 - stent.draft.foreshortening)
        kept = stent.keeps
        # The middle is that of the stent as it is packed.
        middle = {
            "center": line.length / 2,
            "proximal": length / 2,
            "distal": line.length - length / 2,
        }
        at = {Placement.DISTAL_END: line.length, Placement.PROXIMAL_END: 0.0}
        place = line.at(np.clip(at.get(stent.placement, middle[kept]), 0, line.length))
        with slicer.util.NodeModify(parameterNode):
            StentList(parameterNode).change(length=round(length, 2))
            stent.handle.SetNthControlPointPositionWorld(0, *place)

    @staticmethod
    def giveWay(parameterNode):
        """Let the mouse take the selected stent's handle where others of ours lie on it; those of stents that are off are pale."""
        stents = stentsOf(parameterNode)
        handles = [stent.handle for stent in stents]
        Handles.fade(handles, {stent.handle for stent in stents if stent.enabled})
        Handles.giveWay(stentOf(parameterNode).handle, handles)

    def moveStent(self, parameterNode, distance):
        """Move the handle of the selected stent along the centerline, in mm, toward the outlets or, negative, the root."""
        self.freePlace(parameterNode)
        stent = stentOf(parameterNode)
        if (
            stent.handle is not None
            and parameterNode.centerline
            and stent.placement.needsCenterline
        ):
            Handles.moveHandle(stent.handle, self._inputs.centerline(parameterNode), distance)

    def snapHandle(self, parameterNode, handle):
        """Move a handle's points onto the centerline; from how far, where that is far, is in `status` afterward.

        Raises `InputError` with a sentence where no stent can be, as outside of the lumen; then the handle stays where it is.
        """
        stents = [stent for stent in parameterNode.stents if stent.handle is handle]
        if stents and parameterNode.centerline is not None and not self.missing(parameterNode):
            self._snapping.snap(stents[0], self._inputs.patient(parameterNode))
            parameterNode.status = self._snapping.reported(parameterNode)

    def takePlaced(self, parameterNode, handle, index, ray):
        """Bring a point that the user has placed where it belongs: of a drawn axis to the middle of the lumen seen there.

        A click into a 3D view has the depth of what is drawn foremost, as the wall, another handle, or the stented vessel. `ray` is the
        `Ray` on which the point was seen; None in a slice view, where the point stays. It also stays where no vessel is seen, and `status` says so.
        """
        self.freePlace(parameterNode)
        if stentOf(parameterNode).placement != Placement.ALONG_CURVE:
            self.snapHandle(parameterNode, handle)
        elif ray is not None:
            vessel = self._inputs.vessel(parameterNode)
            middle = middleOn(vessel.polyData, vessel.surface, ray)
            if middle is None:
                self._snapping.leave(handle, index)
            else:
                handle.SetNthControlPointPositionWorld(index, *middle)
            parameterNode.status = self._snapping.reported(parameterNode)


def _valuesOf(row):
    """A stent of the library, but for its name."""
    values = row.entry
    del values["name"]
    return {**values, "placement": Placement.of(values["placement"])}
