"""Inside Slicer: what the self-test leaves out. Run by ctest, and by the test host outside Slicer."""

import slicer
from SDFStentSlicer.Logic import SDFStentLogic
from SDFStentSlicer.SampleVessels import addSampleVessel
from slicer.ScriptedLoadableModule import ScriptedLoadableModuleTest


class SDFStentLogicTest(ScriptedLoadableModuleTest):
    """Both sample vessels, from the console's side."""

    def setUp(self):
        slicer.mrmlScene.Clear(0)

    def test_bothSampleVesselsCanBeStented(self):
        for sampleName in ("branching_pulmonary_artery", "arch_with_coarctation"):
            self.setUp()
            logic = SDFStentLogic()
            parameters = logic.getParameterNode()
            parameters.vessel, parameters.centerline = addSampleVessel(sampleName, "Vessel")
            logic.addStent(parameters, length=15.0)
            self.assertTrue(logic.deploy(parameters).certificate.passed)

    def test_missingInputsAreNamed(self):
        logic = SDFStentLogic()
        parameters = logic.getParameterNode()
        self.assertIn("vessel", logic.missing(parameters))
        with self.assertRaisesRegex(ValueError, "Select a vessel"):
            logic.deploy(parameters)
