"""Every command line that the documents show, run once: each command once as the installed one."""

import json
import re
import runpy
import shlex
import shutil
import signal

import numpy as np
import pytest
from child_processes import COMMAND, PATIENCE, PROJECT, begun, installed
from segmentations import FORK, named, voxels, write

from benchmarks.phantoms import branching_pulmonary_artery
from SDFStentLib.files import read_volume
from SDFStentLib.files.formats import encode_vtu

DOCUMENTS = [PROJECT / "README.md", *sorted((PROJECT / "docs").glob("*.md"))]

COMMANDS = (
    *("app", "centerline", "check", "compare", "demo", "deploy"),
    *("devices", "extract", "flow", "measure", "prepare", "run", "simulate", "suggest", "sweep"),
    "views",
)
STENT = (19.0, 41.0)
PLACES = {"--center": 30, "--from": 30, "--to": 45}
"""Along the left branch of the patient of `sdfstent demo`, mm."""

STANDS_FOR = {
    "SURFACE": "surface.vtp",
    "SEGMENTATION": "artery.seg.nrrd",
    "scan.seg.nrrd": "artery.seg.nrrd",
    "--label NAME": "artery",
    "PLAN": "plan.json",
    "PLAN...": "other.json",
    "PLAN.json": "plan.json",
    "NAMES.json": "names.json",
    "SWEEP": "sweep.json",
    "SWEEP.json": "sweep.json",
    "STENTED": "surface_stented.vtp",
    "REPORT.json": "report.json",
    "OUT": "out.vtp",
    "NAME": "generic",
    "D": "7.5",
    "N": "1",
    "R": "1",
    "MM": "1",
    "--axis F": "axis.mrk.json",
    "--centerline F": "centerline.vtp",
    "-o F": "made.vtp",
    "-o PLAN": "proposal.json",
    "-o DIR": "made by {command}",
    "--read DIR": "made by simulate",
    "--status DIR": "made by sweep",
    "--table DIR": "made by sweep",
    "--folder /data/study": "study",
}
"""Words by themselves, or behind an option."""


def command_lines(text: str) -> list[str]:
    """Those in blocks of code, and those within a sentence that have arguments."""
    fence = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)
    blocks = [body for kind, body in fence.findall(text) if kind in ("", "sh")]
    lines = re.sub(r"\s*\\\n\s*", " ", "\n".join(blocks)).splitlines()
    quoted = [
        line for line in re.findall(r"`([^`\n]+)`", fence.sub("", text)) if "COMMAND" not in line
    ]
    found = [
        re.split(r"\s{2,}|\s#", match[1])[0]
        for match in (re.match(r"(?:\.venv/bin/)?(sdfstent .*)", line) for line in lines + quoted)
        if match
    ]
    return [line for line in found if len(line.split()) > 2 or line == "sdfstent devices"]


def variants(command: str) -> list[str]:
    """Without what is in brackets, and with it, once for each of the words to choose from."""
    brackets = re.compile(r"\[([^]]*)\]")
    count = max((len(words.split("|")) for words in brackets.findall(command)), default=0)
    return [brackets.sub("", command), *(with_choice(command, number) for number in range(count))]


def with_choice(command: str, number: int) -> str:
    """What is in brackets, of words to choose from that of this number, or the last one."""
    return re.sub(
        r"\[([^]]*)\]", lambda match: match[1].split("|")[min(number, match[1].count("|"))], command
    )


