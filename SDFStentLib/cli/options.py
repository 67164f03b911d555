"""The options of every command, as tables."""

from __future__ import annotations

import argparse

from ..line_formats import LINES_IN_WORDS
from ..parameter import parameters_of
from ..stent import Balloon, Shape, Stent, Waist
from ..version import VERSION
from .flow_options import add_flow, add_known, add_simulate
from .option_table import (
    ACCEPTANCE,
    BY_VESSEL,
    CENTERLINE,
    FRAME,
    HIDING,
    JSON,
    MARKS,
    NAMES,
    OTHER_PLACES,
    OUTPUT,
    ROOT,
    SURFACE,
    TALK,
    UNITS,
    USUAL_PLACE,
    VERBOSE,
    WORK,
    Parser,
    Printed,
    add_method,
    add_parameter,
    add_prepare,
    add_schema,
    add_table,
)
from .views.options import add_views

OF_STENT = parameters_of(Stent)
DEVICE = "--device NAME  one of `sdfstent devices`; sets its lengths\n"
DEVICE_TABLE = "--device-table F  JSON with devices of your own, too\n"


def parser() -> Parser:
    """The parser of the whole command line."""
    top = Parser(
        prog="sdfstent",
        description="Virtual stenting of vessel surfaces. Sizes in mm; points in the unit and "
        "frame of the files. Research use only, not a medical device.",
        epilog="Exit codes: 0 done and certified; 1 unexpected error; 2 bad input, nothing "
        "written; 3 done, but not certified; 130 interrupted, nothing written.",
        allow_abbrev=False,
    )
    top.add_argument("--version", action="version", version=f"sdfstent {VERSION}")
    commands = top.add_subparsers(
        dest="command", metavar="COMMAND", required=True, parser_class=Parser
    )
    first = _first_of_deploy()
    deploy = commands.add_parser(
        "deploy", help="deploy one stent", allow_abbrev=False, add_help=False, parents=[first]
    )
    _deploy(deploy, first)
    for name, words, add in (
        ("run", "carry out a plan of stents", _run),
        ("compare", "plans side by side", _compare),
        ("measure", "lesions of a vessel, and diameters along it", _measure),
        ("suggest", "a plan for a lesion", _suggest),
        ("views", "C-arm angles for a lesion, and its angiogram", add_views),
        ("check", "is a surface sound", _check),
        ("centerline", "extract the centerline of a surface", _centerline),
        ("prepare", "surface and centerline of a segmentation", add_prepare),
        ("sweep", "many deployments", _sweep),
        ("extract", "a segment for a flow solver", _extract),
        ("flow", "pressures and flows before and after", add_flow),
        ("simulate", "flow in three dimensions, before and after", add_simulate),
        ("devices", "the device table", _devices),
        ("demo", "treat a synthetic patient", _demo),
        ("app", "plan stents in a browser", _app),
    ):
        add(commands.add_parser(name, help=words, allow_abbrev=False))
    return top


def _first_of_deploy() -> Parser:
    """The first options of `deploy`: its own short help, and the beginning of the long one."""
    first = Parser(
        prog="sdfstent deploy",
        usage="sdfstent deploy SURFACE -o OUT --centerline FILE --center X Y Z --length L "
        "--diameter D",
        description="Deploy one stent in a vessel surface.",
        epilog="All options, such as other places, shapes, the method and more outputs: --help-all",
        add_help=False,
    )
    add_table(first, SURFACE)
    group = first.add_argument_group("what everyone needs")
    add_table(group, "-o, --output OUT  surface to write", required=True)
    _add_usual_place(group)
    add_table(
        group,
        "--at-lesion N  in place of --center: on that lesion, numbered as `measure` lists them",
    )
    add_parameter(group, OF_STENT["diameter"])
    add_table(
        group,
        f"{DEVICE}{UNITS}--report F ...  .json or .html; may be repeated\n"
        "--save-plan F  what determines the result, for `run`",
    )
    return first


