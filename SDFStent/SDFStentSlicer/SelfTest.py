"""The module's self-test inside Slicer: no download, well under a minute."""

import slicer
from slicer.ScriptedLoadableModule import ScriptedLoadableModuleTest

from .Logic import SDFStentLogic
from .SampleVessels import addSampleVessel


class SDFStentTest(ScriptedLoadableModuleTest):
    """Deploys a stent in the synthetic pulmonary artery, as a user of the console does."""

    def setUp(self):
        slicer.mrmlScene.Clear(0)

    def test_stentedLumenHasThePrescribedDiameter(self):
        self.delayDisplay("Deploy a stent in a synthetic vessel")
        logic, parameters = self.aDeployment()
        before = parameters.vessel.GetPolyData().GetMTime()
        result = logic.deploy(parameters)
        profile = result.stents[0].after
        self.assertAlmostEqual(
            profile.mean, parameters.stents[0].diameter, delta=0.02 * profile.mean
        )
        self.assertEqual(parameters.vessel.GetPolyData().GetMTime(), before)
        self.assertIsNotNone(parameters.outputTable)
        self.delayDisplay("Test passed")

    def test_stepsCanBeStoppedAndShownAgain(self):
        logic, parameters = self.aDeployment()
        steps = logic.steps(parameters)
        next(fraction for fraction in steps if fraction > 0)
        steps.close()
        logic.showStep(parameters, 50)
        self.assertTrue(logic.hasSteps(parameters))

    def aDeployment(self):
        logic = SDFStentLogic()
        parameters = logic.getParameterNode()
        parameters.vessel, parameters.centerline = addSampleVessel(
            "branching_pulmonary_artery", "Artery"
        )
        logic.addStent(parameters, diameter=9.0, length=18.0)
        return logic, parameters
