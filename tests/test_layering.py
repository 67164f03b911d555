"""The house: rooms on floors, no circles, tables of contents, and no application in the library."""

import ast
import importlib
import re
from collections import Counter
from functools import cache
from pathlib import Path

from child_processes import PROJECT, python

from SDFStentLib.cautions import TEMPLATES

LIBRARY = PROJECT / "SDFStentLib"
FLOORS = (
    (
        "validation",
        "parameter",
        "cautions",
        "units",
        "version",
        "interpreter",
        "threads",
        "surface_formats",
        "line_formats",
        "scan_formats",
    ),
    ("geometry",),
    ("field", "centerline", "certificate"),
    ("lumen", "stent", "files", "samples"),
    ("deformation", "vessel"),
    ("segment", "flow", "view"),
    ("treatment",),
    ("plan", "simulation"),
    ("scan", "beside"),
    ("report",),
    ("cohort",),
    ("cli",),
    ("__init__", "__main__"),
)
"""From the ground: a room imports from lower floors only."""

USES = {
    "field": "geometry",
    "centerline": "geometry",
    "certificate": "geometry",
    "lumen": "geometry centerline",
    "stent": "geometry centerline",
    "files": "geometry centerline",
    "samples": "",
    "deformation": "geometry field certificate lumen",
    "vessel": "geometry centerline lumen",
    "flow": "geometry centerline lumen vessel",
    "segment": "geometry centerline vessel",
    "view": "geometry centerline vessel",
    "treatment": "geometry centerline certificate flow lumen stent deformation vessel segment",
    "plan": "geometry centerline files flow lumen stent deformation treatment vessel view",
    "simulation": "geometry certificate flow files centerline segment treatment vessel",
    "scan": "geometry centerline certificate flow lumen segment treatment vessel plan",
    "beside": "treatment vessel plan",
    "report": "geometry centerline certificate lumen stent files treatment vessel segment flow "
    "plan simulation view scan",
    "cohort": "geometry centerline certificate stent files treatment plan report",
    "cli": "files geometry samples stent vessel view flow treatment plan simulation scan report "
    "cohort",
}
"""Which rooms a room knows, those on the ground left out: the fewer, the easier it is to change."""

FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms}
ROOMS = sorted(path.parent.name for path in LIBRARY.glob("*/__init__.py"))
TABLES = [
    "",
    *ROOMS,
    *sorted(f"{p.parts[-3]}.{p.parts[-2]}" for p in LIBRARY.glob("*/*/__init__.py")),
]
FILES = sorted(LIBRARY.rglob("*.py"))
OUTSIDERS = [
    path
    for folder in ("SDFStent", "SDFStentApp", "benchmarks", "examples")
    for path in sorted((PROJECT / folder).rglob("*.py"))
    if "Testing" not in path.parts
]
WITH_PANEL = FILES + sorted((PROJECT / "SDFStent" / "SDFStentSlicer").rglob("*.py"))
VTK_GATE = {  # the only files that may import vtk themselves
    "files/polydata.py", "files/centerline_files.py", "files/centerline_output.py",
    "files/surface_files.py", "files/surface_output.py", "files/triangulation.py",
    "files/model_faces.py", "files/same_space.py", "files/ghosts.py",
    "files/formats/vtk_files.py", "files/vmtk_process.py",
    "files/formats/vtk_quiet.py", "files/vtkhdf_process.py",
    "scan/contour.py",
    "report/picture/painter.py",
}  # fmt: skip


def name_of(path: Path) -> str:
    return path.relative_to(LIBRARY).as_posix()


def module_of(path: Path) -> str:
    """Dotted within the library: `files.plain.ply`, a package by its own name."""
    return name_of(path).removesuffix(".py").removesuffix("/__init__").replace("/", ".")


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """All of a file, looked at by many rules."""
    return tuple(ast.walk(tree_of(path)))


@cache
def imports_of(path: Path) -> dict[str, set[str]]:
    """Modules of the library that a file imports, at its top or late, and the names from each."""
    is_inside = path.is_relative_to(LIBRARY)
    package = path.relative_to(LIBRARY).parts[:-1] if is_inside else ()
    found: dict[str, set[str]] = {}
    for node in nodes_of(path):
        if not isinstance(node, ast.ImportFrom):
            continue
        module = node.module or ""
        if node.level and not is_inside:
            continue
        if node.level:
            above = package[: len(package) - node.level + 1]
            target = ".".join([*above, module]) if module else ".".join(above)
        elif module.split(".")[0] == "SDFStentLib":
            target = module.partition(".")[2]
        else:
            continue
        found.setdefault(target, set()).update(alias.name for alias in node.names)
    return found


