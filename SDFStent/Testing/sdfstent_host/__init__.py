"""A stand-in for the Slicer application, for tests of scripted modules without Slicer.

Real: MRML, its logics and displayable managers (package slicer-core), VTK. Stood in for: PythonQt by PySide6, CTK and qMRML
widgets by small look-alikes, and Slicer's Python layer (`slicer.ScriptedLoadableModule`, `slicer.i18n`,
`slicer.parameterNodeWrapper`, `slicer.app`, `slicer.modules`, `SampleData`). It proves wiring, layout, names and logic; it does
not prove PythonQt's own behavior. Nothing in here is shipped.

    host = Host.start()
    module = host.loadModule("SDFStent/SDFStent.py")
    panel = host.openPanel(module)
    host.click(panel.ui.applyButton); host.grab("panel.png")
"""

from .system_libraries import missingLibraries

__all__ = ["Host", "missingLibraries"]


def __getattr__(name):
    # Qt and VTK are loaded only after the system libraries could be asked for.
    if name == "Host":
        from .host import Host

        return Host
    raise AttributeError(name)
