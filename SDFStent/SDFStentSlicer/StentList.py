"""The plan's ordered list of stents in a parameter node; one of them is selected for editing."""

from SDFStentLib.plan import NEW_STENT
from SDFStentLib.validation import InputError

from .ParameterNode import stentsOf
from .PlanFields import entryOf


class StentList:
    """Adds, copies, removes, moves and selects stents of one parameter node.

    Stents are entries of the plan's document here, each with its node as `handle`; changes may be called as Python code calls them.
    """

    def __init__(self, parameterNode):
        self.parameterNode = parameterNode

    def values(self):
        """Stents as dictionaries, in order."""
        return [{**one.draft.entry, "handle": one.handle} for one in stentsOf(self.parameterNode)]

    def __len__(self):
        return len(stentsOf(self.parameterNode))

    def add(self, **values):
        """Append a stent and select it."""
        if "name" not in values:
            values.setdefault("label", self.freeLabel())
        self.replace([*self.values(), values], len(self))

    def freeLabel(self):
        """A name that no stent of the list has yet."""
        labels = {one.label for one in stentsOf(self.parameterNode)}
        number = len(self) + 1
        # Ends, since there are finitely many labels.
        while f"Stent {number}" in labels:
            number += 1
        return f"Stent {number}"

    def copy(self, handle):
        """Append a copy of the selected stent that has a handle of its own, and select it."""
        selected = self.values()[self.parameterNode.selected]
        self.add(**{**selected, "handle": handle, "name": self.freeLabel()})

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
        """Change values of the selected stent."""
        selected = self.parameterNode.selected
        if not 0 <= selected < len(self):
            raise InputError("Stent: expected one that is selected, got none; add one.")
        changes = entryOf(values)
        self.parameterNode.change({f"stents.{selected}.{key}": changes[key] for key in changes})

    def select(self, index):
        """Make one stent the edited one."""
        if index != self.parameterNode.selected:
            self.parameterNode.selected = index

    def enable(self, index, enabled):
        """Switch a stent on or off."""
        if stentsOf(self.parameterNode)[index].enabled != enabled:
            self.parameterNode.change({f"stents.{index}.enabled": enabled})

    def replace(self, stents, selected):
        """Set the whole list (dictionaries) and the selected index in one modification."""
        entries = [{**NEW_STENT, **entryOf(values)} for values in stents]
        handles = [entry.pop("handle", None) for entry in entries]
        self.parameterNode.replaceStents(entries, handles, selected)
