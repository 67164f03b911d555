"""What the command says of a deployment and of a vessel: little, what matters first."""

import json
import re
from pathlib import Path

import pytest
from tube_files import deploy

from SDFStentLib.cli import main

SU0243 = ["su0243_surface_mm.vtp", "--centerline", "su0243_centerline_mm.vtp"]


def of(data_dir, words):
    return [str(data_dir / word) if word.endswith(".vtp") else word for word in words]


@pytest.mark.parametrize(
    ("more", "first"),
    [
        ([], "18.0 mm (20 mm as packed, 10 % shorter once expanded: the usual share, assumed"),
        (["--foreshortening", "0.0661765"], "18.7 mm (20 mm as packed, 6.62 % shorter once expan"),
        (["--foreshortening", "0"], "20.0 mm.\n"),
    ],
)
def test_the_first_line_says_both_lengths_and_why(a_folder, capsys, more, first):
    """44 mm became 39.6 without a word."""
    place = ["--center", "0", "0", "2", "--length", "20"]
    assert deploy(*more, "--report", "r.json", "--report", "r.html", place=place) == 0
    assert capsys.readouterr().out.startswith(f"Deployed: stent of 6 x {first}")
    stent = json.loads(Path("r.json").read_text(encoding="utf-8"))["stents"][0]
    page = Path("r.html").read_text(encoding="utf-8")
    assert ("(20 mm as packed, " in page) == (stent["foreshortening_fraction"] > 0)
    assert stent["foreshortening_reason"] in page


def assert_no_words_lie_on_others(svg):
    """A letter is about half as wide as it is high."""
    boxes = []
    for words in re.finditer(r"<text ([^>]*)>([^<]*)</text>", svg):
        given = dict(re.findall(r"([\w-]+)=['\"]([^'\"]*)", words[1]))
        if "transform" in given or "stroke" in given:  # upright, or the white below words
            continue
        size, x, y = (float(given[key]) for key in ("font-size", "x", "y"))
        width = 0.55 * size * len(words[2])
        left = x - width * ("start", "middle", "end").index(given["text-anchor"]) / 2
        boxes.append((left, left + width, y - 0.7 * size, y))
    assert len(boxes) > 10
    for number, (left, right, top, low) in enumerate(boxes):
        for start, end, high, floor in boxes[:number]:
            assert not (start < right and left < end and high < low and top < floor)


@pytest.mark.parametrize(("more", "count"), [([], 0), (["--flare-end", "9", "4"], 1)])
def test_the_plot_says_once_why_no_sphere_fits_a_flared_end(a_folder, more, count):
    place = ["--center", "0", "0", "2", "--length", "20"]
    assert deploy(*more, "--figure", "f.svg", diameter="7", place=place) == 0
    assert Path("f.svg").read_text(encoding="utf-8").count("the sphere is held by the") == count


def test_a_deployment_in_a_tree_takes_eight_lines_and_all_of_it_more(data_dir, a_folder, capfd):
    place = ["--center", "9.3", "-77.5", "-55.5", "--diameter", "6", "--length", "28"]
    words = ["deploy", *of(data_dir, SU0243), *place, "-o", "out.vtp", "--report", "r.json"]
    assert main([*words, "--figure", "f.svg"]) == 0
    assert_no_words_lie_on_others(Path("f.svg").read_text(encoding="utf-8"))
    said = capfd.readouterr()
    out, err = said.out.splitlines(), said.err.splitlines()
    assert len(out) + len(err) <= 8
    starts = (
        "Deployed: ",
        "Minimum lumen diameter: ",
        "Stenosis",
        "Branches: ",
        "Contact with the wall: ",
        "Surface ",
    )
    assert [line.startswith(start) for line, start in zip(out, starts, strict=False)] == [True] * 6
    assert out[6].startswith("Wrote ")
    warnings = json.loads(Path("r.json").read_text(encoding="utf-8"))["warnings"]
    assert f"And {len(warnings) - len(err)} more: --verbose tells them." in err[-1]


def test_the_demo_and_compared_plans_take_eight_lines_each(a_folder, capfd):
    assert main(["demo", "-o", "demo"]) == 0
    said = capfd.readouterr()
    assert said.out.startswith("Deployed: ")
    assert len(said.out.splitlines()) + len(said.err.splitlines()) <= 8
    plan = Path("demo/plan.json")
    plan.with_name("again.json").write_bytes(plan.read_bytes())
    assert main(["compare", "demo/plan.json", "demo/again.json", "-o", "both"]) == 0
    said = capfd.readouterr()
    lines = said.out.splitlines() + said.err.splitlines()
    for name in ("plan: ", "again: "):
        own = [line for line in lines if line.removeprefix("warning: ").startswith(name)]
        assert own[0].startswith(f"{name}Deployed: ")
        assert 5 <= len(own) <= 7
    assert main(["demo", "-o", "demo", "--verbose"]) == 0
    assert len(capfd.readouterr().out.splitlines()) >= 7


def test_a_tree_is_measured_in_eight_lines(data_dir, capfd):
    assert main(["measure", *of(data_dir, SU0243)]) == 0
    said = capfd.readouterr()
    assert len((said.out + said.err).splitlines()) <= 8
    assert len(said.out.split()) < 250
    assert re.search(r"^\d+ more.*: --verbose tells more", said.out, re.M)
    assert main(["measure", *of(data_dir, SU0243), "--verbose"]) == 0
    assert capfd.readouterr().out.count("Reference: ") > 4


@pytest.mark.parametrize(
    ("words", "nearest"),
    [
        (["deploy", "x", "-o", "y", "--waists", "3"], "deploy --waist"),
        (["deploy", "x", "-o", "y", "--diametr=6"], "deploy --diameter"),
        (["deploy", "x", "-o", "y", "--len", "6"], "deploy --length"),
        (["measure", "x", "--centrline", "y"], "measure --centerline"),
        (["check", "x", "--unit", "cm"], "check --units"),
        (["sweep", "x", "-o", "y", "--worker", "2"], "sweep --workers"),
    ],
)
def test_of_an_unknown_option_the_nearest_and_the_help_of_the_command_are_told(
    capsys, words, nearest
):
    assert main(words) == 2
    command, option = nearest.split()
    said = capsys.readouterr().err
    assert said.startswith(f"sdfstent {command}: unrecognized arguments: ")
    assert said.endswith(f", the nearest option is {option}; see sdfstent {command} --help.\n")


def test_help_tells_what_everyone_needs_and_where_the_rest_is(capsys):
    assert main(["deploy", "--help"]) == 0
    short = capsys.readouterr().out
    assert main(["deploy", "--help-all"]) == 0
    long = capsys.readouterr().out
    assert len(short.splitlines()) < 30
    assert "--help-all" in short
    shown = re.findall(r"^  (?:-o(?: OUT)?, )?(--[\w-]+)", short, re.M)  # Python 3.13 says OUT once
    assert len(shown) == 10
    for option in (*shown, "--foreshortening", "--straighten", "--export-0d"):
        assert len(re.findall(rf"^  .*{option}(?![\w-])", long, re.M)) >= 1
