"""Parsing of the command line: types of words, options from tables, and the parser."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from ..line_formats import LINES_IN_WORDS
from ..parameter import Parameter
from ..plan import Plan, method_parameters, plan_of_method, plan_schema
from ..scan_formats import SCANS_IN_WORDS
from ..surface_formats import FORMATS_IN_WORDS
from ..units import MILLIMETERS

UNITS = f"--units {{{','.join(MILLIMETERS)}}} = mm  of the files (default mm)\n"
ROOT = "--root X Y Z  the end of the centerline near this point is proximal\n"
SURFACE = f"surface SURFACE  {FORMATS_IN_WORDS}\n"
CENTERLINE = f"--centerline FILE  any form; {LINES_IN_WORDS}\n"
NAMES = "--names F  JSON: what vessels are called, each by a place in it or the face at its end\n"
USUAL_PLACE = f"""\
--centerline FILE  of the vessel, any form; {LINES_IN_WORDS}
--center X Y Z  the middle of the stent
"""
OTHER_PLACES = f"""\
--axis FILE  the curve is the stent axis; {LINES_IN_WORDS}
--distal X Y Z  its distal end
--proximal X Y Z  its proximal end
--from X Y Z  one end
--to X Y Z  the other end
"""
BY_VESSEL = """\
--offset MM  with --at-lesion: the middle of the stent so far distal of that of the lesion
--branch B  the middle of the stent on this branch, by its number or its name in `measure`
--distance MM  with --branch: so far along it
--fraction S  with --branch: at such a part of its length, 0 to 1
"""
MARKS = f"""\
--root X Y Z  the end of the centerline near this point is proximal (default: the tree tells)
--reference X Y Z ...  healthy vessel that the lesion beside it is measured against; once or twice
{NAMES}"""
FRAME = "--frame {RAS,LPS}  of a surface whose file does not say it\n"
ACCEPTANCE = """\
--accept-changed-inputs  go on although a file is not the one that the plan was made with
"""
HIDING = "--hide-device  pictures without the struts of the stents\n"
OUTPUT = f"""\
--figure F  diameters as .png or .svg
--picture F  the vessel before and after as .png
--angiogram F  the stents as an X-ray shows them before and after, from their best views: .png, .svg
--export-0d DIR  the vessel as networks for svZeroDSolver; needs a flow
--export-device F  rings and struts of the stents, as .vtp
--device-mesh F  with --export-device: this straight mesh, along z and centered, laid along the axis
{HIDING}--steps DIR  the surface at every step, for ParaView
--every MM  with --steps: only after so much of diameter
--arrays  add displacement and stretch to the surface
--whole-tree  all lesions of the tree in the report, not only those of treated vessels
--voxel-range  deploy with the wall half a voxel in and out, too: ranges of lumen, stenosis and
  pressure drop, for a surface from `prepare`; takes up to three times as long
"""
JSON = "--json  print JSON instead of sentences\n"
VERBOSE = "--verbose  say all of it\n"
TALK = """\
--quiet  say nothing but errors
--debug  show where an error came from
"""
WORK = f"--threads N  to calculate with (default: one per core)\n{TALK}"


def number(text: str) -> float:
    """Number in a word."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, got {text.strip()!r}") from None


def whole(text: str) -> int:
    """A word as a whole number."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a whole number, got {text.strip()!r}") from None


def path(text: str) -> str:
    """A word as the name of a file, a folder or a device."""
    # An empty word would be taken for the working folder, or for an option that is left out.
    if not text:
        raise argparse.ArgumentTypeError("expected a file or folder, got nothing")
    return text


KINDS = {
    **dict.fromkeys(("X", "MM", "D", "R", "S", "P", "W", "A", "LEAST"), number),
    **dict.fromkeys(("FILE", "F", "DIR", "OUT", "PLAN", "SWEEP", "SURFACE", "SURFACE2"), path),
    "SEGMENTATION": path,
    "NAME": path,
    "DIR|PAGE.html": path,
    "SURFACE|PLAN.json": path,
    "N": whole,
}
"""Types of words by their metavar; words of any other metavar are text."""

_ROW = re.compile(
    r"(?P<flags>\S+(?:, --\S+)?)(?P<metavar>(?: [A-Z{]\S*)*)"
    r"(?: = (?P<default>\S+))?(?P<more> \.\.\.)?  +(?P<words>.+)"
)


def add_table(group: argparse._ActionsContainer, table: str, **more: Any) -> None:
    """Add an option per line: `--name METAVAR = default ...  words`, dots if it may be repeated.

    Without a metavar it is a switch, without dashes a positional argument; choices stand in braces.
    An indented line continues the words. Further arguments of argparse, such as `required`, apply
    to all of them.
    """
    for line in re.sub(r"\n +", " ", table).strip().splitlines():
        row = _ROW.fullmatch(line)
        assert row is not None, line
        flags, metavars = row["flags"].split(", "), tuple(row["metavar"].split())
        given: dict[str, Any] = {"help": row["words"], **more}
        if not metavars:
            group.add_argument(*flags, action="store_true", **given)
            continue
        if metavars[0].startswith("{"):
            given["choices"] = metavars[0].strip("{}").split(",")
        else:
            given["metavar"] = metavars if len(metavars) > 1 else metavars[0]
            given["type"] = KINDS.get(metavars[0], str)
        if len(metavars) > 1:
            given["nargs"] = len(metavars)
        if row["default"]:
            given["default"] = given.get("type", str)(row["default"])
        if row["more"]:
            given = {"action": "append", "default": [], **given}
        if flags == ["--from"]:  # `options.from` is no Python
            given["dest"] = "from_point"
        group.add_argument(*flags, **given)


def add_parameter(
    group: argparse._ActionsContainer, parameter: Parameter, default: Any = None, dest: str = ""
) -> None:
    """Add the option of a parameter; `dest` is its attribute if that is not the option's name."""
    option = f"--{parameter.option}"
    more: dict[str, Any] = {"dest": dest or attribute_of(parameter)}
    if not (parameter.names or parameter.is_number):
        words = f"do not {parameter.does}" if default else parameter.does
        group.add_argument(option, action=f"store_{not default}".lower(), help=words, **more)
        return
    extras = [parameter.unit, "" if default is None else f"default {default}".removesuffix(".0")]
    words = " ".join([parameter.does, *[f"({', '.join(filter(None, extras))})"][: any(extras)]])
    if parameter.names:
        more["choices"] = parameter.names
    else:
        more |= {"type": number, "metavar": parameter.unit.upper() or "F"}
    group.add_argument(option, default=default, help=words, **more)


