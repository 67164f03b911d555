"""The command line: what it writes, what it says, and how it ends."""

import hashlib
import json
import os
import re
import shutil
import signal
import sys
import time
from base64 import b64encode
from dataclasses import fields
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pytest
from child_processes import COMMAND, PATIENCE, PROJECT, begun, ended
from polydata_cases import read_by_vtk
from tube_files import PLACE, deploy, write_line, write_tube, write_vessel, write_wall
from vtkmodules.util.numpy_support import vtk_to_numpy

import SDFStentLib.cli.demo
import SDFStentLib.cli.deploy
from benchmarks.phantoms import branching_pulmonary_artery, stenosed_tube
from SDFStentLib.cli import main
from SDFStentLib.cli.console import Console
from SDFStentLib.cli.option_table import path as path_of_option
from SDFStentLib.cli.options import parser
from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import (
    encode_vtp,
    polydata_from_arrays,
    polydata_from_lines,
    read_surface,
    set_face_names,
)
from SDFStentLib.parameter import parameters_of
from SDFStentLib.plan import StepFiles, load_plan, run_plan
from SDFStentLib.validation import DeploymentError


def cell_array(path, name):
    return vtk_to_numpy(read_by_vtk(Path(path)).GetCellData().GetArray(name))


@pytest.fixture(scope="module")
def deployed(tmp_path_factory):
    """The tube's folder with a stented tube and the plan of it."""
    folder = tmp_path_factory.mktemp("deployed")
    write_tube(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert deploy("--save-plan", "p.json", "--quiet") == 0
    return folder


@pytest.fixture
def a_plan(deployed, tmp_path, monkeypatch):
    """A copy of that folder, to work in."""
    monkeypatch.chdir(tmp_path)
    return shutil.copytree(deployed, tmp_path, dirs_exist_ok=True)


def left_over(folder):
    return {name for name in os.listdir(folder) if name not in {"tube.vtp", "line.vtp", "axis.vtp"}}


def test_deploy_writes_every_output_and_says_what_came_of_it(a_folder, capsys):
    code = deploy(
        "--output-centerline", "moved.vtp", "--report", "r.json", "--report", "r.html",
        "--figure", "f.png", "--picture", "v.png", "--steps", "steps", "--arrays",
        "--save-plan", "p.json",
    )  # fmt: skip
    said = capsys.readouterr()
    assert code == 0
    assert left_over(a_folder) == {
        "out.vtp", "moved.vtp", "r.json", "r.html", "f.png", "v.png", "steps", "p.json"
    }  # fmt: skip
    assert "prescribed 6 mm" in said.out
    page = Path("r.html").read_text(encoding="utf-8")
    assert b64encode(Path("v.png").read_bytes()).decode() in page
    assert "Surface certified for meshing: it is watertight" in said.out
    report = json.loads(Path("r.json").read_text(encoding="utf-8"))
    along = report["stents"][0]["diameters"]["along"]
    assert np.mean(along["mis_after_mm"]) == pytest.approx(6.0, rel=0.01)
    assert min(along["mis_before_mm"]) < 3.7  # the throat, 3.6 mm
    assert set(report["timings"]) >= {"read_s", "setup_s", "deploy_s", "certify_s", "write_s"}
    np.testing.assert_array_equal(
        cell_array("out.vtp", "ModelFaceID"), cell_array("tube.vtp", "ModelFaceID")
    )
    assert len(cell_array("out.vtp", "AreaStretch")) == report["inputs"][0]["triangles"]
    assert re.findall(
        r'file="(step_0000\.vtp)"', Path("steps/steps.pvd").read_text(encoding="utf-8")
    )


def assert_hashed(plan: str) -> None:
    """The plan has the hash of every file that it names."""
    document = json.loads(Path(plan).read_text(encoding="utf-8"))
    axes = [stent["placement"].get("axis") for stent in document["stents"]]
    files = [document["inputs"]["surface"], document["inputs"]["centerline"], *axes]
    assert any(files)
    for file in filter(None, files):
        data = (Path(plan).parent / file["file"]).read_bytes()
        assert file["sha256"] == hashlib.sha256(data).hexdigest()


def test_the_same_plan_gives_the_same_file_from_the_shell_and_from_python(a_plan):
    assert main(["run", "p.json", "-o", "again", "--quiet"]) == 0
    assert left_over(a_plan / "again") == {
        "tube_stented.vtp", "line_stented.vtp", "report.json", "report.html", "plan.json"
    }  # fmt: skip
    assert Path("out.vtp").read_bytes() == Path("again/tube_stented.vtp").read_bytes()
    assert load_plan("again/plan.json") == load_plan("p.json")
    assert_hashed("again/plan.json")
    written = read_surface("out.vtp", "cm").points
    result = run_plan(load_plan("p.json"))
    stored = result.inputs.surface.as_stored(result.treatment.points)
    np.testing.assert_allclose(written, stored, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("place", "line"),
    [
        (["--distal", "0", "0", "2.9", "--length", "20"], "line.vtp"),
        (["--proximal", "0", "0", "1.1", "--length", "20"], "line.vtp"),
        (["--from", "0", "0", "1.1", "--to", "0", "0", "2.9"], "line.vtp"),
        (["--from", "0", "0", "2.9", "--to", "-1e-3", "0", "1.1"], "line.vtp"),
        (["--from", "0", "-0.", "2.9", "--to", "-1.e-3", "0", "1.1"], "line.vtp"),
        (["--axis", "axis.vtp"], None),
        (["--axis", "axis.vtp", "--length", "15"], "line.vtp"),
    ],
)
def test_every_way_to_say_where_opens_the_throat(a_folder, place, line, capsys):
    assert deploy(place=place, line=line) == 0
    found = re.search(r"Minimum lumen diameter: ([\d.]+) -> ([\d.]+) mm", capsys.readouterr().out)
    assert float(found[1]) < 3.7
    assert float(found[2]) > 5.8  # edges of 1 mm cut 3 % off the circle at the stent's ends


def test_steps_can_be_thinned_out_and_replaced_but_nothing_else_is(a_folder, capsys):
    assert deploy("--steps", "all", "--step", "0.1", "--quiet") == 0
    assert deploy("--steps", "few", "--every", "1", "--step", "0.1", "--quiet") == 0
    assert 2 <= len(os.listdir("few")) < len(os.listdir("all"))
    assert deploy("--steps", "few", "--quiet") == 0
    Path("few/mine.txt").touch()
    assert deploy("--steps", "few") == 2
    assert "expected a new or empty folder, got one that holds mine.txt" in capsys.readouterr().err
    assert StepFiles.is_own("step_0003.vtp")


def test_quiet_says_nothing_and_warnings_go_to_stderr(a_folder, capsys):
    assert deploy("--quiet") == 0
    assert capsys.readouterr() == ("", "")
    assert deploy("--verbose", diameter="3") == 0
    said = capsys.readouterr()
    assert "warning: The stent hangs free over" in said.err
    assert "warning: Nothing moves: the stent of 3 mm is not wider" in said.err
    assert deploy("--shortened", place=[*PLACE[:4], "--length", "200"]) == 0
    assert "The stent is shortened: 180.0 mm were prescribed, 40.0" in capsys.readouterr().err


@pytest.fixture
def a_bent_fork(tmp_path, monkeypatch):
    """A forked vessel, its centerline and a bent axis, mm."""
    vessel = branching_pulmonary_artery()
    write_vessel(tmp_path, vessel, "fork.vtp", "lines.vtp", per_mm=1)
    corner = polydata_from_lines(
        [vessel.axis_at(20)[0] + shift for shift in ([0, 0, -4], [0, 0, 0], [0, 4, 1])],
        [np.arange(3)],
    )
    (tmp_path / "corner.vtp").write_bytes(encode_vtp(corner))
    monkeypatch.chdir(tmp_path)
    return [f"{value:.4f}" for value in vessel.axis_at(19)[0]]


def test_the_command_line_adds_its_options_to_the_sentences_of_the_library(a_bent_fork, capsys):
    base = ["deploy", "fork.vtp", "--diameter", "7.5", "-o", "o.vtp", "--save-plan", "p.json"]
    place = ["--centerline", "lines.vtp", "--proximal", *a_bent_fork, "--length", "20"]
    main([*base, *place, "--report", "r.json"])
    assert "place it between two points (--from, --to) to choose" in capsys.readouterr().err
    told = " ".join(json.loads(Path("r.json").read_text(encoding="utf-8"))["warnings"])
    assert "place it between two points to choose another one." in told
    main(["measure", "fork.vtp", *place])
    assert "between two points (--from, --to)" in capsys.readouterr().err
    main(["run", "p.json", "-o", "again"])  # has no such option: the plan says where
    assert "place it between two points to choose" in capsys.readouterr().err
    main([*base, "--axis", "corner.vtp", "--verbose"])
    assert "straighten the axis (--straighten F)." in capsys.readouterr().err


def test_the_command_line_says_how_to_name_a_unit_and_to_accept_a_changed_file(a_plan, capsys):
    main(["deploy", "tube.vtp", "--diameter", "0.6", "--axis", "axis.vtp", "-o", "o.vtp"])
    assert "the unit of the file (--units mm, cm or m) if it" in capsys.readouterr().err
    Path("line.vtp").write_bytes(Path("axis.vtp").read_bytes())
    capsys.readouterr()
    assert main(["run", "p.json", "-o", "again"]) == 2
    assert "accept the changed one (--accept-changed-inputs)" in capsys.readouterr().err


def test_a_full_disk_leaves_the_old_files_and_nothing_else(a_folder, capsys, monkeypatch):
    Path("out.vtp").write_text("old", encoding="utf-8")

    def full(report, path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(SDFStentLib.cli.deploy, "write_report", full)
    assert deploy("--report", "r.json") == 2
    assert "r.json: cannot be written (No space left on device)" in capsys.readouterr().err
    assert Path("out.vtp").read_text(encoding="utf-8") == "old"
    assert left_over(a_folder) == {"out.vtp"}


def test_an_interruption_leaves_nothing_and_gives_130(a_folder, capsys, monkeypatch):
    def interrupted(report, path):
        raise KeyboardInterrupt

    monkeypatch.setattr(SDFStentLib.cli.deploy, "write_report", interrupted)
    assert deploy("--report", "r.json", "--steps", "steps") == 130
    assert "interrupted; nothing was written" in capsys.readouterr().err
    assert left_over(a_folder) == set()
    Path("p.json").unlink(missing_ok=True)
    monkeypatch.undo()


def test_an_unexpected_error_is_one_sentence_and_debug_shows_where(a_folder, capsys, monkeypatch):
    monkeypatch.setattr(SDFStentLib.cli.deploy, "write_report", lambda *_: 1 / 0)
    assert deploy("--report", "r.json") == 1
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert "unexpected error (ZeroDivisionError: division by zero). Run it again with" in said
    assert deploy("--report", "r.json", "--debug") == 1
    assert "Traceback" in capsys.readouterr().err
    assert left_over(a_folder) == set()


def test_measure_prints_a_table_or_json(a_folder, capsys):
    assert (
        main(["measure", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", "--tables"]) == 0
    )
    said = capsys.readouterr().out
    title = "Branch 1 of 6.0 mm from 0 mm on (1 outlet)"
    assert f"{title}: 40.0 mm, from (0, 0, 0) to (0, 0, 4) cm" in said
    rows = [line.split() for line in said.splitlines() if re.match(r"\s+\d+\.\d\s", line)]
    throat = min(rows[5:-5], key=lambda row: float(row[1]))  # caps are nearer at the ends
    assert float(throat[0]) == pytest.approx(20)
    assert float(throat[1]) == pytest.approx(3.6, abs=0.1)  # facets lie inside the circle
    base = ["measure", "tube.vtp", "--units", "cm", "--json"]
    for more in (["--centerline", "line.vtp", *PLACE], ["--axis", "axis.vtp"]):
        assert main([*base, *more]) == 0
        document = json.loads(capsys.readouterr().out)
        assert document["lines"][0]["minimum_mm"] == pytest.approx(3.6, abs=0.1)


def test_check_tells_sound_surfaces_from_others(a_folder, capsys):
    assert main(["check", "tube.vtp", "--units", "cm"]) == 0
    assert "The surface is watertight and has no self-intersection." in capsys.readouterr().out
    vessel = stenosed_tube(edge_length=1.0)
    points = vessel.points.copy()
    points[np.argmin(np.abs(points[:, 2] - 20) - points[:, 0] * 1e-6)] += (40.0, 0, 0)
    crossed = np.where(np.arange(len(points))[:, None] % 50 == 3, -points, points)
    write_wall(Path("bad.vtp"), crossed, vessel.triangles)
    assert main(["check", "bad.vtp", "--json"]) == 3
    document = json.loads(capsys.readouterr().out)
    assert document["self_intersecting_triangles"]
    assert main(["check", "bad.vtp", "--units", "m"]) == 3
    said = capsys.readouterr().out
    assert "intersect another one" in said
    assert re.search(r" turned over near \(.*\) mm \(in the file .* m\)\.", said)
    assert main(["check", "bad.vtp", "--quiet"]) == 3
    assert capsys.readouterr().out == ""


def test_without_opengl_the_report_comes_and_a_picture_is_refused_at_once(
    a_folder, monkeypatch, capsys
):
    import SDFStentLib.report.picture.painting as painting

    monkeypatch.setattr(painting, "PROGRAM", "raise SystemExit('no OpenGL here')")
    assert deploy("--report", "r.html") == 0
    said = capsys.readouterr().err
    assert said.count("The picture could not be rendered: VTK's process ended with code 1") == 1
    assert "This page has no picture" in Path("r.html").read_text(encoding="utf-8")
    for option in ("--picture", "--figure"):
        before = left_over(a_folder)
        assert deploy(option, "x.png", out="other.vtp") == 2
        assert "it said: no OpenGL here" in capsys.readouterr().err
        assert left_over(a_folder) == before
    assert deploy("--figure", "x.svg", out="other.vtp") == 0


def test_an_axis_alone_tells_the_branches_that_the_stent_covers(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = branching_pulmonary_artery()
    surface = polydata_from_arrays(
        made.points, made.triangles, cell_arrays={"ModelFaceID": made.face_ids}
    )
    set_face_names(surface, made.faces.names)
    for name, positions in (("across", (14, 30)), ("distal", (50, 58))):
        points = made.axis_at(np.linspace(*positions, 30))
        write_line(Path(f"{name}.vtp"), points)
    Path("artery.vtp").write_bytes(encode_vtp(surface))
    for axis, words in (
        ("across", "1 covered: right pulmonary artery (fully)"),
        ("distal", "No side branch was found within 10 mm of the stent."),
    ):
        options = ["--diameter", "8", "--axis", f"{axis}.vtp", "--report", f"{axis}.json"]
        main(["deploy", "artery.vtp", *options, "-o", "out.vtp"])
        assert words in capsys.readouterr().out
    report = json.loads(Path("across.json").read_text(encoding="utf-8"))
    (branch,) = report["branches"]
    assert (branch["name"], round(branch["percent_covered"])) == ("right pulmonary artery", 100)
    assert branch["lumen_before_mm"] > 0
    assert json.loads(Path("distal.json").read_text(encoding="utf-8"))["branches"] == []


def test_the_demo_names_its_files_where_they_are_and_leaves_no_empty_picture(
    tmp_path, monkeypatch, capsys
):
    def no_opengl(path, *_, **__):
        raise DeploymentError("The picture needs an OpenGL library.")

    monkeypatch.setattr(SDFStentLib.cli.demo, "before_after_picture", no_opengl)
    monkeypatch.chdir(tmp_path)
    Path("demo").mkdir()
    Path("demo/before_after.png").write_bytes(b"of an earlier demo")
    assert main(["demo", "-o", "demo", "--verbose"]) == 0
    said = capsys.readouterr()
    assert "warning: The picture needs an OpenGL library." in said.err
    assert "before_after.png" not in said.out
    report = json.loads(Path("demo/report.json").read_text(encoding="utf-8"))
    # A plan to sign: nothing is warned of but the picture, and that the lesion begins before it.
    (uncovered,) = report["warnings"]
    assert "Lesion 1 is not wholly covered: 1.4 of its 10.8 mm" in str(uncovered)
    assert said.err.count("warning:") == 2
    assert not Path("demo/before_after.png").exists()
    inputs = json.loads(Path("demo/report.json").read_text(encoding="utf-8"))["inputs"]
    for entry, name in zip(inputs, ("surface.vtp", "centerline.vtp"), strict=True):
        assert Path(entry["file"]) == Path("demo") / name
        assert hashlib.sha256(Path(entry["file"]).read_bytes()).hexdigest() == entry["sha256"]
    page = Path("demo/report.html").read_text(encoding="utf-8")
    assert str(Path("demo/surface.vtp")) in page
    assert "no picture of the vessel. The picture needs an OpenGL library." in page
    plan = load_plan("demo/plan.json")
    assert plan.surface.path == os.path.abspath("demo/surface.vtp")


def test_usage_is_explained(capsys):
    for arguments, code, words in (
        (["--help"], 0, "Exit codes"),
        (["deploy", "--help-all"], 0, "--foreshortening"),
        (["--version"], 0, "sdfstent 0."),
        ([], 2, "arguments are required: COMMAND"),
        (["treat"], 2, "invalid choice: 'treat'"),
        (["deploy"], 2, "arguments are required"),
    ):
        assert main(arguments) == code
        said = capsys.readouterr()
        assert words in said.out + said.err
        assert (code == 0) == (said.err == "")


def parsers():
    """Every parser by the name of its command; the empty name is the top."""
    top = parser()
    (commands,) = (action for action in top._actions if action.dest == "command")
    return {"": top, **commands.choices}


def of_text(its_parser):
    """The options and arguments of a parser that take any text."""
    return [
        action
        for action in its_parser._actions
        if action.nargs != 0 and not action.choices and action.type is path_of_option
    ]


def test_an_empty_name_is_refused_and_writes_nothing(a_plan, capsys):
    before = sorted(os.listdir(a_plan))
    tube, line = ["tube.vtp", "--units", "cm"], ["--centerline", "line.vtp"]
    whole = {
        "deploy": [*tube, *line, "--diameter", "6", *PLACE, "-o", "new.vtp"],
        "run": ["p.json", "-o", "new"],
        "measure": [*tube, *line],
        "check": tube,
        "demo": ["-o", "new"],
    }
    refused = []
    for command, arguments in whole.items():
        for action in of_text(parsers()[command]):
            name = "/".join(action.option_strings) or action.metavar
            given = [*arguments, name.split("/")[-1], ""] if action.option_strings else [""]
            given += [] if action.option_strings else arguments[1:]
            assert main([command, *given]) == 2, (command, name)
            said = capsys.readouterr()
            assert said.out == ""
            assert said.err == (
                f"sdfstent {command}: argument {name}: expected a file or folder, got nothing; "
                f"see sdfstent {command} --help.\n"
            )
            refused.append(name)
    assert sorted(os.listdir(a_plan)) == before
    assert refused.count("-o/--output") == 3
    assert {"--axis", "--centerline", "--figure", "--steps", "--report"} <= set(refused)
    assert {"--output-centerline", "--save-plan", "SURFACE", "PLAN"} <= set(refused)


def test_the_manual_has_every_option_and_every_choice():
    manual, method = (
        (PROJECT / "docs" / name).read_text(encoding="utf-8") for name in ("cli.md", "method.md")
    )
    for command, its_parser in parsers().items():
        assert f"sdfstent {command}".strip() in manual
        for action in its_parser._actions:
            for option in action.option_strings:
                if option != "-h":
                    assert re.search(rf"{option}(?![\w-])", manual), (command, option)
            if action.option_strings:
                for choice in action.choices or ():
                    assert re.search(rf"[`| ]{choice}[`|,]", manual + method), (command, choice)


def test_the_manual_names_the_settings_without_an_option(a_folder):
    changed = {
        "--influence": "5", "--smoothing": "0.3", "--capsule": "2", "--tissue-gap": "0.7",
        "--step": "0.5", "--falloff": "cosine", "--blend": "quadratic", "--rule": "published",
        "--smooth-axis": "1",
    }  # fmt: skip
    more = [word for pair in changed.items() for word in pair]
    assert deploy(*more, "--no-compensation", "--save-plan", "p.json", "--quiet") == 0
    found = load_plan("p.json").settings
    assert found.tissue_gap == 0.7
    same = {
        field.name
        for field in fields(found)
        if getattr(found, field.name) == getattr(DeploymentSettings(), field.name)
    }
    assert {name for name, option in options_of_the_method().items() if not option} == same


def options_of_the_method() -> dict[str, str]:
    """The option of each setting, as the table of the method document has it."""
    method = (PROJECT / "docs" / "method.md").read_text(encoding="utf-8")
    table = method.partition("## Defaults")[2].partition("\n## ")[0]
    found: dict[str, str] = {}
    for names, options in re.findall(r"^\| (`[^|]+) \|[^|]+\|([^|]*)\|", table, flags=re.M):
        its_names, its_options = re.findall(r"\w+", names), re.findall(r"--[\w-]+", options)
        found |= zip_longest(its_names, its_options, fillvalue="")
    return found


def test_the_method_document_has_the_option_of_every_setting():
    documented = options_of_the_method()
    for name, one in parameters_of(DeploymentSettings).items():
        assert documented[name] == (f"--{one.option}" if one.option else ""), name


def test_a_bar_is_drawn_on_a_terminal_only_and_wiped(monkeypatch, capsys):
    with Console().progress("Deploying") as show:
        show(0.5, "x")
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with Console().progress("Deploying") as show:
        show(0.5, "diameter 4.0 mm")
    drawn = capsys.readouterr().err
    assert "50 % diameter 4.0 mm" in drawn
    assert drawn.endswith(" \r")


@pytest.mark.skipif(os.name == "nt", reason="no such signal there")
def test_control_c_leaves_nothing_half_written(a_folder):
    process = begun(
        COMMAND, "deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", *PLACE,
        "--diameter", "6", "-o", "out.vtp", "--step", "0.0005", "--rule", "published",
        folder=a_folder, env={**os.environ, "PYTHONPROFILEIMPORTTIME": "1"},
    )  # fmt: skip
    # Python tells of every import on stderr: with this one the command has begun.
    assert any("deformation.event_steps" in line for line in process.stderr)
    time.sleep(1.0)  # files are read, and the first of thousands of steps are done
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "interrupted; nothing was written" in err
    assert left_over(a_folder) == set()


def test_a_reader_that_has_seen_enough_is_no_error(a_folder):
    words = ["measure", "tube.vtp", "--units", "cm", "--axis", "axis.vtp"]
    process = begun(COMMAND, *words, folder=a_folder)
    process.stdout.close()
    process.wait(timeout=PATIENCE)
    assert process.returncode == 0
    assert "Traceback" not in process.stderr.read()


def test_real_anatomies_get_their_diameter_in_every_centerline_form(data_dir, tmp_path, capsys):
    pulmonary = ["2.7157", "-5.4259", "6.7086"]
    for surface, line, units, center, diameter in (
        ("pulmonary_surface_cm", "pulmonary_centerline_cm", "cm", pulmonary, 20),
        ("vmtk_aorta_surface_mm", "vmtk_aorta_centerline_mm", "mm", ["221.9", "142.7", "23.6"], 18),
        (
            "vmtk_aorta_surface_mm", "vmtk_aorta_centerline_branches_mm", "mm",
            ["221.9", "142.7", "23.6"], 18,
        ),
    ):  # fmt: skip
        code = main(
            ["deploy", f"{data_dir}/{surface}.vtp", "--units", units,
             "--centerline", f"{data_dir}/{line}.vtp", "--center", *center,
             "--length", "25", "--diameter", str(diameter), "-o", f"{tmp_path}/out.vtp"]
        )  # fmt: skip
        found = re.search(r"-> ([\d.]+) mm, prescribed", capsys.readouterr().out)
        assert code == 0
        assert float(found[1]) == pytest.approx(diameter, rel=0.01)


@pytest.mark.skipif(os.name == "nt", reason="closes streams with a POSIX shell")
def test_a_closed_stream_is_no_reason_to_fail(a_folder):
    command = [COMMAND, "deploy", "tube.vtp", "--units", "cm", "--centerline", "line.vtp", *PLACE]
    command += ["--diameter", "6", "-o", "out.vtp"]
    done = ended(begun("sh", "-c", '"$@" >&- 2>&-', "sh", *command, folder=a_folder))
    assert done.returncode == 0
    assert left_over(a_folder) == {"out.vtp"}


@pytest.mark.skipif(os.name == "nt", reason="names are text there")
def test_a_file_whose_name_is_no_text_can_be_treated_and_reported(a_folder):
    odd = os.fsdecode(b"\xe9.vtp")
    os.rename("tube.vtp", odd)
    assert (
        deploy("--report", "r.json", "--report", "r.html", "--save-plan", "p.json", surface=odd)
        == 0
    )
    report = json.loads(Path("r.json").read_text("utf-8"))
    assert report["inputs"][0]["file"].endswith(odd)
    assert main(["run", "p.json", "-o", "again"]) == 0
    assert os.fsdecode(b"\xe9_stented.vtp") in os.listdir("again")
