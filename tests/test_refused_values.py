"""What cannot be a value of the library: a sentence where it is made, whoever makes it.

Sizes that the shell or a plan refuses are in test_refusals.py and test_plan.py.
"""

import contextlib
import inspect
import sys
from unicodedata import category

import numpy as np
import pytest
from deployment_cases import arc, hairpin, phantom_case
from test_devices import a_device

import SDFStentLib
from benchmarks import phantoms
from benchmarks.phantoms.axis import planar_axis
from benchmarks.phantoms.field import Rim
from benchmarks.phantoms.junction import _rim_loop
from SDFStentLib.cautions import Caution
from SDFStentLib.centerline import Centerline
from SDFStentLib.cli.console import Console, error_line
from SDFStentLib.deformation import Deployment, DeploymentSettings
from SDFStentLib.files import encode_vtp, polydata_from_arrays, surface_from_polydata
from SDFStentLib.files.polydata import polydata_from_polygons
from SDFStentLib.flow import known_flow
from SDFStentLib.geometry import Line, Precision, Surface, carried, tightest_bend
from SDFStentLib.lumen import displacements, rough_radii
from SDFStentLib.plan import Plan, plan_text
from SDFStentLib.stent import (
    AlongAxis,
    AtCenter,
    AtDistalEnd,
    AtLesion,
    Balloon,
    BetweenPoints,
    InputFile,
    LatticeDesign,
    OnBranch,
    Shape,
    Stent,
    StentEnd,
    Waist,
    stent_axis,
    stent_lattice,
    straight_way,
)
from SDFStentLib.stent.lattice import straight_lattice
from SDFStentLib.treatment import Preview
from SDFStentLib.validation import InputError, as_number, one_line

PLACE, ENDS = AtCenter([0.0, 0, 50]), BetweenPoints([0, 0, 0], [0, 0, 9])
CORNER = Line([[0.0, 0, 0], [3, 0, 0], [3, 4, 0]])
THREE, ONE_LINE, ONES = np.eye(3), [[0, 1]], [1, 1, 1]
FACES = THREE, [[0, 1, 2], [0, 2, 1]]
FORK = Centerline([[0.0, 0, 0], [0, 0, 9], [4, 0, 15], [-4, 0, 15]], [5.0] * 4, [-1, 0, 1, 1])


def a_stent(diameter=6, length=9, placement=PLACE, **more):
    return Stent(diameter, placement=placement, length=length, **more)


def a_deployment(**changes):
    case, settings = phantom_case("straight_tube"), DeploymentSettings()
    usual = {"surface": case.surface, "chain": settings.chain(case.axis), "radius": case.radius}
    return Deployment(**{**usual, **changes})


def lines(points, cells=ONE_LINE, radius=None, **more):
    return Centerline.from_lines(points, cells, radius, **more)


def a_bent_lattice(expansion):
    stent = Stent(6.0, placement=AlongAxis(arc(count=50)))
    return stent_lattice(stent, stent_axis(stent), expansion=expansion)


def settled(**changes):
    return DeploymentSettings().with_changes(**changes)


def of_cells(offsets, corners):
    """The surface of some polygons among four points."""
    polydata = polydata_from_polygons(np.zeros((4, 3)), np.array(offsets), np.array(corners, int))
    return surface_from_polydata(polydata, "vein")


def stored(points=THREE, **values):
    return Precision(**values).stored(points)