def _deploy(command: argparse.ArgumentParser, first: Parser) -> None:
    command.description = first.description
    add_table(command.add_argument_group("where"), BY_VESSEL + OTHER_PLACES + MARKS + FRAME)
    stent = command.add_argument_group("stent")
    for one in parameters_of(Balloon).values():
        add_parameter(stent, one)
    add_table(stent, f"--redilate MM  then dilate the same stent to it (mm)\n{DEVICE_TABLE}")
    for name, one in OF_STENT.items():
        if name not in ("diameter", "length"):  # which everyone needs
            add_parameter(stent, one, None if one.names or one.is_number else False)
    shape = command.add_argument_group("shape")
    for one in parameters_of(Waist).values():
        add_parameter(shape, one)
    for name, end in (("start", "proximal"), ("end", "distal")):
        words = f"diameter of the {end} end, wider or narrower, and over which length"
        add_table(shape, f"--flare-{name} D MM  {words}")
    add_table(shape, "--profile F  CSV with rows fraction,diameter in place of --diameter")
    for name, one in parameters_of(Shape).items():
        add_parameter(shape, one, getattr(Shape(), name))
    add_method(command)
    add_known(command)
    add_table(
        command.add_argument_group("output"),
        f"""\
--output-centerline F  the centerline, moved along
{OUTPUT}""",
    )
    add_table(command, VERBOSE + WORK)
    words = "the first of these"
    command.add_argument("-h", "--help", action=Printed, const=first.format_help, help=words)
    command.add_argument("--help-all", action="help", help="all of these")


def _run(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Carry out a plan: stents in order, in a surface. Writes the surface, the centerline, "
        "report.json, report.html and plan.json."
    )
    add_table(command, "plan PLAN  JSON, see docs/plan.md")
    add_table(command, "-o, --output DIR  folder to write", required=True)
    add_table(command, ACCEPTANCE + FRAME)
    add_table(command.add_argument_group("output"), OUTPUT)
    add_table(command, VERBOSE + WORK)
    add_schema(command, "plans")


def _compare(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Carry out several plans of one patient and show them side by side: what every plan does "
        "to lumen, lesions, branches and wall, with pictures by one camera, on one page."
    )
    add_table(command, "plans PLAN  two or more; JSON, see docs/plan.md", nargs="+")
    page = "-o, --output DIR|PAGE.html  page to write, or folder for page and JSON"
    add_table(command, page, required=True)
    add_table(
        command,
        f"{ACCEPTANCE}--picture F  before and after every plan, as .png\n"
        f"{HIDING}{JSON}{VERBOSE}{WORK}",
    )


def _measure(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Lesions of a vessel tree, those of main vessels first, then the tightest, and diameters "
        "along a part of it: of the largest inscribed sphere and of the circle with the area of "
        "the cross-section."
    )
    add_table(command, SURFACE)
    place = command.add_argument_group("where")
    _add_usual_place(place)
    add_table(place, OTHER_PLACES + MARKS)
    add_table(
        command,
        f"""\
--spacing MM = 1  of the stations (default 1)
{UNITS}--tables  the diameters along every branch, too
{JSON}--csv F  write the table of lesions
--smallest-vessel MM  count lesions in vessels below this diameter in one line (default 3)
--voxel-range  lesions with the wall half a voxel in and out, too, of a surface from `prepare`
{VERBOSE}{TALK}""",
    )


def _suggest(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Propose a stent for a lesion: its diameters and lengths, the rule, and how they compare "
        "with the vessel; a proposal to discuss, research use only."
    )
    add_table(command, SURFACE)
    add_table(command, CENTERLINE, required=True)
    add_table(
        command,
        f"""\
-o, --output PLAN  to write (default SURFACE_plan.json)
--lesion N ...  numbered as `measure` lists them; may be repeated (default 1)
--ratio R = 1  lumen over the smaller healthy vessel beside the lesion (default 1)
--margin MM = 0  how far beyond both ends of the lesion (default 0)
{DEVICE}{DEVICE_TABLE}""",
    )
    add_parameter(command, OF_STENT["foreshortening_fraction"])
    add_table(command, MARKS + UNITS + JSON + TALK)


def _check(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Topology and self-intersections of a surface, and whether it is of one run with the "
        "reports beside it. Of a report (.json), whether its files are those written with it."
    )
    add_table(command, SURFACE + UNITS + JSON + TALK)


