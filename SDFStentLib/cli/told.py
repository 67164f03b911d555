"""What a deployment did, in few lines; all of it where that is asked for."""

from __future__ import annotations

from collections.abc import Iterable

from ..cautions import Caution
from ..plan import PlanResult
from ..report import deployment_sentences, deployment_summary
from .console import Console

LINES = 8
"""Of a deployment on the screen, unless all of it is asked for."""


def tell(
    result: PlanResult, cautions: Iterable[Caution], console: Console, label: str = ""
) -> None:
    """Say what came of a deployment, the certificate last; the line of its files is the caller's.

    Every sentence, warnings too, begins with `label`.
    """
    summary = deployment_summary(result)
    console.say(label + summary.deployed)
    labeled = [caution.labeled(label) for caution in cautions]
    units = result.inputs.surface.units
    # The first line and that of the files are told apart.
    console.warn_shortly(labeled, LINES - 2 - len(summary.results), units)
    told = deployment_sentences(result) if console.verbose else summary.results
    for sentence in told:
        console.say(label + sentence)
