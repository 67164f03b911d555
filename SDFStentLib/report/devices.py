"""Devices in a report and on the command line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..parameter import parameters_of
from ..stent import Device, Stent
from .facts import COMPARED, Fact
from .words import UNKNOWN

NO_SOURCE = "none: it is no product, its numbers are assumptions"


def device_facts(device: Device | None) -> Iterator[Fact]:
    """Facts on the device of a stent, and the source of its numbers."""
    yield Fact(after="" if device is None else device.name, column="device")
    if device is None:
        yield Fact("device")
        return
    yield Fact("device", "Device", None, _section(device), "", _named(device), level=COMPARED)
    if device.source:
        yield Fact("", "Source of its numbers", words=source_words(device))
    if device.note:
        yield Fact("", "About it", words=device.note)


def _named(device: Device) -> str:
    """Name of the device, and its maker and family."""
    who = " ".join(filter(None, (device.manufacturer, device.family)))
    return f"{device.name} ({who})" if who else device.name


def _section(device: Device) -> dict[str, Any]:
    """A device as a report has it; null where a number is not known."""
    known = parameters_of(Device)
    found = {}
    for name, value in vars(device).items():
        unit = known[name].unit if name in known else ""
        found[f"{name}_{unit}" if unit else name] = None if value == "" else value
    return found


def device_rows(device: Device) -> list[tuple[str, str]]:
    """Names and values of what is known of a device, and of what is not."""
    covered = {None: UNKNOWN, True: "yes", False: "no"}[device.covered]
    return [
        ("Device", device.name),
        ("Family", device.family or UNKNOWN),
        ("Manufacturer", device.manufacturer or UNKNOWN),
        ("Covered", covered),
        ("Cells", device.cell if device.cell != "unknown" else UNKNOWN),
        ("Nominal length", _size(device.nominal_length)),
        *([("Sold lengths", _sold(device))] if device.sold_lengths else []),
        ("Length on expansion", _shortening(device) or UNKNOWN),
        ("Nominal diameters", _span(device.nominal_diameters)),
        ("Largest diameter", _size(device.maximum_diameter)),
        ("Diameters in the source", _span(device.reported_diameters)),
        ("Lengths in the source", _span(device.reported_lengths)),
        ("Source", source_words(device)),
        *([("Note", device.note)] if device.note else []),
    ]


def device_sentence(device: Device) -> str:
    """A device in one line of a list."""
    known = [*_known(device)]
    if not _shortening(device):
        known.insert(bool(device.offered_lengths), f"shortening {UNKNOWN}")
    what = " ".join(filter(None, (device.manufacturer, device.family)))
    return f"{device.name}: {f'{what}; ' if what else ''}{', '.join(known)}."


def _known(device: Device) -> list[str]:
    """The numbers of a row in words."""
    return [
        words
        for words in (
            device.nominal_length and f"{device.nominal_length:g} mm long",
            device.sold_lengths and f"sold in {_sold(device)}",
            _shortening(device),
            device.nominal_diameters and f"made for {_span(device.nominal_diameters)}",
            device.maximum_diameter and f"up to {device.maximum_diameter:g} mm",
            device.reported_diameters and f"used at {_span(device.reported_diameters)}",
            device.reported_lengths and f"in lengths of {_span(device.reported_lengths)}",
        )
        if words
    ]


def device_sentences(stent: Stent) -> list[str]:
    """Sentence on a stent's device, its length, and the source of that; none without a device."""
    device = stent.device
    if device is None:
        return []
    source = source_words(device)
    if not device.generic:
        source = f"from its source: {', '.join(_known(device)) or 'no number'} ({source})"
    return [f"Device {device.name}: {_sizes(stent, device)}{source}."]


def _sizes(stent: Stent, device: Device) -> str:
    """Words for its lengths and their source: only what its row has is from the row's source."""
    nominal = stent.length
    if nominal is None:
        return ""
    is_offered = nominal in device.offered_lengths
    is_given = stent.foreshortening_fraction is not None
    whose = [
        f"{what} {'as given' if is_users else 'as its row has it'}"
        for what, is_users in (("length", not is_offered), ("shortening", is_given))
    ]
    deployed = nominal * (1.0 - stent.foreshortening)
    return (
        f"{round(nominal, 2):g} mm long as packed, {deployed:.1f} mm at "
        f"{stent.diameter:.4g} mm of diameter ({', '.join(whose)}); "
    )


def source_words(device: Device) -> str:
    """Source of the numbers of a row, and whether they are verified."""
    if not device.source:
        return NO_SOURCE if device.generic else UNKNOWN
    date = f" ({device.source_date})" if device.source_date else ""
    return f"{device.source}{date}; {'verified' if device.verified else 'unverified'}"


def _sold(device: Device) -> str:
    return f"{', '.join(f'{one:g}' for one in device.sold_lengths)} mm"


def _shortening(device: Device) -> str:
    if device.foreshortening_fraction is not None:
        where = "any diameter" if device.generic else "its nominal diameters"
        return f"{_lost(100 * device.foreshortening_fraction)} at {where}"
    return ", ".join(
        f"{length:g} mm long at {diameter:g} mm" for diameter, length in device.lengths
    )


def _lost(percent: float) -> str:
    if percent == 0:
        return "keeps its length"
    return f"loses {percent:g} % of its length" if percent > 0 else f"grows by {-percent:g} %"


def _size(value: float | None) -> str:
    return UNKNOWN if value is None else f"{value:g} mm"


def _span(ends: tuple[float, float] | None) -> str:
    if ends is None:
        return UNKNOWN
    return f"{ends[0]:g} mm" if ends[0] == ends[1] else f"{ends[0]:g} to {ends[1]:g} mm"
