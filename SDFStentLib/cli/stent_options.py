"""The stent that the options of the command line say, and the same one dilated again."""

from __future__ import annotations

import argparse

from ..parameter import parameters_of
from ..plan import InputFiles, device_named, read_profile
from ..stent import Device, Shape, Stent, StentEnd, Waist, balloon_of, dilated_again
from ..validation import InputError
from .option_table import attribute_of
from .place import option_of, place_of


def check_sizes(options: argparse.Namespace) -> None:
    """Whether the options say how wide the stent will be, once; `InputError` otherwise."""
    if options.profile is not None:
        _check_profile_alone(options)
    elif options.diameter is None and options.balloon is None:
        raise InputError(
            "expected --diameter D of the lumen or --balloon D, got neither; give one of them."
        )
    if options.diameter is not None and options.balloon is not None:
        raise InputError(
            "expected either --diameter, of the lumen, or --balloon, got both; leave one out."
        )


def _check_profile_alone(options: argparse.Namespace) -> None:
    others = ("diameter", "balloon", "recoil", "redilate", "waist", "flare_start", "flare_end")
    given = [option_of(name) for name in others if getattr(options, name) is not None]
    if given:
        raise InputError(
            "expected --profile alone, which has all diameters, got it with "
            f"{' and '.join(given)}; leave one of them out."
        )


def shape_of(options: argparse.Namespace) -> Shape | None:
    """The shape that was asked for; None for a cylinder with half spheres beyond its ends.

    Raises
    ------
    InputError
        A profile that cannot be read, sizes out of range, or a place of a waist without one.
    """
    for name in ("waist_position", "waist_length"):
        if getattr(options, name) is not None and options.waist is None:
            raise InputError(f"expected --waist D with {option_of(name)}, got none; give one.")
    waist = None
    if options.waist is not None:
        waist = Waist(options.waist, options.waist_position, options.waist_length)
    start, end = (
        None if sizes is None else StentEnd(*sizes)
        for sizes in (options.flare_start, options.flare_end)
    )
    table = () if options.profile is None else read_profile(options.profile)
    more = {name: getattr(options, name) for name in parameters_of(Shape)}
    shape = Shape(waist, start, end, table, **more)
    return None if shape == Shape() else shape


def device_of(options: argparse.Namespace) -> Device | None:
    """The device that was named; `InputError` for one that is not there, or a table alone."""
    if options.device is None:
        if options.device_table is not None:
            raise InputError("expected --device NAME with --device-table, got none; name one.")
        return None
    return device_named(options.device, options.device_table)


def stents_of(
    options: argparse.Namespace, way: str, inputs: InputFiles, device: Device | None
) -> tuple[Stent, ...]:
    """Stents by the options: one, or with a later diameter the same a second time.

    Raises
    ------
    InputError
        Sizes that cannot be, or that its device or its place rule out.
    """
    balloon, recoil = options.balloon, options.recoil
    if balloon is None and recoil is not None:
        balloon = options.diameter
    stent = _stent(options, balloon, device).at(place_of(options, way, inputs).placement)
    if balloon is not None:
        stent = inputs.vessel.inflated(stent, balloon, recoil)
    if options.redilate is None:
        return (stent,)
    return stent, dilated_again(inputs.vessel.placed(stent), 1, options.redilate)


def _stent(options: argparse.Namespace, balloon: float | None, device: Device | None) -> Stent:
    """The stent at no place yet, as wide as a balloon leaves it that recoils as usual."""
    shape, diameter = shape_of(options), options.diameter
    if balloon is not None:
        diameter = balloon_of(balloon, options.recoil).lumen_diameter
    elif diameter is None:
        assert shape is not None  # checked by then
        diameter = max(wide for _, wide in shape.table)
    attributes = {name: attribute_of(one) for name, one in parameters_of(Stent).items()}
    named = {name: getattr(options, own) for name, own in attributes.items() if own}
    given = {name: value for name, value in named.items() if value is not None}
    return Stent(**{**given, "diameter": diameter}, device=device, shape=shape)