def attribute_of(parameter: Parameter) -> str:
    """The attribute of the namespace that has the option of a parameter; empty without one."""
    return parameter.option.replace("-", "_")


def add_method(command: argparse.ArgumentParser) -> None:
    """Add the parameters of the method that have an option, in their order."""
    group = command.add_argument_group("method")
    for name, parameter in method_parameters().items():
        if parameter.option:
            add_parameter(group, parameter, Plan().method[name], name)


def method_of(options: argparse.Namespace) -> Plan:
    """A plan without stents and files, with the requested parameters."""
    parameters = method_parameters().items()
    return plan_of_method({name: getattr(options, name) for name, one in parameters if one.option})


def add_schema(command: argparse.ArgumentParser, documents: str) -> None:
    """Add the option that prints the JSON schema of plans or of sweeps."""

    def text() -> str:
        if documents == "plans":
            return json.dumps(plan_schema(), indent=2) + "\n"
        from ..cohort import sweep_schema  # late: what a sweep needs is large

        return json.dumps(sweep_schema(), indent=2) + "\n"

    words = f"print the JSON schema of {documents}"
    command.add_argument("--schema", action=Printed, const=text, help=words)


def add_prepare(command: argparse.ArgumentParser) -> None:
    """Add the options of `prepare`."""
    command.description = (
        "The surface of a segmented vessel with flat ends, inlet and outlets named, and its "
        "centerline. Points are in mm and LPS."
    )
    add_table(command, f"segmentation SEGMENTATION  {SCANS_IN_WORDS}\n")
    add_table(command, "-o, --output DIR  folder to write", required=True)
    add_table(
        command,
        f"""\
--label NAME  which label, by its number or its name (default: the only one)
--inlet X Y Z  the end near this point is the inlet (default: the widest)
{WORK}""",
    )


class Parser(argparse.ArgumentParser):
    """A parser that reports an error in one sentence."""

    def parse_known_args(self, args=None, namespace=None):  # type: ignore[no-untyped-def]
        """Parse as inherited, but words left over are an error of the command to which
        they were given."""
        options, rest = super().parse_known_args(args, namespace)
        if rest:
            self.error(f"unrecognized arguments: {' '.join(rest)}{self._nearest(rest)}")
        return options, rest

    def _nearest(self, words: Sequence[str]) -> str:
        """The option that may have been meant by the first unknown one."""
        names = [word.split("=")[0] for word in words if word.startswith("-")]
        known = re.findall(r"(?<![\w-])--[a-z0-9][\w-]*", self.format_help())
        if not names:
            return ""
        begun = sorted((one for one in known if one.startswith(names[0])), key=len)
        near = begun or get_close_matches(names[0], known, 1, cutoff=0.75)
        return f", the nearest option is {near[0]}" if near else ""

    def error(self, message: str) -> NoReturn:
        """Exit with the sentence on stderr and exit code 2."""
        message = message.replace("3 arguments", "three numbers with spaces between them")
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help.\n")


class Printed(argparse.Action):
    """An action that prints what a function returns, and exits."""

    def __init__(
        self, option_strings: Sequence[str], dest: str, const: Callable[[], str], help: str
    ) -> None:
        super().__init__(option_strings, argparse.SUPPRESS, 0, const, argparse.SUPPRESS, help=help)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> NoReturn:
        print(self.const(), end="")
        parser.exit()