GROUPS = {
    "stents": {
        "stent diameter: .* got 'x'": lambda: a_stent("x"),
        "expected a length in mm for a placement by one": lambda: a_stent(length=None),
        "a length in mm for a placement by one": lambda: a_stent(6, None, AtLesion(1)),
        "length in mm for a placement by one": lambda: a_stent(6, None, OnBranch(1, 2.0)),
        "stent length: .* got inf": lambda: a_stent(length=np.inf),
        "distal end: expected finite": lambda: AtDistalEnd([0, 0, np.nan]),
        "stent end: expected numbers": lambda: BetweenPoints([0, 0, 0], ["a", 0, 0]),
        "stent length: .* greater than 0": lambda: a_stent(length=-1),
        r"at most 500 \(mm\), got 5000": lambda: a_stent(length=5000),
        "expected none between two points": lambda: a_stent(placement=ENDS),
        "expected one of AtCenter, .* got list": lambda: a_stent(placement=[0, 0, 0]),
        "center: expected shape": lambda: AtCenter([0, 0]),
        r"got 4 point\(s\) at one place": lambda: AlongAxis(np.ones((4, 3))),
        "stent axis: expected at least 1 points, got 0": lambda: AlongAxis([]),
        "expected a centerline": lambda: stent_axis(a_stent()),
        "axis: expected two different points": lambda: straight_way(Line(np.ones((3, 3)))),
    },
    "shapes": {
        "waist: expected a number greater than 0": lambda: Waist(0),
        "cap height: expected a number at least 0.1 and at most 1": lambda: Shape(cap_height=0),
        "got 0, 0.6, 0.4, 1": lambda: Shape(table=((0, 8.0), (0.6, 7.0), (0.4, 7.0), (1, 8.0))),
        "rows of a fraction and a diam": lambda: Shape(table=((0, 8.0, 1.0), (1, 7.0))),
        "waist position: expected a number at least 0 and at mo": lambda: Waist(6, position=1.2),
        "waist length: expected a number greater than 0": lambda: Waist(6, length=-2),
        "length of the end: expected a number greater than 0": lambda: StentEnd(9, 0),
        "expected fractions that rise from 0 to 1, each once": lambda: Shape(table=((0, 8.0),)),
        "fractions that rise": lambda: Shape(table=((0.1, 8.0), (1, 7.0))),
        "expected a table alone, got one w": lambda: Shape(Waist(6), table=((0, 8.0), (1, 7.0))),
        "profile diameter: expected": lambda: Shape(table=((0, -8.0), (1, 7.0))),
    },
    "balloons and devices": {
        "balloon diameter: expected a number greater than 0": lambda: Balloon(0, 0.1),
        "recoil: .* at least 0 and at most 0.5, got -0.1": lambda: Balloon(8, -0.1),
        "recoil: expected a number": lambda: Balloon(8, np.nan),
        "7.2 mm, the lumen that a balloon of": lambda: a_stent(8.0, balloon=Balloon(8, 0.1)),
        "diameter: expected a number greater than 0 and at most 100": lambda: Balloon(101, 0.1),
        # The balloon, though the lumen that it leaves is not.
        "balloon diameter: expected at most 22 mm, the largest": lambda: a_stent(
            19.8, None, device=a_device(), balloon=Balloon(24.75, 0.2)
        ),
        "expected one point for bench-34, which is 34 mm long, got two": lambda: a_stent(
            15.0, None, ENDS, device=a_device()
        ),
        "expected none with bench-34, whose lengths are known, got 0.1": lambda: a_stent(
            15.0, None, device=a_device(), foreshortening_fraction=0.1
        ),
        "known from 12 to 20 mm of diameter, not at 21": lambda: a_stent(
            21, None, device=a_device()
        ),
        "device: expected a Device, got 'bench-34'": lambda: a_stent(device="bench-34"),
    },
    "struts": {
        "cells: expected one of closed, open, got 'woven'": lambda: LatticeDesign(cells="woven"),
        "crowns: expected a number at least 3": lambda: LatticeDesign(crowns=2),
        "rings: expected a whole number, got 2.5": lambda: LatticeDesign(rings=2.5),
        "expected a divisor of the 8 crowns, got 3": lambda: LatticeDesign(link_every=3),
        "crimped diameter": lambda: LatticeDesign(crimped_diameter=0),
        "expansion": lambda: a_bent_lattice(1.1),
        "length: expected": lambda: straight_lattice(0, 3, LatticeDesign()),
        "length: .* got nan": lambda: straight_lattice(np.nan, 3, LatticeDesign()),
        "radius: expected": lambda: straight_lattice(10, -1, LatticeDesign()),
        "radius: .* got 0": lambda: straight_lattice(10, 0, LatticeDesign()),
        "expected finite coordinates": lambda: carried(THREE, Line([[0, 0, np.nan], [0, 0, 1]])),
        "expected two": lambda: carried([[0, 0, 0]], Line([[0, 0, 0], [0, 0, 0]])),
    },
    "lines": {
        "spacing: expected a number greater than 0": lambda: CORNER.resampled(0),
        "spacing: expected a number": lambda: CORNER.resampled(np.nan),
        "expected two different points, got 1": lambda: Line([[0, 0, 0]]).resampled(1),
        "expected two different points, got 4": lambda: Line(np.zeros((4, 3))).resampled(1),
        "count: expected at least 2 points, got 1": lambda: CORNER.resampled_to(1),
        "expected two different points": lambda: Line(np.ones((2, 3))).directions,
        "expected a start before the end": lambda: CORNER.cut(5, 5),
        "on a polyline of 7 mm, got 8 to 9 mm": lambda: CORNER.cut(8, 9),
        "a start before the end": lambda: CORNER.cut(np.nan, 2),
        "window: expected a number greater": lambda: tightest_bend(CORNER, 0).radius,
        "got NaN or infinity": lambda: Line(THREE * np.nan),
        "expected at least 1 points, got 0": lambda: Line(np.zeros((0, 3))),
    },
    "centerlines": {
        r"got 1 point\(s\) at one place": lambda: lines([[0, 0, 0]], [[0]]),
        "two different points": lambda: lines(np.ones((4, 3)), [[0, 1, 2, 3]]),
        "got 3 points and no line": lambda: lines(THREE, []),
        "3 points and no line": lambda: lines(THREE, [[]]),
        "got 0 points and no line": lambda: lines([], []),
        "indices from 0 to 2, got 0 to 3": lambda: lines(THREE, [[0, 3]]),
        "got -1 to 0": lambda: lines(THREE, [[0, -1]]),
        "line 0: expected a list of point": lambda: lines(THREE, [[0.5, 1]]),
        "NaN or infinity at 3": lambda: lines(THREE * np.nan),
        r"3 centerline points.*\(2,\)": lambda: lines(THREE, radius=[1, 2]),
        "radius: expected numbers": lambda: lines(THREE, radius=list("abc")),
        "inlet: expected shape": lambda: lines(THREE, inlet=[1, 2]),
        "at least 2 points, got 1": lambda: Centerline([[1, 2, 3]], [1], [-1]),
        "circle that holds point 2": lambda: Centerline(THREE, ONES, [1, 2, 0]),
        "expected -1 to 2, got -1 to 3": lambda: Centerline(THREE, ONES, [-1, 0, 3]),
        "expected 3 integers": lambda: Centerline(THREE, ONES, [-1, 0]),
        "got roots only": lambda: Centerline(THREE, ONES, [-1, -1, -1]),
        "point: expected finite coordinates": lambda: FORK.project([1, 2, np.nan]),
        "length: expected a number greater than 0": lambda: FORK.path_around([0, 0, 9], 0),
        "length: expected a number": lambda: FORK.path_from_distal([0, 0, 9], np.nan),
        "spacing: expected a number greater than 0": lambda: FORK.resampled(-1),
        "expected 3 integers, got int64": lambda: FORK.with_points(THREE),
    },
    "surfaces": {
        "surface points: expected at least 3 points, got 2": lambda: Surface(
            np.zeros((2, 3)), [[0, 1, 1]]
        ),
        r"surface points: expected shape \(n, 3\)": lambda: Surface(np.zeros((3, 2)), [[0, 1, 2]]),
        "surface points: expected finite": lambda: Surface(np.full((3, 3), np.nan), [[0, 1, 2]]),
        "triangles: expected point indices from 0 to 2": lambda: Surface(THREE, [[0, 1, 3]]),
        "expected at least one triangle": lambda: Surface(THREE, np.empty((0, 3), int)),
        "dtype: expected a floating type such as float32, got int32": lambda: stored(
            dtype=np.int32
        ),
        "dtype: expected a floating type": lambda: stored(dtype="nonsense"),
        "scale: expected a number greater than 0": lambda: stored(scale=0.0),
        "coordinates that fit into float32": lambda: stored(dtype=np.float32, scale=1e39),
        "the 1 points of the state before, got 3": lambda: displacements(THREE[:1], THREE),
    },
    "polydata": {
        "VTK cannot write it": lambda: encode_vtp(None),
        "point array d: expected 3 rows": lambda: polydata_from_arrays(*FACES, {"d": [0.0] * 5}),
        "cell array d: expected 2 rows": lambda: polydata_from_arrays(*FACES, None, {"d": 3.0}),
        "expected numbers or text": lambda: polydata_from_arrays(*FACES, {"d": [1j] * 3}),
        "vein: expected nothing but triangles": lambda: of_cells([0, 4], [0, 1, 2, 3]),
        "expected at least one triangle": lambda: of_cells([0], []),
        "expected point indices from 0 to 3": lambda: of_cells([0, 3], [0, 1, 7]),
        "cells do not fit together": lambda: of_cells([0, 3, 2, 3], [0, 1, 2]),
    },
    "deployments": {
        "stent radius: expected a number greater than 0 .mm., got 0": lambda: a_deployment(
            radius=0
        ),
        "stent radius: expected a number": lambda: a_deployment(radius=float("nan")),
        "a CapsuleChain, got .ndarray.; .* CapsuleChain.along": lambda: a_deployment(
            chain=hairpin()
        ),
        "expected a Surface, got .ndarray.; .* by Surface.points": lambda: a_deployment(
            surface=THREE
        ),
        "rule: expected one of events, published, got 'fast'": lambda: settled(rule="fast"),
        "expected one of axis, paper, none, got 'k/4'": lambda: settled(calibration="k/4"),
        "falloff: expected one of compact, wendland, cosine": lambda: settled(falloff="gauss"),
        "blend: expected a function of an array that falls from 1": lambda: settled(
            blend=lambda x: x
        ),
        "settings: expected one of .*, got 'radius_step'": lambda: settled(radius_step=0.1),
        "width: expected 0 or at least 0.001 .* 1e-300": lambda: settled(smoothing_width=1e-300),
        "capsule_length: expected a number at least 0.05": lambda: settled(capsule_length=10**400),
    },
    "previews": {
        "at least 2 points, got 1": lambda: rough_radii(THREE, THREE[:1], THREE),
        "points of the wall": lambda: rough_radii(np.empty((0, 3)), THREE[:2], np.empty((0, 3))),
        "at least one stent": lambda: Preview(Surface(*FACES)).of([]),
    },
    "plans": {
        "stent 1 of the plan: expected a Stent, got str": lambda: Plan(stents=("x",)),
        "frame: expected RAS, LPS or none": lambda: Plan(frame="XYZ"),
        "input file: expected a path, got 3": lambda: InputFile(3),
        "settings.falloff: expected a name, got a function": lambda: plan_text(
            Plan(settings=settled(falloff=lambda x: 1 - x))
        ),
        "stent name: expected a text": lambda: plan_text(Plan((a_stent(name="\udcff"),))),
    },
    "flows": {
        "that of the inlet alone": lambda: known_flow(40.0, inlet=10.0),
        "that of the wedge alone": lambda: known_flow(40.0, wedge=10.0),
        "contradict each other": lambda: known_flow(40.0, inlet=9.0, wedge=10.0),
        "inlet pressure": lambda: known_flow(40.0, inlet=float("nan"), wedge=10.0),
        "peak flow": lambda: known_flow(40.0, peak=30.0),
        "below 1": lambda: known_flow(40.0, split_right=1.0),
        "split to the right": lambda: known_flow(40.0, split_right=80.0),
    },
    "phantoms": {
        "radius: expected a number greater than 0": lambda: phantoms.straight_tube(radius=0),
        "length: expected a number greater than 0": lambda: phantoms.straight_tube(length=-1),
        "edge_length: expected .* at most 3": lambda: phantoms.straight_tube(edge_length=4),
        "edge_length: .* got nan": lambda: phantoms.straight_tube(edge_length=np.nan),
        "throat_radius: .* at most 3": lambda: phantoms.stenosed_tube(throat_radius=4),
        "length: expected a number at least 16": lambda: phantoms.stenosed_tube(length=10),
        "bend_radius: .* greater than 3.6": lambda: phantoms.bent_tube(bend_radius=3),
        "angle_deg: .* at most 180": lambda: phantoms.bent_tube(angle_deg=200),
        "pitch: turns 5 mm apart touch .* more than 5.3": lambda: phantoms.helix_tube(pitch=5),
        "turns: expected a number greater than 0": lambda: phantoms.helix_tube(turns=0),
        "coil_radius: .* greater than 3": lambda: phantoms.helix_tube(coil_radius=2),
        "gap: expected a number greater than 0": lambda: phantoms.hairpin_tube(gap=0),
        "bend_radius: .* at least 4": lambda: phantoms.hairpin_tube(bend_radius=1),
        "arch_radius: .* than 8.4": lambda: phantoms.arch_with_coarctation(arch_radius=5),
        "descending_length: ": lambda: phantoms.arch_with_coarctation(descending_length=5),
        "edge_length: .* at most 1.2": lambda: phantoms.branching_pulmonary_artery(1.5),
        "toward: expected a direction that d": lambda: planar_axis([(9, 0)], toward=(0, 0, 2)),
        "length: .* at least 16": lambda: phantoms.tube_with_neighbor(length=5),
        "edge_length: .* at most 1.8": lambda: phantoms.tube_with_neighbor(edge_length=2),
        "edge_length: expected rims that are one loop each": lambda: _rim_loop(
            np.zeros((7, 3)), 2 * np.arange(3)[:, None] + range(3), Rim(np.zeros(3), THREE[2], 1.0)
        ),
        "outlets: expected": lambda: phantoms.vascular_tree(0),
        "edge_length: expected": lambda: phantoms.vascular_tree(8, 3.0),
        "number of the branch: expected": lambda: phantoms.vascular_tree(8, 0.8, {15: 0.5}),
        "share of the diameter: expected": lambda: phantoms.vascular_tree(8, 0.8, {1: 1.5}),
    },
}
"""Words of the sentence, and what it is said of."""

