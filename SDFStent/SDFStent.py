"""SDF Stent: virtual stenting of vessel surfaces in 3D Slicer. Everything else is in `SDFStentSlicer` and
`SDFStentLib`."""

import pathlib
import sys

import slicer
from slicer.i18n import tr as _
from slicer.i18n import translate
from slicer.ScriptedLoadableModule import ScriptedLoadableModule


def _libraryFolder():
    """The folder that contains SDFStentLib: the folder of this file if it is installed, the one above in the source
    tree."""
    here = pathlib.Path(__file__).resolve().parent
    for folder in (here, here.parent):
        if (folder / "SDFStentLib" / "__init__.py").is_file():
            return str(folder)
    raise ModuleNotFoundError(
        "SDFStentLib was found neither beside SDFStent.py nor one folder above; reinstall the extension."
    )


# The only statement that runs at import: Slicer puts just this file's own folder on the path.
if _libraryFolder() not in sys.path:
    sys.path.append(_libraryFolder())

from SDFStentSlicer.Logic import SDFStentLogic  # noqa: E402
from SDFStentSlicer.SampleVessels import registerSampleData  # noqa: E402
from SDFStentSlicer.SelfTest import SDFStentTest  # noqa: E402
from SDFStentSlicer.Widget import SDFStentWidget  # noqa: E402

__all__ = ["SDFStent", "SDFStentLogic", "SDFStentTest", "SDFStentWidget"]


class SDFStent(ScriptedLoadableModule):
    """The description of the module for Slicer."""

    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        parent.title = _("SDF Stent")
        parent.categories = [translate("qSlicerAbstractCoreModule", "Planning")]
        parent.dependencies = []
        parent.contributors = ["SDFStent contributors"]
        parent.helpText = _(
            "Opens a vessel's surface virtually with one or more stents: choose a vessel and its centerline, add a stent, drag "
            "its handle, and read the diameters before and after. Research use only, not a medical device."
        )
        parent.helpText += (
            " <a href='https://github.com/SDFStent/SlicerSDFStent'>" + _("User guide") + "</a>."
        )
        parent.acknowledgementText = _(
            "The method is that of the paper SDFStent (arXiv 2605.22009). This is an independent implementation."
        )
        if hasattr(slicer.modules, "sampledata"):
            # Loaded after start-up, which is not announced again.
            registerSampleData()
        else:
            slicer.app.connect("startupCompleted()", registerSampleData)