def arguments_of(command: str) -> list[str]:
    """The words of a command with files and numbers in place of those that stand for them."""
    words = shlex.split(command)[1:]
    found: list[str] = []
    place = [f"{x:.4f}" for x in (0.0, 0.0, 0.0)]
    for before, word in zip(["", *words], words, strict=False):
        if word == "X":
            place = [f"{x:.4f}" for x in branching_pulmonary_artery().axis_at(PLACES[before])[0]]
        value = dict(zip("XYZ", place, strict=True)).get(word, word)
        value = STANDS_FOR.get(f"{before} {word}", STANDS_FOR.get(word, value))
        found.append(value.format(command=words[0]))
    return found


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """The files that the documents name: the patient of the demo, and one with four lesions."""
    place = tmp_path_factory.mktemp("documents")
    done = installed("demo", folder=place)
    assert done.returncode == 0, done.stderr
    made = place / "sdfstent-demo"
    for name, same in (
        ("wall.vtp", "surface.vtp"),
        ("vessel.vtp", "surface.vtp"),
        ("lines.vtp", "centerline.vtp"),
        ("other.json", "plan.json"),
    ):
        shutil.copy(made / same, made / name)
    for name in ("study", "patients"):
        (made / name).mkdir()
    three = runpy.run_path(str(PROJECT / "benchmarks" / "three_plans.py"))
    tree = three["patient"](made / "study", is_phantom=True)
    for path, name in zip(tree[:2], ("artery.vtp", "line.vtp"), strict=True):
        path.rename(made / name)
    vessel = branching_pulmonary_artery()
    write_curve(made / "line.mrk.json", vessel.axis_at(np.arange(0.0, 61.0, 4.0)))
    write_curve(made / "axis.mrk.json", vessel.axis_at(np.linspace(*STENT, 6)))
    for document, name in (("devices.md", "own.json"), ("cli.md", "names.json")):
        text = (PROJECT / "docs" / document).read_text(encoding="utf-8")
        (made / name).write_text(block_of_json(text), encoding="utf-8")
    mask, low = voxels(FORK, 1.1)
    write(made / "artery.seg.nrrd", mask, low, 1.1, texts=named(artery=(1, 0)))
    write_sweep(made / "sweep.json", "sobol")
    write_sweep(made / "cube.json", "latin-hypercube")
    return made


def block_of_json(text):
    """The first one in a document."""
    return re.search(r"```json\n(.*?)```", text, re.S)[1]


def write_curve(path, points):
    """A curve with these control points, as Slicer saves it."""
    control = [{"position": point.tolist()} for point in points]
    curve = {"type": "Curve", "coordinateSystem": "RAS", "controlPoints": control}
    path.write_text(json.dumps({"markups": [curve]}), encoding="utf-8")


def write_sweep(path, method):
    """The first example of the document of cohorts, with two cases."""
    text = (PROJECT / "docs" / "cohorts.md").read_text(encoding="utf-8")
    document = json.loads(block_of_json(text).replace("patient/", ""))
    document["sampling"] |= {"method": method, "count": 2}
    path.write_text(json.dumps(document), encoding="utf-8")


@pytest.fixture
def folder(prepared, tmp_path):
    """A copy of its own for each test."""
    return shutil.copytree(prepared, tmp_path / "documents")


def assert_runs(folder, arguments, run=installed):
    """Exit code 0, and an output where one is named."""
    done = run(*arguments, folder=folder)
    assert done.returncode == 0, (arguments, done.stderr)
    assert done.stdout
    if "-o" in arguments:
        assert (folder / arguments[arguments.index("-o") + 1]).exists(), arguments


def assert_starts_and_ends(folder, arguments, run):
    """A page is offered, on a port that is free, until Ctrl-C; but once no page needs to come."""
    serving = pytest.importorskip("SDFStentApp.serving")
    if run is not installed:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(serving, "serve", lambda settings, _: print(settings.opening))
            return assert_runs(folder, arguments, run)
    process = begun(COMMAND, *arguments, "--no-browser", folder=folder)
    line = process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=PATIENCE)
    assert line.startswith("Open http://"), (arguments, error)
    assert process.returncode == 0, error


def assert_runs_on_a_cluster(folder, arguments, _):
    """A scheduler and a worker within this process."""
    distributed = pytest.importorskip("distributed")
    shutil.rmtree(folder / "made by sweep", ignore_errors=True)  # else nothing is left to do
    small = {"n_workers": 1, "threads_per_worker": 1, "processes": False}
    with distributed.LocalCluster(**small, dashboard_address=None, protocol="tcp") as cluster:
        at = arguments.index("--scheduler") + 1
        arguments[at] = cluster.scheduler_address
        assert_runs(folder, arguments)


