"""The way from the voxels of a label to a vessel: surface, ends, centerline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import dist

import numpy as np

from ..cautions import Caution
from ..centerline import ExtractedLines
from ..certificate import check_surface
from ..geometry import NamedFaces, Surface
from ..treatment import extract_centerline
from ..validation import DeploymentError, Floats, Points, as_place
from .contour import LargestPart, contoured, largest_part
from .cut_lines import lines_between
from .ends import Border, RoundEnd, flat_ends, round_ends_of
from .labelmap import AROUND, Labelmap, LabelPiece, largest_piece, thin_bridges
from .wall_distance import wall_distance

PIECE, WALL, LINES = 0.05, 0.4, 0.9
"""Share of the time that has passed once the label, its wall and its lines are there: of a fork in
voxels of a tenth of its diameter."""

VOXEL_ERROR = 0.2
"""Mean error of an inscribed diameter, in voxels, as `python -m benchmarks.voxels` measures it,
rounded up."""


@dataclass(frozen=True)
class PreparedEnd:
    """An end of a prepared vessel.

    Attributes
    ----------
    name : str
        Name of its face.
    number : int
        Number of its face.
    center : (3,) array
        LPS, mm.
    diameter : float
        Diameter of the circle with its area, mm.
    is_at_border : bool
        Whether the image ends there.
    """

    name: str
    number: int
    center: Points
    diameter: float
    is_at_border: bool


@dataclass(frozen=True, eq=False)
class PreparedVessel:
    """A vessel from a segmentation; points in LPS, mm.

    Attributes
    ----------
    surface : Surface
        Closed, wound outward.
    faces : NamedFaces
        `inlet`, the outlets and `wall`.
    lines : ExtractedLines
        Centerlines from the inlet to every outlet.
    ends : tuple of PreparedEnd
        The inlet first.
    voxels : (3,) array
        Their spacing, mm.
    warnings : tuple of Caution
    """

    surface: Surface
    faces: NamedFaces
    lines: ExtractedLines
    ends: tuple[PreparedEnd, ...]
    voxels: Floats
    warnings: tuple[Caution, ...]

    @property
    def voxel(self) -> float:
        """The side of a cube as large as a voxel, mm."""
        return float(np.prod(self.voxels) ** (1 / 3))

    @property
    def diameter_error(self) -> float:
        """Mean error of its diameters that voxels of this size make, mm."""
        return VOXEL_ERROR * self.voxel


def prepared_vessel(
    labelmap: Labelmap,
    inlet: Points | None = None,
    show: Callable[[float], None] = lambda _share: None,
) -> PreparedVessel:
    """Surface, ends and centerline of the vessel that a label shows.

    Parameters
    ----------
    labelmap : Labelmap
    inlet : (3,) array, optional
        Names the proximal end, LPS, mm; the widest by default.
    show : callable, optional
        Hears of the share that is done, again and again.

    Raises
    ------
    InputError
        A label without two ends, or whose ends no plane cuts.
    DeploymentError
        No sound surface, or no centerline.
    """
    piece = largest_piece(labelmap)
    part = piece.labelmap
    show(PIECE)
    wall_parts = _surface(piece)
    rough = wall_parts.surface
    show(WALL)
    found = extract_centerline(rough, show=lambda done: show(WALL + done * (LINES - WALL)))
    show(LINES)
    tree = found.centerline
    ends = round_ends_of(tree, _borders(piece))
    start = None if inlet is None else _in_axes(part, inlet)
    made = flat_ends(rough, tree, ends, start)
    segment = made.segment
    wall = _in_patient(part, segment.surface)
    if not made.is_sound:
        raise _unsound(wall)
    caps = [face for face in segment.faces if face.kind != "wall"]
    middles = np.array([face.center for face in caps])
    points, each, radii = lines_between(tree, ends, made.planes, middles)
    flat = [
        PreparedEnd(
            face.name,
            face.number,
            part.in_patient(face.center[None])[0],
            2 * float(np.sqrt(face.area / np.pi)),
            _is_at_border(face.center, _borders(piece)),
        )
        for face in caps
    ]
    dead = [end for end, plane in zip(ends, made.planes, strict=True) if plane is None]
    of_label = _of_label(piece, flat)
    return PreparedVessel(
        wall,
        segment.named_faces,
        ExtractedLines(part.in_patient(points), each, radii),
        tuple(flat),
        labelmap.spacing,
        (
            *of_label,
            *_not_told(of_label, _moved(part, (*_of_parts(wall_parts), *found.warnings))),
            *_of_ends(part, dead),
        ),
    )


def _surface(piece: LabelPiece) -> LargestPart:
    """The wall of a label, its ends round, and beyond the image where that cuts it."""
    roomy = _with_room(piece)
    field = wall_distance(roomy)
    for axis in range(3):
        for side in (0, -1):
            at = [slice(None)] * 3
            at[axis] = slice(side, None if side else 1)
            field[tuple(at)] = np.maximum(field[tuple(at)], roomy.voxel)
    made = contoured(field, roomy.spacing)
    return largest_part(made.with_points(made.points - AROUND * roomy.spacing))


def _with_room(piece: LabelPiece) -> Labelmap:
    """The label with empty voxels round it; where the image cuts it, it goes on straight.

    Hollows in its last slice there do not: they would be tunnels round the plane of that end.
    """
    from scipy.ndimage import binary_fill_holes

    part = piece.labelmap
    mask = np.pad(part.mask, AROUND)
    for axis, (first, last) in enumerate(piece.is_cut):
        along = np.moveaxis(mask, axis, 0)
        if first:
            along[: AROUND + 1] = binary_fill_holes(along[AROUND])
        if last:
            along[-AROUND - 1 :] = binary_fill_holes(along[-AROUND - 1])
    origin = part.in_patient(-AROUND * part.spacing[None])[0]
    return Labelmap(mask, part.spacing, origin, part.directions)


def _borders(piece: LabelPiece) -> list[Border]:
    part, found = piece.labelmap, []
    for axis, (first, last) in enumerate(piece.is_cut):
        side = float(part.spacing[axis])
        if first:
            found.append(Border(axis, -0.5 * side, 1.0))
        if last:
            found.append(Border(axis, (part.mask.shape[axis] - 0.5) * side, -1.0))
    return found


def _is_at_border(center: Points, borders: Sequence[Border]) -> bool:
    return any(abs(one.beyond(center)) < 1e-6 for one in borders)


def _in_axes(part: Labelmap, place: Points) -> Points:
    return np.asarray((np.asarray(place, dtype=float) - part.origin) @ part.directions)


def _in_patient(part: Labelmap, surface: Surface) -> Surface:
    """A surface in the patient; axes that are a left hand turn its triangles."""
    turned = np.linalg.det(part.directions) < 0
    triangles = surface.triangles[:, ::-1] if turned else surface.triangles
    return Surface(part.in_patient(surface.points), triangles)


def _unsound(wall: Surface) -> DeploymentError:
    """The refusal of a surface in the patient, where its fault has a place."""
    return DeploymentError(
        f"segmentation: expected a sound surface, {check_surface(wall).sentence()} Smooth the "
        "segment, or fill what is thin, in Slicer by Segment Editor."
    )


def _of_label(piece: LabelPiece, ends: Sequence[PreparedEnd]) -> list[Caution]:
    found = []
    if piece.left_out:
        numbers = {"count": piece.left_out, "volume_mm3": piece.left_volume}
        found.append(Caution("label-bits", numbers))
    bridges = thin_bridges(piece.labelmap)
    found += [Caution("thin-bridge", {}, as_place(place)) for place in bridges]
    names = [end.name for end in ends if end.is_at_border]
    if names:
        found.append(Caution("image-ends", {"names": ", ".join(names)}))
    return found


def _of_parts(wall: LargestPart) -> list[Caution]:
    if wall.left_out is None:
        return []
    numbers = {"volume_mm3": wall.left_volume}
    return [Caution("thin-parts", numbers, as_place(wall.left_out))]


def _of_ends(part: Labelmap, dead: Sequence[RoundEnd]) -> list[Caution]:
    places = [part.in_patient(end.line.points[:1])[0] for end in dead]
    return [Caution("dead-end", {}, as_place(place)) for place in places]


def _not_told(known: Sequence[Caution], cautions: Sequence[Caution]) -> list[Caution]:
    """Cautions without those on openings in which there is a thin bridge that is known."""
    bridges = [one.place for one in known if one.kind == "thin-bridge" and one.place]
    return [
        one
        for one in cautions
        if one.kind != "vessels-touch"
        or not one.place
        or all(dist(one.place, at) > float(one.numbers["opening_mm"]) for at in bridges)
    ]


def _moved(part: Labelmap, cautions: Sequence[Caution]) -> list[Caution]:
    """Cautions with their places in the patient."""
    return [
        one
        if one.place is None
        else replace(one, place=as_place(part.in_patient(np.array([one.place]))[0]))
        for one in cautions
    ]
