"""The options of every command."""

from __future__ import annotations

import argparse

from ..version import VERSION
from .app_options import add_app
from .argument_types import number as _number
from .argument_types import path as _path
from .argument_types import whole as _whole
from .common_options import (
    add_json,
    add_point,
    add_points,
    add_surface,
    add_talk,
    add_units,
    add_vessel_marks,
)
from .method_options import add_method
from .parser import Parser, ShortHelp
from .plan_options import add_acceptance, add_comparison, add_device_file
from .stent_options import add_device_table, add_length, add_shape, add_size, add_stent, add_wishes
from .sweep_options import add_sweep


def parser() -> Parser:
    """The parser of the whole command line."""
    top = Parser(
        prog="sdfstent",
        description="Virtual stenting of vessel surfaces. Sizes in mm; points in the unit and "
        "frame of the files. Research use only, not a medical device.",
        epilog="Exit codes: 0 done and certified; 1 unexpected error; 2 bad input, nothing "
        "written; 3 done, but the certificate fails; 130 interrupted, nothing written.",
        allow_abbrev=False,
    )
    top.add_argument("--version", action="version", version=f"sdfstent {VERSION}")
    commands = top.add_subparsers(
        dest="command", metavar="COMMAND", required=True, parser_class=Parser
    )
    first = _first_of_deploy()
    _deploy(
        commands.add_parser(
            "deploy", help="deploy one stent", allow_abbrev=False, add_help=False, parents=[first]
        ),
        first,
    )
    _run(commands.add_parser("run", help="carry out a plan of stents", allow_abbrev=False))
    _compare(commands.add_parser("compare", help="plans side by side", allow_abbrev=False))
    _measure(
        commands.add_parser(
            "measure", help="lesions of a vessel, and diameters along it", allow_abbrev=False
        )
    )
    _suggest(commands.add_parser("suggest", help="a plan for a lesion", allow_abbrev=False))
    _check(commands.add_parser("check", help="is a surface sound", allow_abbrev=False))
    _centerline(
        commands.add_parser(
            "centerline", help="extract the centerline of a surface", allow_abbrev=False
        )
    )
    add_sweep(commands.add_parser("sweep", help="many deployments", allow_abbrev=False))
    _extract(commands.add_parser("extract", help="a segment for a flow solver", allow_abbrev=False))
    _devices(commands.add_parser("devices", help="the device table", allow_abbrev=False))
    _demo(commands.add_parser("demo", help="treat a synthetic patient", allow_abbrev=False))
    add_app(commands.add_parser("app", help="plan stents in a browser", allow_abbrev=False))
    return top


def _first_of_deploy() -> Parser:
    """What everyone needs of `deploy`: its own short help, and the beginning of the long one."""
    first = Parser(
        prog="sdfstent deploy",
        usage="sdfstent deploy SURFACE -o OUT --centerline FILE --center X Y Z --length L "
        "--diameter D",
        description="Deploy one stent in a vessel surface.",
        epilog="All options, such as other places, shapes, the method and more outputs: --help-all",
        add_help=False,
    )
    add_surface(first)
    group = first.add_argument_group("what everyone needs")
    group.add_argument(
        "-o", "--output", type=_path, metavar="OUT", required=True, help="surface to write"
    )
    _add_usual_place(group)
    group.add_argument(
        "--at-lesion",
        type=_whole,
        metavar="N",
        help="in place of --center: on that lesion, numbered as `measure` lists them",
    )
    add_size(group)
    add_units(group)
    group.add_argument(
        "--report",
        type=_path,
        metavar="F",
        action="append",
        default=[],
        help=".json or .html; may be repeated",
    )
    group.add_argument(
        "--save-plan", type=_path, metavar="F", help="what determines the result, for `run`"
    )
    return first


def _deploy(command: argparse.ArgumentParser, first: Parser) -> None:
    command.description = first.description
    _add_other_places(command.add_argument_group("where"))
    add_stent(command)
    add_shape(command)
    add_method(command)
    out = command.add_argument_group("output")
    out.add_argument(
        "--output-centerline", type=_path, metavar="F", help="the centerline, moved along"
    )
    out.add_argument(
        "--flow",
        type=_number,
        nargs=2,
        metavar=("LEAST", "MOST"),
        help="mL/s; the pressure drop over the stented length is estimated for both, as a band",
    )
    _add_output(out)
    add_talk(command, verbose=True)
    command.add_argument("-h", "--help", action=ShortHelp, const=first, help="the first of these")
    command.add_argument("--help-all", action="help", help="all of these")


def _run(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Carry out a plan: stents in order, in a surface. Writes the surface, the centerline, "
        "report.json, report.html and plan.json."
    )
    command.add_argument("plan", type=_path, metavar="PLAN", help="JSON, see docs/plan.md")
    command.add_argument(
        "-o", "--output", type=_path, metavar="DIR", required=True, help="folder to write"
    )
    add_acceptance(command)
    _add_output(command.add_argument_group("output"))
    add_talk(command, verbose=True)