def assert_runs_coarsely(folder, arguments, run):
    """Meshes as small as can be, without a solver; its results are those of blood at rest."""
    if "--read" not in arguments:
        return assert_runs(folder, [*arguments, "--coarser", "5", "--no-run"], run)
    for path in (folder / "made by simulate").rglob("mesh-complete.mesh.vtu"):
        volume, _ = read_volume(path)
        count, results = len(volume.points), path.parents[1] / "results"
        rest = {"Velocity": np.zeros((count, 3)), "Pressure": np.zeros(count)}
        results.mkdir()
        data = encode_vtu(volume.points / 10, volume.tetrahedra, rest, {})
        (results / "result_001.vtu").write_bytes(data)
    assert_runs(folder, arguments, run)


OTHERWISE = {
    # Meshes that are fine enough take a minute, and no solver is there.
    "simulate": assert_runs_coarsely,
    # VMTK is made for Python 3.12 and later.
    # Somebody looks at the page as long as they like.
    "app": assert_starts_and_ends,
    # All others run in the folder that it has made.
    "demo": lambda folder, *_: None,
    # No cluster has that address.
    "--scheduler": assert_runs_on_a_cluster,
}
"""Commands that cannot just be run everywhere, why, and how they are run instead."""


SAME = {"-o": 2, "--workers": 2, "--no-run": 1}
"""Options that make no other command, and how many words they are."""


def told(arguments: list[str]) -> str:
    """A command without where its outputs go, and without who carries it out."""
    if not arguments:
        return ""
    count = SAME.get(arguments[0], 0)
    return told(arguments[count:]) if count else f"{arguments[0]} {told(arguments[1:])}"


def commands_by_document() -> dict[str, list[list[str]]]:
    """The arguments of each command with the first document that shows it."""
    first: dict[str, tuple[str, list[str]]] = {}
    for path in DOCUMENTS:
        for line in command_lines(path.read_text(encoding="utf-8")):
            for command in variants(line):
                arguments = arguments_of(command)
                first.setdefault(told(arguments), (path.name, arguments))
    names = [name for name, _ in first.values()]
    return {name: [one for where, one in first.values() if where == name] for name in names}


SHOWN = commands_by_document()
FIRST = [
    next(one for commands in SHOWN.values() for one in commands if one[0] == command)
    for command in COMMANDS
]
"""The first line of every command: what follows needs no process of its own."""


@pytest.mark.parametrize(("document", "commands"), SHOWN.items())
def test_every_command_line_of_the_documents_runs(folder, shell, document, commands):
    for arguments in commands:
        judge = next((OTHERWISE[word] for word in arguments if word in OTHERWISE), assert_runs)
        judge(folder, arguments, installed if arguments in FIRST else shell)


def test_the_documents_show_every_command_in_every_way_to_write_it():
    """What reads them finds them: brackets, commands over two lines, comments, sentences."""
    found = [
        shlex.split(one)
        for path in DOCUMENTS
        for line in command_lines(path.read_text(encoding="utf-8"))
        for one in variants(line)
    ]
    assert {words[1] for words in found} == set(COMMANDS)
    assert len(found) > 40
    for words in (["demo"], ["devices", "NAME"], ["app", "--folder", "patients/"]):
        assert ["sdfstent", *words] in found
    assert any("stented.html" in words for words in found)
    assert not any(word in ("#", "...") for words in found for word in words)


@pytest.mark.parametrize(
    "command",
    [
        "deploy surface.vtp --centerline line.mrk.json --center X Y Z --length 10 --diameter 7.5"
        " -o out.vtp --output-centerline moved.mrk.json",
        "sweep cube.json --dry-run",
    ],
)
def test_curves_and_samples_that_need_more_of_scipy_run(folder, shell, command):
    assert_runs(folder, arguments_of(f"sdfstent {command}"), shell)


