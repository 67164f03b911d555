"""The plan's ordered list of stents in a parameter node; one of them is selected for editing."""

import slicer

from SDFStentLib.validation import InputError

from .ParameterNode import StentParameters, stentOf, stentsOf, stentValues


class StentList:
    """Adds, copies, removes, moves and selects stents of one parameter node.

    The panel edits `parameterNode.stent`; `synchronize` copies the latest change, of the list or of the edited stent,
    to the other.
    """

    def __init__(self, parameterNode):
        self.parameterNode = parameterNode
        self._agreed = None

    def values(self):
        """All stents as dictionaries, in order."""
        return [dict(vars(stent)) for stent in stentsOf(self.parameterNode)]

    def __len__(self):
        return len(self.parameterNode.stents)

    def add(self, **values):
        """Append a stent and select it."""
        stents = self.values()
        values.setdefault("label", self._freeLabel(stents))
        stents.append(stentValues(StentParameters(**values)))
        self.replace(stents, len(stents) - 1)

    def freeLabel(self):
        """A name that no stent of the list has yet."""
        return self._freeLabel(self.values())

    def copy(self, handle):
        """Append a copy of the selected stent that has a handle of its own, and select it."""
        stents = self.values()
        stents.append(
            {
                **stents[self.parameterNode.selected],
                "handle": handle,
                "label": self._freeLabel(stents),
            }
        )
        self.replace(stents, len(stents) - 1)

    def remove(self):
        """Remove the selected stent; its neighbor is selected."""
        stents, selected = self.values(), self.parameterNode.selected
        stents.pop(selected)
        self.replace(stents, min(selected, len(stents) - 1))

    def move(self, offset):
        """Move the selected stent by some places, as far as the list goes."""
        stents, selected = self.values(), self.parameterNode.selected
        target = min(max(selected + offset, 0), len(stents) - 1)
        stents.insert(target, stents.pop(selected))
        self.replace(stents, target)

    def change(self, **values):
        """Change values of the selected stent, as it is edited."""
        stents, selected = self.values(), self.parameterNode.selected
        if not 0 <= selected < len(stents):
            raise InputError("Stent: expected one that is selected, got none; add one.")
        stents[selected] = {**stentValues(self.parameterNode.stent), **values}
        self.replace(stents, selected)

    def select(self, index):
        """Make one stent the edited one."""
        if index != self.parameterNode.selected:
            self.replace(self.values(), index)

    def enable(self, index, enabled):
        """Switch a stent on or off."""
        stents = self.values()
        if stents[index]["enabled"] != enabled:
            stents[index]["enabled"] = enabled
            self.replace(stents, self.parameterNode.selected)

    def replace(self, stents, selected):
        """Set the whole list (dictionaries) and the selected index in one modification."""
        parameterNode = self.parameterNode
        with slicer.util.NodeModify(parameterNode):
            parameterNode.stents = [StentParameters(**values) for values in stents]
            parameterNode.selected = selected
            if 0 <= selected < len(stents) and vars(stentOf(parameterNode)) != stents[selected]:
                parameterNode.stent = StentParameters(**stents[selected])
            self._agreed = stents[selected] if 0 <= selected < len(stents) else None

    def synchronize(self):
        """Make the list and the edited stent agree again; returns whether something had to change."""
        stents, selected = self.values(), self.parameterNode.selected
        if not 0 <= selected < len(stents):
            if stents:
                self.replace(stents, 0)
            return bool(stents)
        listed, edited = stents[selected], dict(vars(stentOf(self.parameterNode)))
        if listed == edited:
            self._agreed = listed
            return False
        if listed == self._agreed:  # the panel changed the edited stent
            stents[selected] = edited
        self.replace(stents, selected)
        return True

    @staticmethod
    def _freeLabel(stents):
        labels = {values["label"] for values in stents}
        number = len(stents) + 1
        # Ends, since there are finitely many labels.
        while f"Stent {number}" in labels:
            number += 1
        return f"Stent {number}"
