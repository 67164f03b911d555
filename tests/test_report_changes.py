"""What a report tells of the run's settings, of the surface's triangles, and of coordinates."""

from __future__ import annotations

import html
import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

from SDFStentLib.deformation import DeploymentSettings
from SDFStentLib.files import polydata_from_arrays
from SDFStentLib.plan import Plan, PlanResult, read_input_files, treatment_of
from SDFStentLib.report import plan_report
from SDFStentLib.report.changes import setting_rows
from SDFStentLib.report.html import html_page
from SDFStentLib.stent import AtCenter, Stent
from SDFStentLib.validation import Points, Triangles


def quality(points: Points, triangles: Triangles, measure: str) -> np.ndarray:
    """A measure of every triangle by VTK's Verdict library."""
    judge = vtkMeshQuality()
    judge.SetInputData(polydata_from_arrays(points, triangles))
    getattr(judge, f"SetTriangleQualityMeasureTo{measure}")()
    judge.Update()
    return vtk_to_numpy(judge.GetOutput().GetCellData().GetArray("Quality"))


@pytest.fixture(scope="module")
def in_cm(data_dir: Path) -> PlanResult:
    """A deployment in an anatomy, in a file in cm."""
    surface, line = (data_dir / f"pulmonary_{part}_cm.vtp" for part in ("surface", "centerline"))
    inputs = read_input_files(surface, line, "cm")
    stent = Stent(20.0, placement=AtCenter(np.array([27.16, -54.26, 67.09])), length=20.0)
    plan = Plan((stent,), units="cm", settings=DeploymentSettings(tissue_gap=0.5))
    return PlanResult(plan, inputs, treatment_of(plan, inputs).result)


def test_the_report_tells_how_triangles_were_changed(in_cm: PlanResult) -> None:
    told = plan_report(in_cm).as_dict()["changes"]
    before, after = in_cm.inputs.surface.points, in_cm.treatment.points
    triangles = in_cm.inputs.surface.triangles
    moved = (before != after).any(axis=1)
    faces = triangles[moved[triangles].any(axis=1)]
    assert told["moved_points"] == moved.sum() > 100
    assert (told["moved_triangles"], told["triangles"]) == (len(faces), len(triangles))
    for when, points in (("before", before), ("after", after)):
        angles = quality(points, faces, "MinAngle")
        expected = [angles.min(), np.median(angles), angles.max()]
        assert [*told["smallest_angle_deg"][when].values()] == pytest.approx(expected, abs=1e-5)
        edges = [
            np.linalg.norm(points[faces[:, i]] - points[faces[:, i - 1]], axis=1) for i in range(3)
        ]
        expected = [np.min(edges), np.median(edges), np.max(edges)]
        assert [*told["edge_length_mm"][when].values()] == pytest.approx(expected)
    ratio = quality(after, faces, "Area") / quality(before, faces, "Area")
    expected = [ratio.min(), np.median(ratio), ratio.max()]
    assert [*told["area_ratio"].values()] == pytest.approx(expected, rel=1e-6)


def test_the_page_tells_coordinates_in_mm_and_as_the_file_has_them(in_cm: PlanResult) -> None:
    document = plan_report(in_cm).as_dict()
    axis = document["stents"][0]["axis"]
    for end in ("start", "end"):
        np.testing.assert_allclose(np.multiply(axis[end], 10), axis[f"{end}_mm"])
    page = html.unescape(html_page(document))
    for label, name in (("Proximal", "start"), ("Distal", "end")):
        (told,) = re.findall(rf"<td>{label} end [^<]*</td><td>([^<]*)</td>", page)
        numbers = [
            float(n) for n in re.findall(r"-?[0-9]+\.[0-9]+", told.replace("\N{MINUS SIGN}", "-"))
        ]
        np.testing.assert_allclose(numbers[:3], axis[f"{name}_mm"], atol=0.051)
        np.testing.assert_allclose(numbers[3:], axis[name], atol=0.0051)
        assert " mm; in the file " in told
        assert told.endswith(" cm")
    assert len(re.findall(r"along it; [^<]* mm; in the file [^<]* cm", page)) == len(
        document["lesions"]
    )


def test_every_parameter_of_the_method_is_told_lengths_in_mm(in_cm: PlanResult) -> None:
    document = plan_report(in_cm).as_dict()
    rows = dict(setting_rows(document["settings"]))
    assert rows["Tissue gap"] == "0.5 mm"
    assert rows["Step"] == "chosen by the rule"
    assert rows["Untangle"] == "yes"
    assert len(rows) == len(fields(DeploymentSettings)) + 1
    lengths = {key.removesuffix("_mm") for key in document["settings"] if key.endswith("_mm")}
    assert lengths == {
        name for name, one in DeploymentSettings.parameters().items() if one.unit == "mm"
    }
    page = html_page(document)
    for name, text in rows.items():
        assert f"<td>{name}</td><td>{text}</td>" in page