def test_curves_serve_every_command(folder, shell):
    for command in (
        "measure surface.vtp --centerline line.mrk.json --axis axis.mrk.json",
        "extract surface.vtp --centerline line.mrk.json --from X Y Z --to X Y Z -o cut",
        "suggest surface.vtp --centerline line.mrk.json -o proposal.json",
    ):
        done = shell(*arguments_of(f"sdfstent {command}"), folder=folder)
        assert done.returncode == 0, (command, done.stderr)


def test_a_plan_with_a_curve_is_carried_out(folder, shell):
    words = "deploy surface.vtp --axis axis.mrk.json --diameter 7.5 -o out.vtp --save-plan p.json"
    assert shell(*words.split(), folder=folder).returncode == 0
    assert_runs(folder, ["run", "p.json", "-o", "again"], shell)
    again = folder / "again" / "surface_stented.vtp"
    assert again.read_bytes() == (folder / "out.vtp").read_bytes()


def test_what_the_readme_says_comes_is_what_comes(folder, shell):
    """Each line of its output begins one that its commands say; its program prints its number."""
    text = (PROJECT / "README.md").read_text(encoding="utf-8")
    shown = re.search(r"```text\n(.*?)```", text, re.S)[1].splitlines()
    commands = [arguments_of(one) for one in command_lines(text)]
    wanted = [one for one in commands if one[0] in ("measure", "deploy")]
    said = "".join(shell(*arguments, folder=folder).stdout for arguments in wanted).splitlines()
    assert len(shown) == 3
    for line in shown:
        assert any(one.startswith(line) for one in said), line


@pytest.mark.parametrize("document", ["README.md", "docs/engineer.md", "docs/plan.md"])
def test_programs_of_the_documents_run_and_print_what_they_say(
    folder, monkeypatch, capsys, document
):
    monkeypatch.chdir(folder)
    text = (PROJECT / document).read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", text, re.S)
    exec(compile(program, document, "exec"), {})
    said = capsys.readouterr().out
    assert "True" in said or "certified for meshing" in said
    for number in re.findall(r"#.* ([\d.]+ mm)$", program, re.M):
        assert number in said


def test_the_readme_is_short_and_its_make_targets_are_there():
    text = (PROJECT / "README.md").read_text(encoding="utf-8")
    targets = set(re.findall(r"^make ([\w-]+)", text, re.M))
    rules = (PROJECT / "Makefile").read_text(encoding="utf-8")
    assert targets == {"demo", "test", "app"}
    assert all(re.search(rf"^{target}:", rules, re.M) for target in targets)
    assert len(text.split()) <= 900


def test_links_of_the_documents_lead_somewhere():
    """Files that are there, and headings that are in them."""
    care = [PROJECT / name for name in ("CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md")]
    missing = []
    for path in [*DOCUMENTS, *care]:
        text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            name, _, heading = link.partition("#")
            if name.startswith(("http", "mailto")):
                continue
            target = (path.parent / name).resolve() if name else path
            if not target.exists() or (heading and heading not in headings_of(target)):
                missing.append(f"{path.name}: {link}")
    assert not missing


def headings_of(path) -> set[str]:
    """As GitHub links them."""
    titles = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


def test_commands_of_the_evidence_have_the_options_that_are_named():
    """Modules and tests that exist, and options that they know."""
    text = (PROJECT / "docs" / "evidence.md").read_text(encoding="utf-8")
    rows = re.findall(r"`python -m ([\w.]+) ?([^`]*)`", text)
    assert len(rows) >= 8
    for module, words in rows:
        if module == "pytest":
            assert all((PROJECT / word).exists() for word in words.split()), words
            continue
        place = PROJECT / module.replace(".", "/")
        files = [place.with_suffix(".py"), place / "__main__.py"]
        (file,) = [one for one in files if one.is_file()]
        known = file.read_text(encoding="utf-8") + (PROJECT / "benchmarks" / "common.py").read_text(
            encoding="utf-8"
        )
        for option in re.findall(r"--[\w-]+", words):
            assert f'"{option}"' in known, (module, option)
