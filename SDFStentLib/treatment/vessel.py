"""Vessel before treatment, with all that is found and measured in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..cautions import Caution
from ..centerline import JAGGED, Centerline, zigzag
from ..certificate import SurfaceCheck, check_surface
from ..flow import Channel, Ends, FollowedChannels, begun_branches, channels_of, end_names
from ..geometry import Line, NamedFaces, Precision, Surface
from ..lumen import DiameterProfile, diameter_profile
from ..stent import OfVessel, Stent, balloon_of, beside
from ..validation import InputError, Points
from ..vessel import (
    Lesion,
    LineSeeds,
    TreeLesions,
    VesselName,
    branch_names,
    ends_without_line,
    given_names,
    lesions_against,
    lesions_within,
    line_seeds,
    lumen_left,
    vessel_ends,
)
from .own_lines import Extraction, extract_centerline
from .places import Landmarks, placement_in
from .placing import healthy_vessel
from .preview import Preview
from .ratios import SizeRatios, stent_ratios
from .sizing import SizingWishes, Suggestion, suggested
from .straightening import axis_in_vessel
from .surroundings import PROFILE_SPACING, lumen_around
from .value import PlacedStent


@dataclass(frozen=True, eq=False)
class Vessel:
    """A wall and the centerline that belongs to it.

    Attributes
    ----------
    surface : Surface
    centerline : Centerline or None
    reference : tuple of (3,) arrays
        Healthy vessel that the user marked, mm.
    faces : NamedFaces or None
        Faces of the wall; they name the branches.
    names : tuple of VesselName
        Names of its vessels by the user; they come first.
    lines : (n, 2, 3) array or None
        Begins and ends of the lines of which the centerline was made, mm.
    """

    surface: Surface
    centerline: Centerline | None = None
    reference: tuple[Points, ...] = ()
    faces: NamedFaces | None = None
    names: tuple[VesselName, ...] = ()
    lines: Points | None = None

    @property
    def root(self) -> Points | None:
        """The proximal end of the centerline, (3,) mm."""
        tree = self.centerline
        return None if tree is None else tree.points[tree.roots[0]]

    @cached_property
    def branch_names(self) -> tuple[str, ...]:
        """The names of the centerline's branches, from that at the root on."""
        tree = self.centerline
        if tree is None:
            return ()
        return branch_names(self.surface, tree, self.faces, self.given_names)

    @cached_property
    def given_names(self) -> tuple[str | None, ...]:
        """`given_names` of its branches, none without a centerline; errors as of that."""
        tree = self.centerline
        return () if tree is None else given_names(self.surface, tree, self.names, self.faces)

    @property
    def branches(self) -> dict[int, Line]:
        """Branches of the centerline that have a length, by number from 1 at the root."""
        tree = self.centerline
        lines = [] if tree is None else [Line(tree.points[branch]) for branch in tree.branches]
        return {number: line for number, line in enumerate(lines, start=1) if line.length > 0}

    @cached_property
    def lesions(self) -> tuple[Lesion, ...] | None:
        """Found when first asked for; None without a centerline.

        The one beside a reference that the user marked is measured against that.

        Raises
        ------
        InputError
            Places of the reference that cannot be one; as of `given_names`.
        """
        tree = self.tree_lesions
        if tree is None or not self.reference:
            return None if tree is None else tree.every
        assert self.centerline is not None
        return lesions_against(tree.every, self.reference, self.with_islands, self.centerline)

    @cached_property
    def tree_lesions(self) -> TreeLesions | None:
        """`lesions` but for a reference that the user marked, measured as far as somebody asks."""
        if self.centerline is None:
            return None
        wall, faces = self.with_islands, self.faces
        extra = len(wall.triangles) - len(self.surface.triangles)
        if faces is not None and extra:
            # No end of the vessel is on an island: any part will do.
            faces = NamedFaces(np.pad(faces.ids, (0, extra), mode="edge"), faces.names)
        return TreeLesions(wall, self.centerline, faces, self.given_names)

    @cached_property
    def with_islands(self) -> Surface:
        """Wall with islands beside the centerline, which narrow the lumen, too."""
        tree = self.centerline
        return self.surface if tree is None else self.surface.with_islands(tree.points)

    @cached_property
    def lesion_cautions(self) -> tuple[Caution, ...]:
        """Cautions before one relies on its lesions: on its lines, and ends without one."""
        if self.centerline is None:
            return ()
        cautions = []
        turn = zigzag(tuple(self.branches.values()))
        if turn > JAGGED:
            cautions.append(Caution("jagged-line", {"turn_deg": turn}))
        cautions += lumen_left(self.surface, self.centerline)
        ends = vessel_ends(self.surface)
        without = ends_without_line(ends, self.centerline)
        if without:
            cautions.append(Caution("ends-without-line", {"ends": len(ends), "without": without}))
        return tuple(cautions)

    @property
    def begun(self) -> frozenset[int]:
        """`begun_branches` by its lines; none without."""
        if self.centerline is None or self.lines is None:
            return frozenset()
        return begun_branches(self.centerline, self.lines)

    @property
    def ends(self) -> Ends:
        """Names and inlets of its branches, for the flow at its ends."""
        return Ends(self.branch_names, self.given_names, self.begun)

    @cached_property
    def end_names(self) -> tuple[tuple[str, ...], ...]:
        """The `end_names` of the vessel's centerline, none without one."""
        return () if self.centerline is None else end_names(self.centerline, self.ends)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """`channels_of` it, for flow; it needs a centerline."""
        assert self.centerline is not None
        return channels_of(self.surface, self.centerline)

    @cached_property
    def followed(self) -> FollowedChannels:
        """The vessel's channels, to be followed in treated vessels; a centerline is needed."""
        assert self.centerline is not None
        return FollowedChannels(self.surface, self.centerline, self.channels)

    def seeds(self, inlet: Points | None = None, outlets: Sequence[Points] = ()) -> LineSeeds:
        """`line_seeds` of its wall, to extract a centerline."""
        return line_seeds(self.surface, inlet, outlets)

    def extracted(
        self,
        inlet: Points | None = None,
        outlets: Sequence[Points] = (),
        show: Callable[[float], None] = lambda _share: None,
    ) -> Extraction:
        """`extract_centerline` of its wall."""
        return extract_centerline(self.surface, inlet, outlets, show)

    @property
    def landmarks(self) -> Landmarks:
        """Landmarks by which places are found; `InputError` without a centerline."""
        if self.centerline is None:
            raise InputError(
                "stent placement: expected a centerline for a place at a lesion or on a branch, "
                "got none; give one."
            )
        return Landmarks(self.centerline, self.lesions or (), self.branch_names)

    def placed(self, stent: Stent) -> Stent:
        """Stent by a point, where its placement is in terms of a vessel.

        `InputError` as of `placement_in`, and without a centerline.
        """
        if not isinstance(stent.placement, OfVessel):
            return stent
        return replace(stent, placement=placement_in(stent, self.landmarks))

    def inflated(self, stent: Stent, diameter: float, recoil: float | None = None) -> Stent:
        """The stent as a balloon leaves it, in diameter and in length.

        Parameters
        ----------
        stent : Stent
            Stent with its place.
        diameter : float
            Diameter of the balloon, mm.
        recoil : float, optional
            Part of that which is lost; without, by the rule in the lumen where the stent lies with
            the usual recoil, see `balloon_by_rule`.

        Raises
        ------
        InputError
            Sizes that the device or the shape rule out; a place where it cannot lie.
        """
        balloon = balloon_of(diameter, recoil)
        if recoil is None:
            usual = replace(stent, diameter=balloon.lumen_diameter, balloon=None)
            balloon = balloon_of(diameter, None, self.native_lumen(usual))
        return replace(stent, diameter=balloon.lumen_diameter, balloon=balloon)

    def suggestion(self, number: int, wishes: SizingWishes) -> Suggestion:
        """`suggested` for one of its lesions, by number from 1."""
        assert self.lesions is not None
        assert self.centerline is not None
        lesions, tree = self.lesions, self.centerline
        return self.compared(suggested(lesions[number - 1], number, tree, wishes), lesions)

    def compared(self, proposed: Suggestion, lesions: Sequence[Lesion]) -> Suggestion:
        """A proposal with the healthy vessel, as measured where it will lie; all its lesions."""
        native = lumen_around(self.surface, proposed.axis.line, self.centerline)
        return proposed.within(healthy_vessel(native, proposed.deployed_length, lesions))

    def ratios(self, placed: PlacedStent) -> tuple[Lesion, SizeRatios] | None:
        """The tightest lesion that a stent covers, and how it compares; None for none."""
        for lesion in lesions_within(self.lesions or (), placed.axis.points):
            return lesion, stent_ratios(placed.stent, lesion)
        return None

    def place_cautions(self, stent: Stent) -> tuple[Caution, ...]:
        """Cautions on the points by which a stent is placed.

        `InputError` where it cannot lie there.
        """
        assert self.centerline is not None
        axis_in_vessel(stent, self.centerline, self.surface)
        return tuple(beside(stent.placement, self.centerline))

    @cached_property
    def preview(self) -> Preview:
        """The vessel in which plans are tried out."""
        return Preview(self.surface, self.centerline)

    def native_lumen(self, stent: Stent) -> float:
        """Smallest inscribed diameter where a stent lies, before it, mm; NaN where not known."""
        axis = axis_in_vessel(self.placed(stent), self.centerline, self.surface)
        return self.diameters(axis.line, PROFILE_SPACING).minimum

    def diameters(self, line: Line, spacing: float) -> DiameterProfile:
        """`diameter_profile` along a line through it."""
        own = self.with_islands
        if self.centerline is None:
            own = self.surface.with_islands(line.points)
        return diameter_profile(own, line, spacing)

    def check(self, precision: Precision) -> SurfaceCheck:
        """`check_surface` of its wall."""
        return check_surface(self.surface, precision=precision)
