"""Cautions that a user needs before relying on a result: a kind, numbers, and a place.

Code asks for kind and numbers; the sentence is made at the end, from the one template of its kind.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from .units import in_file
from .validation import Place, PlainNumbers

_AT = "({x:.4g}, {y:.4g}, {z:.4g}) mm{filed}"
_BESIDE = f"lies {{distance_mm:.1f}} mm beside the centerline; its nearest place, {_AT}, was taken."

TEMPLATES = {
    "ends-apart": f"Parts that hang free: {{count}}, one at {_AT}. No line leads there.",
    "limbs-meet": f"Limbs that meet again: {{count}}, one near {_AT}; part vessels that touch.",
    "open-wall": f"A hole of {{diameter_mm:.1f}} mm, at {_AT}: name it where it is an end.",
    "vessels-touch": (
        f"Two vessels may be one at {_AT}, by an opening {{opening_mm:.1f}} mm wide: lines lead "
        "through it; where they only touch, part them there."
    ),
    "inlet-narrow": (
        f"The inlet is {{inlet_mm:.1f}} mm wide, the lumen {{diameter_mm:.1f}} at {_AT}; if that "
        "is where the vessel begins, cut it flat there, or name its tip as the inlet."
    ),
    # Files
    "polygons-cut": (
        "{polygons} polygons or strips were cut into triangles, {triangles} triangles now."
    ),
    "slivers": (
        "Triangles with an angle below 1 degree: {triangles}, the worst {angle_deg:.2g} degrees "
        "near ({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}. No fault, but a mesher may refuse them."
    ),
    "cells-dropped": "{cells} vertices and lines among the cells were dropped.",
    "integer-coordinates": "its coordinates are integers; they are written as doubles.",
    "degenerate-triangles": "{triangles} triangles are degenerate (no height).",
    "contents-not-kept": "not kept of the {format} file: {contents}.",
    "first-of-steps": (
        "it holds {steps} steps of time; the first, at {time}, is read. For another one, save that "
        "as a file of its own."
    ),
    "unusual-extent": (
        "read in {unit}, it is {extent_mm:.3g} mm long, unusual for a vessel; name the unit of the "
        "file{units} if it is another."
    ),
    "unusual-size": (
        "read in {unit}, it is {extent_mm:.3g} mm long and about {lumen_mm:.3g} mm wide, unusual "
        "for a vessel; name the unit of the file{units} if it is another."
    ),
    "unit-in-file": "it names {unit}, the unit of the screen; its positions were read in {wanted}.",
    "frame-turned": "it is in {frame}, the surface in {wanted}; its x and y were negated.",
    "partly-outside": "{outside_percent:.0f} % of its points lie outside of {surface}.",
    "points-joined": (
        "{points} of its points lie on others without being shared, as where parts were appended "
        "or normals split: they count as one with those, and are written as they were. A mesher "
        "sees open seams there: merge them first (Slicer: Surface Toolbox, Clean; ParaView: Clean "
        "to Grid; MeshLab: Merge Close Vertices)."
    ),
    "ghost-cells": "{cells} ghost or hidden cells are left out, and are written as they were.",
    "outer-wall": (
        "It has a wall of two sides: the lumen is measured and treated; the outer side, of "
        "{triangles} triangles, goes along with it at its distance."
    ),
    "islands": (
        "Closed parts float in the lumen: {islands}, the largest {extent_mm:.1f} mm long at "
        "({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}. They narrow the lumen and take their share of its "
        "area, but not where the centerline runs through them; a stent does not touch them, and "
        "the lumen that it leaves is told without them. Where they are no calcium or thrombus, "
        "remove them (Slicer: Segment Editor, Islands)."
    ),
    "triangles-again": (
        "{triangles} triangles lie on others a second time, or are collapsed between these: they "
        "are no wall, and are written as they were. A mesher refuses them: remove them first "
        "(MeshLab: Remove Duplicate Faces)."
    ),
    "face-names-not-read": "names of faces are not read: {reason}",
    "arrays-not-kept": "{format} cannot keep the arrays {arrays}; write .vtp to keep them.",
    "line-arrays-not-kept": "arrays are not kept in .mrk.json; write .vtp.",
    "ends-without-line": (
        "To {without} of the {ends} ends of the surface no line of the centerline leads: lesions "
        "there are not known, and beside others the healthy vessel may be a parent, or missing; "
        "give a centerline from the inlet to all ends."
    ),
    "begins-at-wall": f"A line ends at the wall, at {_AT}; {{length_mm:.1f}} mm were moved inward.",
    "begin-at-wall": f"{{count}} lines end at the wall, one at {_AT}; all were moved inward.",
    "loop": f"Lines that part meet again, a loop, at {_AT}: read as a tree that ends there.",
    "line-leaves-lumen": f"A line leaves the lumen for {{length_mm:.1f}} mm, at {_AT}; mend it.",
    "jagged-line": (
        "The centerline goes to and fro from point to point, by {turn_deg:.0f} degrees and more: "
        "it is longer than the vessel. Lengths along it, the places and degrees of lesions and the "
        "length of a stent cannot be relied on; give a smooth one."
    ),
    # Segments
    "label-bits": "{count} loose parts of the label, {volume_mm3:.3g} mm3, were left out.",
    "thin-parts": f"{{volume_mm3:.3g}} mm3 beyond {_AT} were left out: widen the label there.",
    "thin-bridge": (
        f"The label is but two voxels wide at {_AT}, between wider parts: part vessels that touch."
    ),
    "image-ends": "The image cuts the vessel at {names}; these ends lie along its border.",
    "end-moved": (
        "The {end} of the segment was moved {distance_mm:.1f} mm into it, to ({x:.4g}, {y:.4g}, "
        "{z:.4g}) mm{filed}: farther out no plane meets only this vessel."
    ),
    "dead-end": (
        "The branch that ends at ({x:.4g}, {y:.4g}, {z:.4g}) mm{filed} has no outlet, its end is "
        "round; cut it flat, or close the branches."
    ),
    "open-branch": f"{{name}}, which leaves at {_AT}, stays open: no plane cuts off it alone.",
    "branch-without-line": (
        "The branch that ends at ({x:.4g}, {y:.4g}, {z:.4g}) mm{filed}, face {name}, stays open: "
        "no line of the centerline leads there; give a centerline with all branches."
    ),
    "hole": (
        f"The wall is open at {_AT}, {{diameter_mm:.1f}} mm wide, where no centerline ends: closed "
        "as wall, face {name}; where it is an outlet, give a centerline that ends there."
    ),
    "no-room-for-tube": (
        "{name} lies {distance_mm:.1f} mm nearer to the stent than it should, and there is no room "
        f"for a tube behind it at {_AT}: pressures there are told with doubt."
    ),
    # Plans
    "changed-input": "it is not the file the plan was made with; accepted as asked.",
    "other-version": (
        "The plan was made by sdfstent {version}, this is {current}: the result may differ."
    ),
    # The axis of a stent, or of a part that is measured
    "shortened": (
        "The {thing} is shortened: {prescribed_mm:.1f} mm were prescribed, {available_mm:.1f} mm "
        "of centerline are available there."
    ),
    "branch-chosen": (
        "At the junction near ({x:.4g}, {y:.4g}, {z:.4g}) mm{filed} the {thing} follows the {rule} "
        "branch; place it between two points{to} to choose another one."
    ),
    "point-beside": "The {point} " + _BESIDE,
    "end-beside": "The {thing} {end} " + _BESIDE,
    "tight-bend": (
        "The axis has a bend tighter than the stent's radius at ({x:.1f}, {y:.1f}, {z:.1f}) mm"
        "{filed}: {bend_radius_mm:.1f} mm against {stent_radius_mm:.1f} mm; the inner side folds, "
        "choose another place or straighten the axis{straighten}."
    ),
    "smoothed-less": (
        "The axis is smoothed by {fraction:.2f} of the way: farther on it comes too near to the "
        "wall at ({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}."
    ),
    "straightened-less": (
        "The axis is straightened by {fraction:.2f} instead of {prescribed_fraction:g}: farther on "
        "it comes too near to the wall, or to an end of the vessel, at "
        "({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}; a shorter stent can be straightened more."
    ),
    "device-range": (
        "{device}: a {what} of {value_mm:g} mm is outside of the {low_mm:g} to {high_mm:g} mm "
        "{known_as}."
    ),
    "device-shortening": (
        "{device}: its shortening is known at its nominal diameters only; {diameter_mm:g} mm "
        "{is_it}, and its length extrapolated."
    ),
    "ratio-adjacent": (
        "The stent is {ratio:.2f} times as wide as the healthy vessel {where} ({healthy_mm:.1f} "
        "mm); the least that its source had were 0.44 of the distal pulmonary artery and 0.38 of "
        "the descending aorta (Heart 2003;89:905)."
    ),
    "ratio-stenosis": (
        "The balloon is {ratio:.2f} times as wide as the stenosis of {stenosis_mm:.2f} mm; above "
        "{high:g} the recoil was more than 10 %."
    ),
    "tapering-lesion": (
        "A lumen of {lumen_mm:.2f} mm leaves a stenosis of {percent:.0f} %: the healthy vessel is "
        "{reference_mm:.2f} mm wide there, and {narrowest_mm:.2f} mm where it is narrowest beside "
        "the lesion; a tapered stent leaves less."
    ),
    "lesion-uncovered": (
        "Lesion {lesion} is not wholly covered: {uncovered_mm:.1f} of its {lesion_mm:.1f} mm lie "
        "beyond the ends of the stent, which is {deployed_mm:.1f} mm long{packed}; choose a longer "
        "one, or another place."
    ),
    # A stent in the vessel
    "switched-off": "it is switched off and was not deployed.",
    "outside-without-effect": (
        "Nothing moves: the stent of {stent_diameter_mm:g} mm touches no wall, and its axis lies "
        "outside the lumen; check that surface and axis are in the same unit and frame."
    ),
    "without-effect": (
        "Nothing moves: the stent of {stent_diameter_mm:g} mm is not wider than the lumen where it "
        "lies{as_left} ({minimum_mm:.1f} to {maximum_mm:.1f} mm)."
    ),
    "overdilated": (
        "The stent of {stent_diameter_mm:.3g} mm is {times:.2f} times as wide as the healthy "
        "vessel {where} ({healthy_mm:.1f} mm). In coarctations its source had at most 1.02, and "
        "1.2 dilated again, of the descending aorta; in pulmonary arteries 1.5, and 1.88, of the "
        "distal artery, and a vessel that ruptured distal to its stent (Heart 2003;89:905)."
    ),
    "hangs-free": (
        "The stent hangs free over {free_mm:.1f} of its {length_mm:.1f} mm, off the wall all round "
        "or nearly: it may slip or embolize; choose a wider one, or another place (no source says "
        "from which part on, a third is told)."
    ),
    "coarse-mesh": (
        "The mesh is coarse for the stent: half of its edges there are longer than {edge_mm:.2g} "
        "mm, the stent's radius is {stent_radius_mm:g} mm, and facets between their ends may miss "
        "the prescribed lumen by more than 3 %; refine the surface near the stent to edges of at "
        "most {fine_mm:.2g} mm."
    ),
    "too-coarse": (
        "The mesh is too coarse for the stent near ({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}: "
        "triangles with sides of {start_mm:.3g} mm, {edge_mm:.3g} mm once it is expanded, leave a "
        "lumen of {found_mm:.2f} instead of {prescribed_mm:.2f} mm; refine the surface there to "
        "edges of at most {fine_mm:.2g} mm."
    ),
    "narrowed": (
        "Later stents push tissue into it: its lumen is {minimum_mm:.1f} mm at the narrowest, "
        "{earlier_minimum_mm:.1f} mm before them; deploy it after them, or once more."
    ),
    "facets-inside": (
        "Facets lie inside the prescribed lumen near ({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}, by up "
        "to {depth_mm:.2g} mm: pushed out they would fold; smaller triangles there may help."
    ),
    "overlap": (
        "Stents {first} and {second} overlap over {length_mm:.1f} mm of the second one's length; "
        "there the wider one determines the lumen."
    ),
    "neighbor-narrowed": (
        "The lumen of {name} is narrowed from {before_mm:.2f} to {after_mm:.2f} mm ({diameter} "
        "diameter, {percent:.0f} %), {distance_mm:.0f} mm beyond {start}."
    ),
    "new-slivers": (
        "Triangles that became slivers, with an angle below 1 degree and at most half of what it "
        "was: {triangles}, the worst from {before_deg:.2g} to {angle_deg:.2g} degrees near "
        "({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}. No fault, but a mesher may refuse or refine them."
    ),
    "narrower": (
        "The lumen is up to {percent:.1f} % narrower than prescribed, near "
        "({x:.1f}, {y:.1f}, {z:.1f}) mm{filed}: {found_mm:.2f} instead of {prescribed_mm:.2f} mm; "
        "smaller triangles there may help."
    ),
    "cap-bulged": (
        "The flat cap near ({x:.1f}, {y:.1f}, {z:.1f}) mm{filed} is pushed up to {height_mm:.2f} "
        "mm out of its plane by the stent; end the stent farther from it, or extend the vessel, "
        "when a boundary condition belongs there."
    ),
    # Measuring
    "no-inscribed-diameter": (
        "No inscribed diameter at {missing} of {stations} stations ({ranges_mm} mm along the "
        "axis): the axis is outside the lumen there, or at an end that is no flat cap across."
    ),
    "no-equivalent-diameter": (
        "No equivalent diameter at {missing} of {stations} stations ({ranges_mm} mm along the "
        "axis): no closed cross-section lies round the axis there, or a cap cuts it off."
    ),
    # Flow
    "wave-not-repeated": (
        "The last of {rows} rows does not repeat the first one: the wave was taken for a cycle of "
        "as many steps, {cycle_s:.4g} s; tell its length{cycle} if that is another."
    ),
    "wave-beats": "{beats} beats of {cycle_s:.4g} s are alike; their average was taken.",
    "wave-unlike-beats": (
        "{beats} beats of {cycle_s:.4g} s are not alike; their average was taken, whose peak is "
        "{peak:.3g} of {most:.3g} mL/s: correct the length{cycle} where they are of another one."
    ),
    "picture-missing": "{reason}",
    "cut-off": (
        "A run that was to write {names} here has not ended: it is still writing, or was cut off, "
        "and files here may be of different runs; carry it out again."
    ),
    "of-another-run": (
        "{name} is not the one that was written with {report}: a run was cut off, or one of them "
        "was changed since; carry the plan out again."
    ),
}
"""Sentences by kind: with numbers, `x`, `y`, `z` of a place, the `thing` placed, and remedies."""

GRAVEST = (
    "unusual-size", "unusual-extent", "unit-in-file", "partly-outside", "jagged-line",
    "changed-input", "outside-without-effect", "hangs-free", "overdilated", "without-effect",
    "too-coarse", "facets-inside", "lesion-uncovered", "shortened", "narrower", "narrowed",
    "neighbor-narrowed", "tight-bend", "cap-bulged", "new-slivers", "inlet-narrow",
)  # fmt: skip
"""Kinds by gravity, for a choice of cautions; others follow as they came."""

NO_REMEDIES = {"to": "", "straighten": "", "units": "", "cycle": ""}


@dataclass(frozen=True)
class Caution:
    """Something to know before one relies on the numbers.

    Attributes
    ----------
    kind : str
        Kind, one of `TEMPLATES`, never renamed.
    numbers : mapping
        Numbers by name, the unit at its end (`..._mm`).
    place : (x, y, z), optional
        Place of the cause, mm.
    stent : int, optional
        Number of the stent in the plan, from 1.
    label : str
        Subject in front of the sentence: a file, a stent, before or after.
    """

    kind: str
    numbers: Mapping[str, float | str] = field(default_factory=dict)
    place: Place | None = None
    stent: int | None = None
    label: str = ""

    def __post_init__(self) -> None:
        self.sentence()  # a kind without template, or a number without name, is found at once

    def labeled(self, label: str) -> Caution:
        """The same with a label in front of its own."""
        return replace(self, label=label + self.label)

    def sentence(
        self,
        thing: str = "stent",
        remedies: Mapping[str, str] | None = None,
        units: str = "mm",
    ) -> str:
        """The sentence for the user.

        Parameters
        ----------
        thing : str
            Thing that was placed: a stent, or a part that is measured.
        remedies : mapping, optional
            Ways of the reader to follow the advice, by name, such as options of the command.
        units : {"mm", "cm", "m"}
            Unit of the surface's file: places are given in it, too.
        """
        x, y, z = self.place or (None, None, None)
        words = {**NO_REMEDIES, **(remedies or {}), "thing": thing, "x": x, "y": y, "z": z}
        words["filed"] = in_file(self.place, units)
        return self.label + PlainNumbers().vformat(
            TEMPLATES[self.kind], (), {**words, **self.numbers}
        )

    __str__ = sentence


def by_gravity(cautions: Iterable[Caution]) -> list[Caution]:
    """The same, the gravest first."""
    order = {kind: place for place, kind in enumerate(GRAVEST)}
    return sorted(cautions, key=lambda caution: order.get(caution.kind, len(order)))
