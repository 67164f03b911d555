"""The panel's `.ui` file as values: its ends, words and order, and junk from a browser."""

import ast
import re
from pathlib import Path

import pytest
from child_processes import PROJECT

from SDFStentApp import template
from SDFStentApp.tables import TableItem
from SDFStentApp.ui_file import UiPanel
from SDFStentApp.widgets import Number
from SDFStentLib.validation import InputError

UI = Path(__file__).resolve().parents[1] / "SDFStent" / "Resources" / "UI" / "SDFStent.ui"
JUNK = [None, "x", [], {}, float("nan"), [1, 2, 3, 4], [-1, 0], ["a", "b"], {"a": 1}, 10**9, True]


@pytest.fixture
def a_panel():
    return UiPanel(UI)


def test_every_widget_of_the_panel_is_in_the_page_in_its_order_or_left_out_on_purpose(a_panel):
    page = template.markup(a_panel.top)
    shown = re.findall(r'data-name="(\w+)"', page)
    known = re.findall(r'<widget class="\w+" name="(\w+)"', UI.read_text(encoding="utf-8"))
    order = [name for name in known if name in shown]
    assert list(dict.fromkeys(shown)) == order
    holds_others = {name for name in known if name in ("SDFStent", "stentEditor", "stentDetails")}
    missing = {name for name in known if name not in shown and f"{name}.visible" not in page}
    assert missing - holds_others == set(template.NOT_IN_THE_PAGE)
    for names in (
        template.ASKS_FOR_FILE,
        template.SAVES,
        template.WRITES_FILE,
        template.WRITES_FOLDER,
    ):
        assert set(names) <= set(shown)


def test_a_number_stays_within_its_ends_and_tells_what_it_is():
    number, heard = Number("n"), []
    number.minimum, number.maximum = 1.0, 5.0
    number.connect("valueChanged(double)", heard.append)
    number.suffix = " mm"
    for value in (3, *JUNK):
        if value != 10**9:
            number.edit(value)
    for value in (99, -99, 1e300, float("inf")):
        with pytest.raises(InputError, match=r"^Expected 1 to 5 mm, got .*; it stays 3 mm\.$"):
            number.edit(value)
    for value in (99, -99):
        number.value = value  # as Qt does for a program
    assert (number.value, heard) == (1.0, [3.0, 5.0, 1.0])
    number.maximum = 0.5 + number.minimum
    number.value = 5
    assert heard[-1] == 1.5
    number.enabled = False
    number.edit(1.2)
    assert number.value == 1.5
    wasBlocked = number.blockSignals(True)
    number.value = 1.0
    assert (wasBlocked, heard[-1]) == (False, 1.5)


def test_junk_from_a_browser_changes_nothing(a_panel):
    table = a_panel.stentTable
    table.setRowCount(1)
    table.setItem(0, 0, TableItem("Stent 1"))
    a_panel.placementComboBox.addItem("Middle at a point")
    before = {name: widget.state() for name, widget in a_panel.widgets.items()}
    for widget in a_panel.widgets.values():
        for value in JUNK:
            isText = isinstance(value, str) and widget.edited == "text"
            isNumber = value == 10**9 and isinstance(widget, Number) and widget.enabled
            if isNumber:
                with pytest.raises(InputError, match="Expected"):
                    widget.edit(value)
            elif not (isText or isinstance(value, bool)):
                widget.edit(value)
    assert {name: widget.state() for name, widget in a_panel.widgets.items()} == before


def test_cells_are_ticked_and_typed_into_only_where_that_is_offered(a_panel):
    table, heard = a_panel.planTable, []
    table.setRowCount(2)
    table.setItem(0, 0, TableItem("plan"))
    table.setItem(1, 0, TableItem("plan", can_be_edited=True, is_checked=False))
    table.connect("itemChanged(QTableWidgetItem*)", lambda item: heard.append(item.row()))
    for row in (0, 1):
        table.edit([row, 0, "name"])
    assert [table.item(row, 0).text() for row in (0, 1)] == ["plan", "name"]
    assert heard == [1]
    table.edit([1, 0, True])
    table.edit([0, 0, True])
    assert [table.item(row, 0).is_checked for row in (0, 1)] == [None, True]
    table.edit([1, 0])
    assert (table.currentRow(), table.selectedItems()[0].text()) == (1, "name")
    table.setRowCount(1)
    assert table.selectedItems() == []


# The page has logic, words and ranges of the module from there: nothing is written twice.

APP = sorted((PROJECT / "SDFStentApp").glob("*.py"))
SHARED = sorted(
    [
        *(PROJECT / "SDFStent" / "SDFStentSlicer").glob("*.py"),
        *(PROJECT / "SDFStentLib").rglob("*.py"),
    ]
)
SAME_LINES = 5
"""So many lines in a row are written twice when they are the same."""


def blocks(path: Path) -> set[tuple[str, ...]]:
    """All runs of so many statements' lines, without imports, blank lines and indentation."""
    lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
    code = [
        line for line in lines if len(line) > 3 and not line.startswith(("import", "from", "#"))
    ]
    return {tuple(code[i : i + SAME_LINES]) for i in range(len(code) - SAME_LINES + 1)}


def test_no_piece_of_the_logic_or_the_library_is_in_the_page_once_more():
    known = {block: path.name for path in SHARED for block in blocks(path)}
    twice = [(path.name, known[block]) for path in APP for block in blocks(path) if block in known]
    assert twice == []


def test_the_page_takes_from_the_library_what_reads_plans_and_writes_results_only():
    used = {
        (node.module, alias.name)
        for path in APP
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("SDFStentLib")
        for alias in node.names
    }
    assert {module.partition(".")[2] for module, _ in used} == {
        *("files", "line_formats", "plan", "report", "stent", "surface_formats", "units"),
        *("scan", "scan_formats", "validation"),  # a segmentation is made a vessel, as by the shell
        "interpreter",  # pages and segmentations have processes of their own
    }
    # A plan that is kept is written whole or not at all, as every file; a file that is dropped on
    # the page is a centerline where it has lines.
    of_files = {name for module, name in used if module == "SDFStentLib.files"}
    # A file that Slicer does not read is opened by the library's own reader.
    assert of_files - {"ID_ARRAY", "NAME_ARRAY", "set_face_names"} == {
        *("LineFile", "SurfaceFile", "read_lines", "read_with_pieces", "write_bytes"),
        *("write_extracted_lines", "write_new_surface"),
    }
    assert not {name for _, name in used} & {"Treatment", "Preview", "Deployment", "find_lesions"}


def test_no_word_of_the_panel_and_no_range_is_in_the_page_once_more():
    ui = UI.read_text(encoding="utf-8")
    texts = re.findall(r'<property name="(?:text|toolTip)">\s*<string>([^<]{12,})</string>', ui)
    assert len(texts) > 40
    sources = "\n".join(path.read_text(encoding="utf-8") for path in APP)
    assert [text for text in texts if text in sources] == []
    known = set(re.findall(r'name="(\w+)">', ui)) - {"text"}
    ranges = re.findall(r"\.(\w+Slider|\w+SpinBox)\.(?:minimum|maximum|value) = ", sources)
    assert [name for name in ranges if name in known] == []


def test_neither_page_nor_panel_imports_all_of_vtk():
    panel = (PROJECT / "SDFStent" / "SDFStentSlicer").glob("*.py")
    lines = [
        (path.name, line)
        for path in [*APP, *panel]
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.match(r"\s*(import|from) vtk\b", line)
    ]
    assert lines == []
