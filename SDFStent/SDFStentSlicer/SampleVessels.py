"""Synthetic vessels in Slicer's Sample Data, from files of the library: nothing is downloaded."""

import pathlib

import numpy as np
import slicer
from slicer.i18n import tr as _

from SDFStentLib.files import (
    add_arrays,
    polydata_from_arrays,
    polydata_from_lines,
    read_centerline,
    read_surface,
    set_face_names,
)
from SDFStentLib.samples import sample

CATEGORY = "SDF Stent"


def registerSampleData():
    """Offer both vessels in the Sample Data module."""
    import SampleData

    icons = pathlib.Path(__file__).resolve().parents[1] / "Resources" / "Icons"
    logic = SampleData.SampleDataLogic
    known = [source.sampleName for source in logic.sampleDataSourcesByCategory(CATEGORY)]
    for name, sampleName in (
        ("StenosedPulmonaryArtery", "branching_pulmonary_artery"),
        ("AortaWithCoarctation", "arch_with_coarctation"),
    ):
        if name in known:
            continue
        logic.registerCustomSampleDataSource(
            category=CATEGORY,
            sampleName=name,
            thumbnailFileName=str(icons / f"{name}.png"),
            uris="",
            fileNames="",
            nodeNames="",
            customDownloader=lambda source, sampleName=sampleName, name=name: _bring(
                sampleName, name
            ),
        )


def _bring(sampleName, name):
    """Add the vessel and its centerline by a click in Sample Data, and turn the 3D view to them."""
    nodes = addSampleVessel(sampleName, name)
    layoutManager = slicer.app.layoutManager()
    if layoutManager is not None:
        layoutManager.resetThreeDViews()
    return nodes


def addSampleVessel(sampleName, name, scene=None):
    """A sample of the library as two nodes: vessel model and centerline model, returned in this order."""
    files = sample(sampleName)
    wall = read_surface(files.surface)
    return addVessel(wall.surface, wall.faces, read_centerline(files.centerline), name, scene)


def addVessel(surface, faces, centerline, name, scene=None):
    """A vessel of the library as two nodes: vessel model, with the library's `faces`, and centerline model."""
    scene = scene or slicer.mrmlScene
    polyData = polydata_from_arrays(
        surface.points.astype(np.float32), surface.triangles, cell_arrays={"ModelFaceID": faces.ids}
    )
    set_face_names(polyData, faces.names)
    vessel = addModel(scene, name, polyData)
    vessel.GetDisplayNode().SetOpacity(0.5)
    vessel.GetDisplayNode().SetColor(0.85, 0.45, 0.4)
    centerline = addModel(
        scene, _("{name} centerline").format(name=name), centerlinePolyData(centerline)
    )
    centerline.GetDisplayNode().SetLineWidth(3)
    return [vessel, centerline]


def addModel(scene, name, polyData):
    """Add a model, shown under a name of its own."""
    node = scene.AddNewNodeByClass("vtkMRMLModelNode", scene.GenerateUniqueName(name))
    node.SetAndObservePolyData(polyData)
    node.CreateDefaultDisplayNodes()
    node.GetDisplayNode().SetVisibility2D(True)
    return node


def centerlinePolyData(centerline):
    """The library's centerline as poly-lines with the array `Radius`, as Extract Centerline makes them."""
    lines = [centerline.ancestry(leaf) for leaf in centerline.leaves]
    polyData = polydata_from_lines(centerline.points.astype(np.float32), lines)
    add_arrays(polyData, {"Radius": centerline.inscribed_radius}, None)
    return polyData
