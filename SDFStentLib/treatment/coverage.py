"""Whether a stent, once it has shortened, is as long as the lesion that it treats."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from ..cautions import Caution
from .lesions import TreatedLesion
from .placing import NOTICED, uncovered_length
from .ratios import ratio_cautions
from .value import TreatedStent


def size_cautions(
    stents: Sequence[TreatedStent],
    lesions: Sequence[TreatedLesion] | None,
    label: Callable[[int], str] = "".format,
) -> Iterator[Caution]:
    """Where stents are too short for their lesions, or as wide as no source had them.

    Parameters
    ----------
    stents : sequence of TreatedStent
    lesions : sequence of TreatedLesion or None
        Of their vessel; None where they were not looked for.
    label : callable
        Names a stent by its number.
    """
    yield from _uncovered(stents, lesions or (), label)
    yield from ratio_cautions(stents, lesions, label)


def _uncovered(
    stents: Sequence[TreatedStent], lesions: Sequence[TreatedLesion], label: Callable[[int], str]
) -> Iterator[Caution]:
    """Where the tightest lesion that a stent covers goes on beyond all stents in it."""
    told: set[int] = set()
    for one in stents:
        own = [lesion for lesion in lesions if one.number in lesion.stents]
        for lesion in own[:1]:
            within = [stent for stent in stents if stent.number in lesion.stents]
            left = uncovered_length(lesion.before, [stent.axis.line for stent in within])
            if left > NOTICED and lesion.number not in told:
                told.add(lesion.number)
                yield Caution(
                    "lesion-uncovered",
                    {
                        "lesion": lesion.number,
                        "uncovered_mm": left,
                        "lesion_mm": lesion.before.length,
                        "deployed_mm": one.axis.deployed_length,
                        "packed": _packed(one),
                    },
                    stent=one.number,
                ).labeled(label(one.number))


def _packed(one: TreatedStent) -> str:
    """How long it was before it shortened, in words; empty where it did not."""
    if one.axis.nominal_length <= one.axis.deployed_length:
        return ""
    return f", {one.axis.nominal_length:g} mm as packed"
