"""Lines of one vessel in any order and direction: the commands tell and do the same."""

import json
from itertools import pairwise

import numpy as np
import pytest
from seeds import seeds
from test_line_ends import a_tree, written

from SDFStentLib.cli import main

STENT = [
    "--proximal",
    "0",
    "0",
    "20",
    "--length",
    "12",
    "--diameter",
    "13",
    "--foreshortening",
    "0",
]
"""In the trunk; downstream is +z."""


def pieces():
    """The lines between ends and junctions, each once."""
    lines = [[tuple(point) for point in line.tolist()] for line in a_tree().lines]
    found = {}
    for line in lines:
        shared = [sum(point in other for other in lines) for point in line]
        for first, last in pairwise([0, *np.flatnonzero(np.diff(shared)), len(line) - 1]):
            found[line[first + 1]] = np.array(line[first : last + 1])
    return list(found.values())


def answers(capsys):
    """What `measure`, `flow` and `deploy` tell, and the surface with the stent as it is written."""
    line = ["wall.vtp", "--centerline", "lines.vtp"]
    assert main(["measure", *line, "--json"]) == 0
    measured = json.loads(capsys.readouterr().out)
    assert main(["flow", *line, "--mean-flow", "3L/min", "--json", "flow.json", "--quiet"]) == 0
    deploy = ["deploy", *line, *STENT, "-o", "out.vtp", "--report", "out.json", "--quiet"]
    assert main(deploy) in (0, 3)
    with (
        open("flow.json", "rb") as flow,
        open("out.vtp", "rb") as out,
        open("out.json", "rb") as report,
    ):
        axis = json.load(report)["stents"][0]["axis"]
        return measured, json.load(flow), axis, out.read()


def without_files(document):
    """What stays the same: neither hashes of files nor times."""
    left_out = ("sha256", "seconds", "created", "inputs", "date", "command")
    if isinstance(document, dict):
        return {k: without_files(v) for k, v in document.items() if k not in left_out}
    return [without_files(one) for one in document] if isinstance(document, list) else document


@pytest.mark.parametrize("seed", seeds(1, 12))
def test_every_order_and_direction_has_the_same_root_names_lesions_flow_and_stent(
    tmp_path, monkeypatch, capsys, seed
):
    monkeypatch.chdir(tmp_path)
    random = np.random.default_rng(seed)
    parts = pieces()
    assert len(parts) == 7
    written(tmp_path, parts)
    first = answers(capsys)
    (lesion,) = first[0]["lesions"]
    assert np.linalg.norm(np.subtract(lesion["place_mm"], a_tree().throat)) < 2
    start, end = (first[2][name][2] for name in ("start_mm", "end_mm"))
    assert (start, end) == pytest.approx((20, 32), abs=1)
    for _ in range(2):
        turned = [part[::-1] if random.random() < 0.5 else part for part in parts]
        written(tmp_path, [turned[n] for n in random.permutation(len(parts))])
        again = answers(capsys)
        assert without_files(list(again[:3])) == without_files(list(first[:3]))
        assert again[3] == first[3]
