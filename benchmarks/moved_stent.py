"""Answers for a stent that is moved in a vessel that is known, as panel and page give them.

python benchmarks/moved_stent.py    (a part of `python -m benchmarks.speed`)

Prints the processor time of each answer, s: placed, deployed, measured, certified, the lesions
that it touches. The library is the one that Python finds first.
"""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np

from SDFStentLib.geometry import Precision
from SDFStentLib.plan import Case, Plan, TreatedCase, read_input_files
from SDFStentLib.stent import AtLesion, Stent

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
OFFSETS = (-14.0, -12.0, -8.0, -4.0, -2.0, 0.5, 2.0, 3.0)
"""Places of the stent along the left artery, mm distal of the middle of its lesion."""


def main() -> None:
    files = (DATA / f"su0243_{name}_mm.vtp" for name in ("surface", "centerline"))
    vessel = read_input_files(*(str(file) for file in files), "mm").vessel
    lesions = vessel.lesions
    vessel.preview.prepare()
    seconds = []
    for offset in (0.0, *OFFSETS):
        start = time.process_time()
        stent = Stent(6.0, placement=AtLesion(1, offset), length=34.0)
        case = Case(vessel, Plan(stents=(stent,)), precision=Precision(dtype=np.float32))
        answer = TreatedCase(vessel, case.treatment().result, lesions)
        _ = answer.told
        seconds.append(time.process_time() - start)
    print(json.dumps(seconds[1:]))  # the first one also makes what is kept


if __name__ == "__main__":
    main()