REFUSED = [(words, make) for group in GROUPS.values() for words, make in group.items()]


@pytest.mark.parametrize(("words", "make"), REFUSED, ids=[words for words, _ in REFUSED])
def test_what_cannot_be_is_a_sentence(words, make):
    with pytest.raises(InputError, match=words):
        make()


# Every public function with something that it does not take: a sentence, not a Python error.

WRONG = [
    None, "8", b"x", 3, 3.5, float("nan"), [], {}, object(), np.zeros((2, 2)), [None], 1e400, -1,
    True, "\ud800", np.array(["a"]),
]  # fmt: skip


def public_callables():
    for name in SDFStentLib.__all__:
        value = getattr(SDFStentLib, name)
        is_error = inspect.isclass(value) and issubclass(value, BaseException)
        if callable(value) and not is_error and value is not Stent:
            yield name


@pytest.mark.parametrize("name", list(public_callables()))
def test_a_wrong_argument_is_said_in_a_sentence(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function = getattr(SDFStentLib, name)
    needed = [
        parameter
        for parameter in inspect.signature(function).parameters.values()
        if parameter.default is parameter.empty and parameter.kind.name.startswith("POSITIONAL")
    ]
    for value in WRONG:
        with contextlib.suppress(InputError):
            function(*[value] * len(needed))


@pytest.mark.parametrize("kind", ["Cc", "Zl", "Zp", "Cs"])
def test_no_character_that_controls_or_is_half_of_one_is_left(kind):
    """The classes of Unicode; of its formats (Cf) those that turn the direction of writing."""
    every = "".join(c for c in map(chr, range(sys.maxunicode + 1)) if category(c) == kind)
    left = one_line(every + "\N{RIGHT-TO-LEFT MARK}\N{ARABIC LETTER MARK}\N{LEFT-TO-RIGHT MARK}")
    assert left.isprintable()
    assert left.isascii()


def test_what_the_shell_says_of_a_name_is_one_printable_line(capsys):
    name = "a\nb\x1b[2J\u202e\ud800"
    console = Console()
    console.say(name)
    console.warn([Caution("switched-off", label=f"{name}: ")])
    error_line(name)
    said = capsys.readouterr()
    lines = [*said.out.splitlines(), *said.err.splitlines()]
    assert len(lines) == 3
    assert all(line.isprintable() for line in lines)


# Checks at the door, where values of Python itself are extreme.


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (
            10**400,
            r"got 1000000000000000000000000000000000000000\.\.\. \(401 characters\); choose such",
        ),
        (
            -(10**400),
            r"got -100000000000000000000000000000000000000\.\.\. \(402 characters\); choose such",
        ),
        (10**5000, "got (a number of thousands of digits|1000)"),  # older Pythons write it
        ("x" * 1000, r"got 'x+\.\.\. \(1002 characters\); choose such"),
    ],
    ids=["large", "negative", "huge", "text"],
)
def test_a_number_that_no_float_can_hold_is_refused_in_a_short_sentence(value, said):
    with pytest.raises(InputError, match=rf"^size: expected a number \(mm\), {said}") as caught:
        as_number(value, "size", unit="mm")
    assert len(str(caught.value)) < 120