def outside_of(path: Path) -> set[str]:
    found = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module.split(".")[0])
    return found


def room_of(module: str) -> str:
    return module.split(".")[0]


def table(room: str):
    return importlib.import_module(f"SDFStentLib.{room}" if room else "SDFStentLib")


def names_of(room: str) -> list[str]:
    """What a table of contents imports as itself, which type checkers take for its public names."""
    path = LIBRARY.joinpath(*room.split("."), "__init__.py")
    made = [node for node in nodes_of(path) if isinstance(node, ast.ImportFrom)]
    return [one.name for node in made for one in node.names if one.name == one.asname]


def public_names(module: str) -> set[str]:
    """What a room, the library ("") or a file on the ground offers to others."""
    if not module:
        return {*ROOMS, *table("").__all__}
    if module in ROOMS:
        return set(names_of(module))
    path = LIBRARY / f"{module}.py"
    assert path.is_file(), f"there is no SDFStentLib.{module}"
    made = [
        node for node in tree_of(path).body if not isinstance(node, ast.Import | ast.ImportFrom)
    ]
    names = {node.name for node in made if hasattr(node, "name")}
    for node in made:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return {name for name in names if not re.match("_(?!_)", name)}


def test_every_room_has_its_floor():
    assert {room_of(module_of(path)) for path in FILES} == set(FLOOR)


def test_a_file_imports_from_lower_floors_and_its_own_room_only():
    assert not [
        f"{name_of(path)} imports {module}, not below it"
        for path in FILES
        for module in imports_of(path)
        for own, other in [(room_of(module_of(path)), room_of(module))]
        if other != own and {FLOOR[own], FLOOR[other]} != {0} and FLOOR[other] >= FLOOR[own]
    ]


def test_a_room_uses_the_rooms_that_the_table_names_and_no_other():
    found: dict[str, set[str]] = {room: set() for room in USES}
    for path in FILES:
        own = room_of(module_of(path))
        others = {room_of(module) for module in imports_of(path)} & set(ROOMS) - {own}
        if own in ROOMS and others:
            found[own] |= others
    assert found == {room: set(names.split()) for room, names in USES.items()}


def test_no_files_import_each_other_in_a_circle():
    known = {module_of(path): path for path in FILES}
    waiting = {name: set(imports_of(path)) & set(known) for name, path in known.items()}
    while waiting:
        row = {name for name, below in waiting.items() if not below & set(waiting)}
        assert row, f"these import each other in a circle: {sorted(waiting)}"
        waiting = {name: below for name, below in waiting.items() if name not in row}


def test_nobody_outside_of_a_room_imports_from_inside_it():
    found = []
    for path in FILES + OUTSIDERS:
        own = room_of(module_of(path)) if path.is_relative_to(LIBRARY) else None
        for module, names in imports_of(path).items():
            if own is not None and room_of(module) == own:
                continue
            hidden = names if "." in module else names - public_names(module)
            if hidden:
                found.append(f"{path.relative_to(PROJECT)}: {module} {sorted(hidden)}")
    assert not found


def test_the_panel_asks_the_plan_and_the_report_and_makes_no_stent_flow_or_treatment_itself():
    panel = PROJECT / "SDFStent" / "SDFStentSlicer"
    known = {room_of(module) for path in panel.glob("*.py") for module in imports_of(path)}
    assert known & set(ROOMS) == {
        *("plan", "beside", "report"),  # what is done, where, and what is told
        *("files", "geometry", "centerline", "lumen"),  # what nodes are, and are drawn as
        *("deformation", "certificate", "samples"),
        "scan",  # how exact voxels are
    }


def test_nobody_imports_the_library_by_another_way_than_from_a_table_of_contents():
    found = []
    for path in FILES + OUTSIDERS:
        for node in nodes_of(path):
            words = []
            if isinstance(node, ast.Import):
                words = [alias.name for alias in node.names if "SDFStentLib." in alias.name]
            elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
                words = [word for word in [ast.unparse(node)] if "SDFStentLib" in word]
            found += [f"{path.relative_to(PROJECT)}:{node.lineno} {word}" for word in words]
    assert not found