def _centerline(command: argparse.ArgumentParser) -> None:
    command.description = "The centerlines of a bare surface; its ends are open, flat or round."
    add_table(command, SURFACE)
    add_table(command, "-o, --output F  VTP or VTK to write", required=True)
    add_table(
        command,
        f"""\
--inlet X Y Z  the end near this point is proximal (default: the largest)
--outlet X Y Z ...  a line ends near this point; once or more (default: at every end)
{UNITS}{WORK}""",
    )
    command.add_argument(
        "--method",
        choices=("own", "vmtk"),
        default="own",
        help="own needs no other package; vmtk is https://vmtk.github.io (default: own)",
    )


def _sweep(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Carry out many deployments: the cases of a sweep document, on all cores or on a Dask "
        "cluster. Run again it goes on where it was interrupted. Exit codes: 0 every case is done "
        "and certified; 3 some are not certified; 4 some failed, or the sweep had to stop; 130 "
        "interrupted. What is whole is always kept."
    )
    add_table(command, "sweep SWEEP  JSON, see docs/cohorts.md", nargs="?")
    add_table(
        command,
        f"""\
-o, --output DIR  folder of the cohort
--workers N  processes (default: one per core)
--scheduler ADDRESS  of a Dask cluster, such as tcp://host:8786
--time-limit S  seconds for each case on this machine: then its worker is ended, and it has failed
  (default: that of the document, or none)
--dry-run  tell how many cases, the first ones, and how long and large it will be
--table DIR  write the manifest of a cohort again
--status DIR  how far the sweep in a folder is
{TALK}""",
    )
    add_schema(command, "sweeps")


def _extract(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Cut the segment between two places of the centerline out of a vessel and close it by flat "
        "caps, with face files for SimVascular's solvers: in cm, inlet and outlets named."
    )
    add_table(command, SURFACE)
    add_table(
        command,
        f"""\
{CENTERLINE}--from X Y Z  one end of the segment
--to X Y Z  the other end
-o, --output DIR  folder to write
""",
        required=True,
    )
    add_table(
        command,
        f"""\
--close-branches  cut side branches off and close them
--after SURFACE2  the treated vessel, cut by the same planes
{ROOT}{NAMES}{UNITS}{TALK}""",
    )


def _devices(command: argparse.ArgumentParser) -> None:
    command.description = (
        "The devices that `deploy --device` knows, and what is known of one, with its source. "
        "Every number has one, or is that of a generic row; what is not known is not made up."
    )
    add_table(command, "name NAME  tell all of this one", nargs="?")
    add_table(command, DEVICE_TABLE + JSON + TALK)


def _demo(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Treat a synthetic patient: a pulmonary artery whose left branch is narrowed by 40 % at "
        "its origin gets a stent across the bifurcation."
    )
    folder = "-o, --output DIR = sdfstent-demo  to write (default sdfstent-demo)\n"
    add_table(command, folder + VERBOSE + WORK)


def _app(command: argparse.ArgumentParser) -> None:
    command.description = (
        "Serve the panel of the Slicer module as a page for the browser, to this machine only "
        "unless told otherwise. Ctrl-C ends it."
    )
    add_table(command, "input SURFACE|PLAN.json|SEGMENTATION  what a page begins with", nargs="?")
    add_table(
        command,
        f"""\
--centerline F  of the surface; {LINES_IN_WORDS}
{UNITS}--demo  begin with a synthetic patient instead
--folder DIR ...  whose files pages may open, with those below; may be repeated. Without one: none
""",
    )
    add_table(
        command.add_argument_group("server"),
        """\
--host HOST = 127.0.0.1  address to listen at (default 127.0.0.1)
--port N = 0  0, the default: one that is free
--no-browser  only say the address, which has a secret in it
--pages N = 8  open at the same time (default 8)
--keep S = 30  that a closed page waits to be opened again (default 30)
--plans DIR  where plans are kept for a day, or none (default: below ~/.local/state)
""",
    )
    add_table(command, TALK)


def _add_usual_place(group: argparse._ActionsContainer) -> None:
    add_table(group, USUAL_PLACE)
    add_parameter(group, OF_STENT["length"])
