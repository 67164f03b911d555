"""The section Place of the panel: the lesion or the branch at which the selected stent is. All else in it is bound to the plan."""

import contextlib

from slicer.i18n import tr as _

from SDFStentLib.report import lesion_facts
from SDFStentLib.validation import InputError

from .ParameterNode import SELECTED, stentOf
from .PlanFields import Placement

BY_RULE = -100.0
"""Stands in the panel for an offset that follows from lesion and stent, mm."""


class PlaceSection:
    """Shows where the selected stent is, by what the vessel has, and sets what the user changes."""

    def __init__(self, ui, logic, _attempt):
        self.ui, self._logic = ui, logic
        self._parameterNode, self._updating = None, False
        self._lesions, self._texts = (), []
        ui.landmarkComboBox.connect("activated(int)", lambda _index: self._set())
        ui.landmarkSpinBox.connect("valueChanged(double)", lambda _value: self._set())

    def show(self, parameterNode):
        """Show the place of the selected stent."""
        self._parameterNode = parameterNode
        stent, ui = stentOf(parameterNode), self.ui
        isShown = stent.placement.isOfVessel
        for widget in (ui.landmarkComboBoxLabel, ui.landmarkComboBox, ui.landmarkSpinBox):
            widget.visible = isShown
        if not isShown:
            return
        isLesion = stent.placement == Placement.AT_LESION
        landmarks = self._logic.landmarks(parameterNode)
        texts, index, value = [], -1, 0.0
        if landmarks is not None:
            shown = self._atLesion if isLesion else self._onBranch
            texts, index, value = shown(stent.draft.place, landmarks)
        self._updating = True
        try:
            box = ui.landmarkComboBox
            if texts != [box.itemText(number) for number in range(box.count)]:
                box.clear()
                for text in texts:
                    box.addItem(text)
            box.currentIndex = index if index < len(texts) else -1
            ui.landmarkSpinBox.minimum = BY_RULE if isLesion else 0.0
            ui.landmarkSpinBox.specialValueText = _("as it fits") if isLesion else ""
            ui.landmarkSpinBox.value = value
        finally:
            self._updating = False
        ui.landmarkComboBox.enabled = ui.landmarkSpinBox.enabled = landmarks is not None

    def _atLesion(self, place, landmarks):
        """Texts to choose from, the index of the chosen one, -1 for none, and the number beside it."""
        if landmarks.lesions is not self._lesions:
            found = [lesion_facts(number, one) for number, one in enumerate(landmarks.lesions, 1)]
            self._lesions, self._texts = landmarks.lesions, [_textOf(facts) for facts in found]
        index = -1 if place is None else place.number - 1
        isGiven = place is not None and place.offset is not None
        return self._texts, index, place.offset if isGiven else BY_RULE

    @staticmethod
    def _onBranch(place, landmarks):
        texts = list(landmarks.branch_names)
        if place is not None:
            with contextlib.suppress(InputError):  # a branch that is not there: deploying tells it
                return texts, landmarks.branch(place.branch), landmarks.along(place)
        return texts, -1, 0.0

    def _set(self):
        if self._updating or self._parameterNode is None:
            return
        index, value = self.ui.landmarkComboBox.currentIndex, self.ui.landmarkSpinBox.value
        if index < 0:
            return
        place = {"branch": index + 1, "distance": value}
        if stentOf(self._parameterNode).placement == Placement.AT_LESION:
            place = {"lesion": index + 1, **({} if value <= BY_RULE else {"offset": value})}
        self._parameterNode.change({f"{SELECTED}placement": place})


def _textOf(facts):
    return _("{number} {branch}, {degree}").format(
        number=facts.value("number"),
        branch=facts.value("branch_name"),
        degree=facts.named("percent_diameter").in_few,
    )
