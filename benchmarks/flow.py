"""Pressures of the network against the Navier-Stokes equations, and the time that they take.

python -m benchmarks.flow [--quick]

Stenosed tubes (6 mm, a raised cosine of 16 mm): against an axisymmetric reference that is solved
here where scikit-fem is installed. The arch and the patient: against values that were solved once.
"""

from __future__ import annotations

import importlib.util
import time

import numpy as np

from SDFStentLib.flow import FlowModel, Known, Part, SideClues, channels_of, known_flow
from SDFStentLib.plan import flow_answer, flow_model, read_input_files
from SDFStentLib.stent import Stent
from SDFStentLib.treatment import Treatment, placement_at

from .common import Found, markdown, progress, run_alone
from .phantoms import arch_with_coarctation, stenosed_tube
from .sweep import DATA_FOLDER

TUBES = {0.5: (5.0, 10.0), 0.6: (5.0, 10.0), 0.7: (2.0, 5.0)}
"""Flows, mL/s, by narrowing; none of them helped to choose a constant."""

HALF, BEYOND, FINEST = 11.0, 600.0, 0.3
"""Half the measured part, distance at which pressure has recovered, and finest element, mm."""

SOLVED = {
    "arch with coarctation, 30 mL/s: static over the stented length": 4.08,
    "left pulmonary artery, 8.34 mL/s: total over its stent, with what its jet loses": 6.60,
    "the same with a stent of 6.0 mm, at the same flow: total over its ends": 0.71,
}
"""Drops, mmHg, of the arch and the artery as docs/flow.md has them, by finer methods than the
network."""


def tube_rows(depth: float, flows: tuple[float, ...]) -> list[Found]:
    from .axisymmetric import VISCOSITY, pressures, stations

    progress(f"tube of {100 * depth:.0f} %")
    middle = 60.0

    def radius(z: np.ndarray) -> np.ndarray:
        return 3 * (1 - depth / 2 * (1 + np.cos(np.pi * np.clip((z - middle) / 8, -1, 1))))

    along = stations(middle, 8.0, middle + HALF + BEYOND, FINEST)
    solved = pressures(along, radius, list(flows))
    made = stenosed_tube(3.0, 3.0 * (1 - depth), 200.0, 0.5)
    channels = channels_of(made.surface, made.centerline)
    line = channels[0].points[np.abs(channels[0].along - 100) <= HALF]
    rows = []
    for flow, pressure in zip(flows, solved, strict=True):
        ends = np.interp([middle - HALF, middle + HALF + BEYOND], along, pressure)
        # The drop of the healthy vessel behind is not that of the narrowing.
        healthy = 8 * VISCOSITY * 1e-6 * flow / (np.pi * 3e-3**4) * 1e-3 * BEYOND / 133.322
        reference = float(ends[0] - ends[1] - healthy)
        answer = FlowModel(channels, known_flow(flow)).answer(None, [Part("throat", line)])
        drop = answer.before["mean"].drops[0].recovered
        name = f"tube of {100 * depth:.0f} %, {flow:g} mL/s: recovered"
        rows.append({"name": name, "reference": reference, "network": list(drop)})
    return rows


def patient() -> tuple[list[tuple[float, ...]], float]:
    """Drops in the left artery before and after, and the processor time of an answer, ms."""
    files = (DATA_FOLDER / f"su0243_{one}_mm.vtp" for one in ("surface", "centerline"))
    vessel = read_input_files(*map(str, files), "mm").vessel
    known = Known(2500 / 60, inlet=38.0, wedge=10.0, split_right=0.8)
    model = flow_model(vessel, known, "LPS")
    assert vessel.lesions
    assert vessel.centerline is not None
    place = placement_at(vessel.lesions[0], vessel.centerline, 34.0, 0.0)
    stent = Stent(6.0, placement=place, length=34.0)
    treatment = Treatment(vessel.surface, (stent,), vessel.centerline)
    for _ in treatment:
        pass
    times = []
    for _ in range(7):
        start = time.process_time()
        answer = flow_answer(model, vessel, treatment.result)
        times.append(1e3 * (time.process_time() - start))
    # At the same flow as before, as it was solved.
    assert treatment.result.centerline is not None
    after = vessel.followed.after(treatment.result.centerline, treatment.result.surface)
    part = Part("stent", treatment.result.final_stents[0].axis.points)
    same = FlowModel(after, known, SideClues("LPS")).answer(None, [part])
    drops = [one.before["mean"].drops[0].recovered for one in (answer, same)]
    return [tuple(one) for one in drops], min(times)


def measured(quick: bool, _largest: int | None = None) -> Found:
    rows = []
    if importlib.util.find_spec("skfem"):
        for depth, flows in list(TUBES.items())[: 1 if quick else None]:
            rows += tube_rows(depth, flows[: 1 if quick else None])
    if quick:
        return {"rows": rows, "ms": None}
    made = arch_with_coarctation()
    channels = channels_of(made.surface, made.centerline)
    near = np.linalg.norm(channels[0].points - made.throat.point, axis=1) <= 15
    answer = FlowModel(channels, known_flow(30.0)).answer(
        None, [Part("", channels[0].points[near])]
    )
    progress("patient")
    drops, ms = patient()
    found = [answer.before["mean"].drops[0].maximal, *drops]
    for (name, reference), drop in zip(SOLVED.items(), found, strict=True):
        rows.append({"name": name, "reference": reference, "network": list(drop)})
    return {"rows": rows, "ms": ms}


def table(found: Found) -> str:
    cells = []
    for row in found["rows"]:
        value, low, high = row["network"]
        reference = row["reference"]
        is_in = "yes" if low <= reference <= high else "no"
        away = f"{100 * (value / reference - 1):+.0f} %"
        cells.append(
            [row["name"], f"{reference:.2f}", f"{value:.2f}", away, f"{low:.2f}-{high:.2f}", is_in]
        )
    header = ["drop, mmHg", "reference", "network", "away", "range", "within"]
    text = markdown(header, cells)
    if found["ms"] is None:
        return text
    return f"{text}\n\nAfter a full answer: {found['ms']:.0f} ms of the processor."


if __name__ == "__main__":
    run_alone(__doc__.splitlines()[0], measured, table)
