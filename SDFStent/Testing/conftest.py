"""Fixtures for the module's tests: one host per process, a new scene per test, and a log that has to stay clean."""

import os
import pickle
from dataclasses import replace
from functools import cached_property
from hashlib import sha1
from pathlib import Path

import numpy as np
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
def knownResults(theModule):
    """Measure each treatment of the panel only once, which takes longer than deploying. A test that needs the time
    clears the dictionary.

    Results are found by the surfaces before and after, stents, centerline and settings. The library's own `Treatment`,
    with which results of the panel are compared, keeps none.
    """
    from SDFStentSlicer import Calculating, Plans

    from SDFStentLib.treatment import Treatment

    known = {}

    class KnownResult(Calculating.TreatedCase):
        @cached_property
        def lesions(self):
            found, after, before = self.found, self.treatment.surface, self.vessel.surface
            walls = (sha1(surface.points.tobytes()).digest() for surface in (after, before))
            lie = ((one.number, one.axis.points.tobytes()) for one in self.treatment.stents)
            key = (*lie, *map(id, found or ()), *walls)
            if (
                key not in known
            ):  # with the objects whose ids are in the key, so that the ids stay theirs
                known[key] = super().lesions, found
            return known[key][0]

    class KnownTreatment(Treatment):
        def _key(self, *more):
            line = self.centerline
            tree = () if line is None else (line.points, line.inscribed_radius, line.parent)
            arrays = (self.surface.points, self.surface.triangles, self.companions, *tree, *more)
            plan = (
                self.stents,
                self.settings,
                self.straightening_fraction,
                self.precision,
                self.faces,
                self.given_names,
            )
            hashes = [sha1(np.ascontiguousarray(array).tobytes()).digest() for array in arrays]
            return (*hashes, sha1(pickle.dumps(plan)).digest())

        @cached_property
        def survey(self):
            key = ("survey", *self._key())
            if key not in known:
                known[key] = super().survey
            return known[key]

        def _measured(self):
            surface, centerline, companions = self._final
            key = self._key(surface.points)
            if key not in known:
                known[key] = super()._measured()
            return replace(
                known[key],
                before=self.surface,
                surface=surface,
                centerline=centerline,
                companions=companions,
            )

    class KnownCase(Plans.Case):
        def treatment(self):
            made = super().treatment()
            made.__class__ = KnownTreatment
            return made

    Plans.Case, Calculating.TreatedCase = KnownCase, KnownResult
    Calculating.processes.use(False)
    return known


@pytest.fixture(scope="session")
def theModule(host):
    """SDFStent.py, loaded as Slicer would."""
    return host.loadModule(MODULE)


@pytest.fixture
def aScene(host, theModule):
    """An empty scene; after the test nothing may have been logged."""
    host.newScene()
    host.errors()
    yield host.scene
    assert host.errors() == []


@pytest.fixture
def aPanel(host, aScene, theModule):
    """The module's panel, entered, without *Live*, so that nothing is deployed before a click."""
    panel = host.openPanel(theModule)
    panel.ui.autoUpdateCheckBox.checked = False
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
    """The folder for screenshots: the one named by the variable SDFSTENT_PICTURES, else a temporary one."""
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


@pytest.fixture
def aStepAtATime(monkeypatch):
    """Turns of one step each: however slow the machine, no deployment ends within a few of them."""
    from SDFStentSlicer import Clock

    monkeypatch.setattr(Clock.QtTimer, "TURN_S", (0.0, 0.0))