def test_the_documents_import_only_what_the_tables_of_contents_offer():
    found = []
    for path in [PROJECT / "README.md", *sorted((PROJECT / "docs").glob("*.md"))]:
        text = path.read_text(encoding="utf-8")
        statements = re.findall(r"^from SDFStentLib[.\w]* import (?:\([^)]*\)|.*)$", text, re.M)
        for node in ast.parse("\n".join(statements)).body:
            module = node.module.partition(".")[2]
            names = {alias.name for alias in node.names}
            hidden = names if "." in module else names - public_names(module)
            found += [f"{path.name}: {node.module} {sorted(hidden)}"] if hidden else []
    assert not found


def test_only_the_gate_imports_vtk_and_nothing_imports_the_application():
    never = {"slicer", "qt", "ctk", "pymeshlab", "tetgen", "svmorph", "jsonschema"}
    assert not {
        name_of(path): outside_of(path) & never for path in FILES if outside_of(path) & never
    }
    with_vtk = {name_of(path) for path in FILES if outside_of(path) & {"vtk", "vtkmodules"}}
    assert with_vtk <= VTK_GATE


def test_the_method_imports_neither_vtk_nor_scipy_spatial():
    reads = {"files", "simulation", "plan", "scan", "beside", "report", "cohort", "cli"}
    names = [room for room in ROOMS if room not in reads]
    program = (
        "import sys; [sys.modules.__setitem__(name, None) for name in ('slicer', 'qt', 'ctk')];"
        f"import SDFStentLib; from SDFStentLib import {', '.join(names)}; "
        "from SDFStentLib import Deployment, Treatment;"
        "print([m for m in sys.modules if m.startswith(('vtk', 'scipy.spatial'))])"
    )
    assert python(program).stdout.strip() == "[]"


def test_a_table_of_contents_names_what_there_is_and_dir_shows_it():
    wrong = [room for room in TABLES if not is_true_table(room)]
    assert not wrong


def is_true_table(room) -> bool:
    """Each name once and there, and everything that is imported is one."""
    names, contents = names_of(room), table(room)
    return (
        len(set(names)) == len(names)
        and set(names) <= set(dir(contents))
        and all(getattr(contents, name, None) is not None for name in names)
        and not hasattr(contents, "nothing")
    )


