"""The command `views`."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ...files import check_suffix
from ...geometry import Surface
from ...plan import InputFiles
from ...report import (
    Look,
    Sight,
    Stretch,
    ToldViews,
    document_json,
    file_facts,
    lesion_stretch,
    views_document,
    write_views,
)
from ...stent import Stent, stent_axis
from ...validation import InputError, as_number
from ...vessel import lesion_after
from ..console import LINES, Console
from ..outputs import Outputs
from ..place import check_lesion_number, check_place, inputs_of, place_of, treated_of
from .options import views_of, wishes_of

_PROBE_DIAMETER = 1.0
"""Diameter of the stent by which the place is looked at, mm; any number will do."""


def views_command(options: argparse.Namespace, console: Console) -> int:
    """Report the best views of a lesion, and draw them."""
    is_lesion = options.at_lesion is not None and options.length is None
    has_length = None if not is_lesion else True
    way = check_place(options, needed=False, has_length=has_length)
    if options.centerline is None:
        raise InputError("expected --centerline FILE, got none; give one.")
    wishes, asked = wishes_of(options), views_of(options)
    reach = options.reach
    if reach is not None:
        reach = as_number(reach, "--reach", unit="mm", above=0)
    read = [options.surface, options.centerline, options.after, options.axis]
    outputs = Outputs([*read, options.names, options.limits])
    if options.output is not None:
        check_suffix(options.output, "a picture", (".png", ".svg"))
        outputs.add(options.output, lambda path: write_views(path, told, walls, look))
    if options.json is not None:
        outputs.add(options.json, lambda path: _write(path, told, inputs))
    look = Look(is_subtracted=options.subtracted, reach=reach)
    look = look._replace(source=None) if options.parallel else look
    inputs = inputs_of(options)
    after = None if options.after is None else treated_of(options, inputs).surface.surface
    walls = [inputs.surface.surface, *([] if after is None else [after])]
    stretch = _stretch(options, way, inputs, after)
    told = Sight(stretch, inputs.vessel, inputs.frame).told(wishes, asked)
    console.warn_shortly(inputs.warnings, LINES, options.units)
    outputs.write()
    for sentence in told.sentences:
        console.say(sentence)
    if outputs.names():
        console.say(f"Wrote {' and '.join(outputs.names())}")
    return 0


def _stretch(
    options: argparse.Namespace, way: str | None, inputs: InputFiles, after: Surface | None
) -> Stretch:
    """Stretch to look at: a lesion as long as it is, or the place that the options say."""
    vessel = inputs.vessel
    if way is None or (way == "at_lesion" and options.length is None):
        number = 1 if options.at_lesion is None else options.at_lesion
        check_lesion_number(number, inputs, "--at-lesion", "name a place by points")
        assert vessel.lesions is not None
        lesion = vessel.lesions[number - 1]
        left = None if after is None else lesion_after(lesion, after)
        return lesion_stretch(number, lesion, left)
    stent = Stent(
        _PROBE_DIAMETER,
        placement=place_of(options, way, inputs).placement,
        length=options.length,
        foreshortening_fraction=0.0,
        may_be_shortened=True,
    )
    assert vessel.centerline is not None
    line = stent_axis(vessel.placed(stent), vessel.centerline).line
    # Radii along an axis that was drawn are those of the vessel beside it.
    near = [vessel.centerline.project(point).inscribed_radius for point in line.points]
    return Stretch("Part", line, np.array(near), line.length)


def _write(path: Path, told: ToldViews, inputs: InputFiles) -> None:
    document = views_document(told, **file_facts(inputs.surface).as_dict())
    path.write_text(document_json(document), encoding="utf-8")