def _compare(command: argparse.ArgumentParser) -> None:
    add_comparison(command)
    add_talk(command, verbose=True)


def _measure(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Lesions of a vessel tree, the tightest first, and diameters along a part of it: of the "
        "largest inscribed sphere and of the circle with the area of the cross-section."
    )
    add_surface(command)
    place = command.add_argument_group("where")
    _add_usual_place(place)
    _add_other_places(place)
    command.add_argument(
        "--spacing", type=_number, metavar="MM", default=1.0, help="of the stations (default 1)"
    )
    add_units(command)
    command.add_argument(
        "--tables", action="store_true", help="the diameters along every branch, too"
    )
    add_json(command)
    command.add_argument("--csv", type=_path, metavar="F", help="write the table of lesions")
    command.add_argument(
        "--smallest-vessel",
        type=_number,
        metavar="MM",
        help="count lesions in vessels below this diameter in one line (default 3)",
    )
    add_talk(command, verbose=True)


def _suggest(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Propose a stent for a lesion: its diameters and lengths, the rule, and how they compare "
        "with the vessel; a proposal to discuss, research use only."
    )
    add_surface(command)
    command.add_argument("--centerline", type=_path, metavar="FILE", required=True, help="any form")
    add_wishes(command)
    add_vessel_marks(command)
    add_units(command)
    add_json(command)
    add_talk(command)


def _check(command: argparse.ArgumentParser) -> None:
    command.description = "Topology and self-intersections of a surface."
    add_surface(command)
    add_units(command)
    add_json(command)
    add_talk(command)


def _centerline(command: argparse.ArgumentParser) -> None:
    command.description = (
        "The centerlines of a bare surface, from its inlet to every outlet, by VMTK "
        "(https://vmtk.github.io). Ends are open or closed by flat caps."
    )
    add_surface(command)
    command.add_argument(
        "-o", "--output", type=_path, metavar="F", required=True, help="VTP or VTK to write"
    )
    add_point(command, "inlet", "the end near this point is proximal (default: the largest)")
    add_points(
        command, "outlet", "a line ends near this point; once or more (default: at every end)"
    )
    add_units(command)
    add_talk(command)


def _extract(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Cut the segment between two places of the centerline out of a vessel and close it by flat "
        "caps, with face files for SimVascular's solvers: in cm, inlet and outlets named."
    )
    add_surface(command)
    command.add_argument("--centerline", type=_path, metavar="FILE", required=True, help="any form")
    add_point(command, "from", "one end of the segment", required=True)
    add_point(command, "to", "the other end", required=True)
    command.add_argument(
        "-o", "--output", type=_path, metavar="DIR", required=True, help="folder to write"
    )
    command.add_argument(
        "--close-branches", action="store_true", help="cut side branches off and close them"
    )
    command.add_argument(
        "--after", type=_path, metavar="SURFACE2", help="the treated vessel, cut by the same planes"
    )
    add_point(command, "root", "the end of the centerline near this point is proximal")
    add_units(command)
    add_talk(command)


def _devices(command: argparse.ArgumentParser) -> None:
    command.description = (
        "The devices that `deploy --device` knows, and what is known of one, with its source. "
        "Every number has one, or is that of a generic row; what is not known is not made up."
    )
    command.add_argument("name", type=_path, nargs="?", metavar="NAME", help="tell all of this one")
    add_device_table(command)
    add_json(command)
    add_talk(command)


def _demo(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Treat a synthetic patient: a pulmonary artery whose left branch is narrowed by 40 % at "
        "its origin gets a stent across the bifurcation."
    )
    command.add_argument("-o", "--output", type=_path, metavar="DIR", default="sdfstent-demo")
    add_talk(command, verbose=True)


def _add_usual_place(place: argparse._ActionsContainer) -> None:
    place.add_argument("--centerline", type=_path, metavar="FILE", help="of the vessel, any form")
    add_point(place, "center", "the middle of the stent")
    add_length(place)


def _add_other_places(place: argparse._ActionsContainer) -> None:
    place.add_argument("--axis", type=_path, metavar="FILE", help="the curve is the stent axis")
    for name, what in (
        ("distal", "its distal end"),
        ("proximal", "its proximal end"),
        ("from", "one end"),
        ("to", "the other end"),
    ):
        add_point(place, name, what)
    add_vessel_marks(place)


def _add_output(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--figure", type=_path, metavar="F", help="diameters as .png or .svg")
    group.add_argument(
        "--picture", type=_path, metavar="F", help="the vessel before and after as .png"
    )
    group.add_argument(
        "--export-0d", type=_path, metavar="F", help="vessel blocks for a 0D solver, as .json"
    )
    add_device_file(group)
    group.add_argument(
        "--steps", type=_path, metavar="DIR", help="the surface at every step, for ParaView"
    )
    group.add_argument(
        "--every", type=_number, metavar="MM", help="with --steps: only after so much of diameter"
    )
    group.add_argument(
        "--arrays", action="store_true", help="add displacement and stretch to the surface"
    )
