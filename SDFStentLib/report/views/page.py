"""Working views of every stent in a page."""

from __future__ import annotations

from collections.abc import Iterator

from ..markup import facts_table, heading, paragraph
from ..picture.drawing import svg
from .picture import map_drawing
from .planned import PlannedViews, SeenStent

HEADING = "Working views"
NOT_TOLD = "not told"


def views_part(planned: PlannedViews) -> list[str]:
    """Pictures of every stent before and after in its best view, and in one that was chosen, a
    table of its views, and the map of all."""
    if planned.reason:
        return [heading(HEADING), paragraph(f"{NOT_TOLD.capitalize()}: {planned.reason}", "small")]
    several = len(planned.stents) > 1
    return [part for one in planned.stents for part in _of_stent(one, several)]


def _of_stent(one: SeenStent, several: bool) -> Iterator[str]:
    yield heading(f"{HEADING} of {one.title.lower()}" if several else HEADING)
    for facts, drawing in one.drawings():
        yield paragraph(facts.named("_sentence").words, "head")
        yield svg(drawing)
    yield facts_table(one.told.facts, {})
    yield svg(map_drawing(one.told))
