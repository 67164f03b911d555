"""What the last deployment is beside surface and numbers: the device as a file, and networks for a 0D solver."""

from pathlib import Path

from slicer.i18n import tr as _

from SDFStentLib.files import (
    check_suffix,
    check_writable,
    read_surface,
    write_bytes,
)
from SDFStentLib.flow import networks_of
from SDFStentLib.plan import device_vtp
from SDFStentLib.report import document_json
from SDFStentLib.validation import InputError

from . import Conversion, Display


class Exporting:
    """A part of `SDFStentLogic`: writes files of the last deployment."""

    def writeDevice(self, path, parameterNode):
        """Write the stents as VTP, as `sdfstent deploy --export-device` does: rings and struts, or the mesh that is chosen.

        In world coordinates, mm. Raises `InputError` with a sentence, as where the plan was not deployed as it is now.
        """
        check_suffix(path, _("a device"), (".vtp",))
        node = parameterNode.deviceMesh
        mesh = None if node is None else Conversion.stentMesh(node)
        content = device_vtp(self._deployed(parameterNode), mesh, frame="RAS")
        _write(path, content, parameterNode)

    def write0D(self, path, parameterNode):
        """Write the stented vessel as a network for svZeroDSolver, and beside it that before, as `--export-0d` does; errors as above."""
        check_suffix(path, _("a network"), (".json",))
        self._deployed(parameterNode)
        answer = self.lastRun(parameterNode).flow
        if answer is None:
            raise InputError(
                _(
                    "Results: expected a flow, without which there is no network, got none; set the flow first."
                )
            )
        before, after = map(document_json, networks_of(answer))
        path = Path(path)
        _write(path.with_stem(f"{path.stem}_before"), before.encode(), parameterNode)
        _write(path, after.encode(), parameterNode)

    def loadDeviceMesh(self, path, parameterNode):
        """Add a straight stent mesh from a file to the scene as it is in there, mm, and choose it; returns its node."""
        surface = read_surface(path, "mm").surface
        parameterNode.deviceMesh = Display.addMesh(parameterNode, path, surface)
        return parameterNode.deviceMesh

    def isDeployed(self, parameterNode):
        """Whether there is a deployment that was measured."""
        run = self.lastRun(parameterNode)
        return run is not None and run.result is not None

    def _deployed(self, parameterNode):
        if not self.isDeployed(parameterNode) or self.hasChanged(parameterNode):
            raise InputError(
                _(
                    "Results: expected the plan deployed as it is now, it is not; click Deploy first."
                )
            )
        return self.lastRun(parameterNode).result


def _write(path, content, parameterNode):
    write_bytes(check_writable(path), content)
    parameterNode.status = _("Wrote {path}.").format(path=path)