def test_the_picture_of_the_house_has_every_room_on_its_floor():
    picture = (PROJECT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("```")[1]
    rows = re.findall(r"^ ?(\d+)  ((?:\w+, )*\w+)", picture, re.M)
    assert {room: int(floor) for floor, rooms in rows[:-1] for room in rooms.split(", ")} == {
        room: FLOOR[room] for room in ROOMS if room != "cli"
    }


def test_the_guide_names_only_files_that_exist():
    guide = (PROJECT / "docs" / "developer_guide.md").read_text(encoding="utf-8")
    text = guide.split("## The Slicer module")[0]
    named = re.findall(r"\b(\w+/\w+\.py)\b", text)
    shown = [*FILES, *OUTSIDERS, Path(__file__)]
    known = {path.parent.name + "/" + path.name for path in shown}
    missing = [name for name in named if name not in known]
    assert len(named) > 20
    assert missing == []


def test_every_file_of_the_module_says_what_it_does_and_the_guide_names_only_such():
    guide = (PROJECT / "docs" / "developer_guide.md").read_text(encoding="utf-8")
    for heading, folder in (
        ("The Slicer module", PROJECT / "SDFStent" / "SDFStentSlicer"),
        ("The page", PROJECT / "SDFStentApp"),
    ):
        section = guide.split(f"## {heading}\n")[1].split("\n## ")[0]
        files = {path.name: path for path in folder.glob("*.py")}
        silent = [name for name, path in files.items() if not ast.get_docstring(tree_of(path))]
        assert not silent
        named = set(re.findall(r"`(\w+\.py)`", section))
        assert len(named) > 10
        assert named <= {*files, "SDFStent.py"}


def test_the_module_reaches_qt_through_two_files_that_an_application_can_replace():
    files = sorted((PROJECT / "SDFStent" / "SDFStentSlicer").glob("*.py"))
    assert [path.stem for path in files if outside_of(path) & {"qt", "ctk"}] == ["Clock", "Desktop"]


def test_no_shipped_file_grows_beyond_its_limit():
    lines = {name_of(path): len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}
    assert not {name: count for name, count in lines.items() if count > 350}


def test_no_room_grows_too_full():
    count = Counter(path.parent.relative_to(LIBRARY).as_posix() for path in FILES)
    assert not {room: files for room, files in count.items() if files > 20}


def test_every_while_says_why_it_ends():
    for path in WITH_PANEL:
        lines = path.read_text(encoding="utf-8").splitlines()
        for node in nodes_of(path):
            if isinstance(node, ast.While):
                above = node.lineno - 2
                while lines[above - 1].lstrip().startswith("#"):
                    above -= 1
                assert lines[above].lstrip().startswith("# Ends"), f"{path}:{node.lineno}"


def test_no_sentence_of_the_library_names_an_option():
    for path in FILES:
        for node in nodes_of(path) if room_of(module_of(path)) != "cli" else ():
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                assert not re.search(r"(^|[\s(])--[a-z]", node.value), (path.name, node.value)


ARGUMENTS = {"read_text": 1, "write_text": 2, "open": 4}
"""With so many arguments the last one is the encoding."""


def without_encoding(call: ast.Call) -> bool:
    """Whether a call opens a text file in the encoding of the machine."""
    name = getattr(call.func, "id", getattr(call.func, "attr", None))
    if name not in ARGUMENTS or (name == "open" and not isinstance(call.func, ast.Name)):
        return False
    modes = [word.value for word in call.args if isinstance(word, ast.Constant)]
    is_binary = name == "open" and any("b" in str(mode) for mode in modes[-1:])
    keywords = {keyword.arg for keyword in call.keywords}
    return not (is_binary or len(call.args) >= ARGUMENTS[name] or "encoding" in keywords)


def test_every_text_file_is_opened_with_its_encoding():
    folders = ("SDFStentLib", "SDFStent", "tests", "examples", "benchmarks", "docs")
    assert not [
        f"{path.relative_to(PROJECT)}:{node.lineno}"
        for folder in folders
        for path in (PROJECT / folder).rglob("*.py")
        for node in nodes_of(path)
        if isinstance(node, ast.Call) and without_encoding(node)
    ]


BRITISH = re.compile(
    r"\w*(?:olour|grey|avour|haviour|eighbour|labell|modell|travell|fibre)\w*"
    r"|\b(?:\w*metres?|centre[sd]?|catalogue|analyse[ds]?|\w+wards)\b"
)


def test_all_texts_have_the_spelling_of_the_united_states():
    places = ("SDFStentLib", "SDFStent", "SDFStentApp", "benchmarks", "examples", "tests", "docs")
    paths = [path for place in places for path in (PROJECT / place).rglob("*.*")]
    kinds = {".py", ".ui", ".md", ".js", ".html"}
    texts = [path for path in paths if path.suffix in kinds and path != Path(__file__)]
    assert len(texts) > 600
    found = {path.name: BRITISH.findall(path.read_text(encoding="utf-8")) for path in texts}
    assert not {name: words for name, words in found.items() if words}


def test_every_class_that_is_shipped_has_a_name_of_its_own():
    shipped = [path for path in {*FILES, *WITH_PANEL, *OUTSIDERS} if "benchmarks" not in path.parts]
    names = Counter(
        node.name for path in shipped for node in nodes_of(path) if isinstance(node, ast.ClassDef)
    )
    assert [name for name, count in names.items() if count > 1] == []


# Warnings are values; their sentences are made once, at the end, and read by nobody but people.


def test_every_kind_of_caution_is_made_somewhere_and_says_one_sentence():
    nodes = [node for path in FILES if path.name != "cautions.py" for node in nodes_of(path)]
    made = {node.value for node in nodes if isinstance(node, ast.Constant)}
    assert set(TEMPLATES) <= made
    for kind, template in TEMPLATES.items():
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", kind)
        assert template.endswith((".", "{reason}"))


def test_no_code_looks_for_words_in_a_sentence():
    """A sentence, a caution or an error turned into text is neither searched, cut nor changed."""
    readers = {"replace", "startswith", "endswith", "split", "partition", "find", "index", "count"}
    about = re.compile(r"sentence|caution|warning|gap\b|str\(error\)")
    found = []
    for path in WITH_PANEL:
        for node in nodes_of(path):
            read = None
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                read = node.func.value if node.func.attr in readers else None
            elif isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In | ast.NotIn):
                read = node.comparators[0] if isinstance(node.left, ast.Constant) else None
            # A writer knows only the name that its file has while it is written.
            if read and about.search(ast.unparse(read)) and "str(staged)" not in ast.unparse(node):
                found.append(f"{path.relative_to(PROJECT)}:{node.lineno}: {ast.unparse(node)}")
    assert not found
