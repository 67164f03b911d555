"""Fixtures for the module's tests: one host per process, a new scene per test, and a log that has to stay clean."""

import os
from functools import lru_cache
from hashlib import sha1
from pathlib import Path

import pytest
from panel_helpers import theThroat
from sdfstent_host import missingLibraries

MODULE = Path(__file__).parents[1] / "SDFStent.py"


@pytest.fixture(scope="session")
def host():
    """The stand-in for the Slicer application."""
    missing = missingLibraries()
    if missing:
        pytest.fail("\n".join(missing), pytrace=False)
    from sdfstent_host import Host

    return Host.start()


@pytest.fixture(scope="session", autouse=True)
def thePhantoms(theModule):
    """Make each synthetic vessel once: they take a second."""
    from SDFStentLib import phantoms

    for name in ("branching_pulmonary_artery", "arch_with_coarctation"):
        setattr(phantoms, name, lru_cache(getattr(phantoms, name)))


@pytest.fixture(scope="session", autouse=True)
def knownLesions(theModule):
    """Look for the lesions of each vessel once: that takes as long as a deployment. A test that needs the search clears it."""
    from SDFStentSlicer import Lesions

    search, known = Lesions.find_lesions, {}

    def found(surface, centerline, faces=None):
        arrays = (surface.points, surface.triangles, centerline.points, centerline.inscribed_radius)
        key = (
            *(sha1(array.tobytes()).digest() for array in arrays),
            repr(faces and sorted(faces.names.items())),
        )
        if key not in known:
            known[key] = search(surface, centerline, faces)
        return tuple(list(known[key]))  # another one for every search, as without this

    Lesions.find_lesions = found
    return known


@pytest.fixture(scope="session")
def theModule(host):
    """SDFStent.py, loaded as Slicer would."""
    return host.loadModule(MODULE)


@pytest.fixture
def aScene(host, theModule):
    """An empty scene; afterwards nothing may have been logged."""
    host.newScene()
    host.errors()
    yield host.scene
    assert host.errors() == []


@pytest.fixture
def aPanel(host, aScene, theModule):
    """The module's panel, entered."""
    panel = host.openPanel(theModule)
    yield panel
    host.closePanel(panel)


@pytest.fixture
def aLogic(aScene, theModule):
    """A logic without a panel."""
    return theModule.python.SDFStentLogic()


@pytest.fixture
def aVessel(aScene, theModule):
    """The synthetic pulmonary artery: vessel model and centerline model."""
    from SDFStentSlicer.SampleVessels import addSampleVessel

    return addSampleVessel("branching_pulmonary_artery", "Artery")


@pytest.fixture
def theParameters(aLogic, aVessel):
    """Parameters with one stent at the throat, ready to deploy."""
    parameters = aLogic.getParameterNode()
    parameters.vessel, parameters.centerline = aVessel
    handle = aLogic.addStent(parameters, diameter=8.5, length=14.0)
    handle.SetNthControlPointPositionWorld(0, *theThroat())
    return parameters


@pytest.fixture
def thePictures(tmp_path):
    """Where screenshots go: a folder of one's own by the variable SDFSTENT_PICTURES, else a temporary one."""
    folder = Path(os.environ.get("SDFSTENT_PICTURES", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@pytest.fixture
def theInputs(host, aPanel, aVessel):
    """The panel with vessel and centerline chosen."""
    vessel, centerline = aVessel
    aPanel.ui.vesselSelector.setCurrentNode(vessel)
    aPanel.ui.centerlineSelector.setCurrentNode(centerline)
    host.process()
    return aPanel


@pytest.fixture
def aStent(host, theInputs):
    """The panel with one stent at the throat."""
    host.click(theInputs.ui.addStentButton)
    stent = theInputs._parameterNode.stent
    stent.handle.SetNthControlPointPositionWorld(0, *theThroat())
    theInputs.ui.diameterSlider.value = 8.5
    theInputs.ui.lengthSlider.value = 14.0
    host.process()
    return theInputs
