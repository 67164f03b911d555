"""The section Place of the panel: the lesion or the branch at which the selected stent is. All else in it is bound to parameters."""

import contextlib

from slicer.i18n import tr as _

from SDFStentLib.report import degree_word
from SDFStentLib.stent import AtLesion, OnBranch
from SDFStentLib.validation import InputError

from . import Sizes
from .ParameterNode import stentOf
from .PlanFields import Placement

BY_RULE = -100.0
"""Stands in the panel for an offset that follows from lesion and stent, mm."""


class PlaceSection:
    """Shows where the selected stent is, by what the vessel has, and sets what the user changes.

    `attempt(action)` does what is asked for and says why when it cannot be done.
    """

    def __init__(self, ui, logic, attempt):
        self.ui, self._logic, self._attempt = ui, logic, attempt
        self._parameterNode, self._updating = None, False
        ui.landmarkComboBox.connect("activated(int)", lambda _index: self._set())
        ui.landmarkSpinBox.connect("valueChanged(double)", lambda _value: self._set())

    def show(self, parameterNode):
        """The stent that is selected now."""
        self._parameterNode = parameterNode
        stent, ui = stentOf(parameterNode), self.ui
        isShown = stent.placement.isOfVessel
        for widget in (ui.landmarkComboBoxLabel, ui.landmarkComboBox, ui.landmarkSpinBox):
            widget.visible = isShown
        if not isShown:
            return
        place = Sizes.landmarkOf(stent)
        landmarks = self._logic.landmarks(parameterNode)
        texts, index, value = _shown(stent.placement, place, landmarks)
        self._updating = True
        try:
            box = ui.landmarkComboBox
            if texts != [box.itemText(number) for number in range(box.count)]:
                box.clear()
                for text in texts:
                    box.addItem(text)
            box.currentIndex = index
            isLesion = stent.placement == Placement.AT_LESION
            ui.landmarkSpinBox.minimum = BY_RULE if isLesion else 0.0
            ui.landmarkSpinBox.specialValueText = _("as it fits") if isLesion else ""
            ui.landmarkSpinBox.value = value
        finally:
            self._updating = False
        ui.landmarkComboBox.enabled = ui.landmarkSpinBox.enabled = landmarks is not None

    def _set(self):
        if self._updating or self._parameterNode is None:
            return
        index, value = self.ui.landmarkComboBox.currentIndex, self.ui.landmarkSpinBox.value
        if index < 0:
            return
        if stentOf(self._parameterNode).placement == Placement.AT_LESION:
            place = AtLesion(index + 1, None if value <= BY_RULE else value)
        else:
            place = OnBranch(index + 1, value)
        self._attempt(lambda: self._logic.setLandmark(self._parameterNode, place))


def _shown(kind, place, landmarks):
    """Texts to choose from, the index of the one that is chosen, -1 for none, and the number beside it."""
    if landmarks is None:
        return [], -1, 0.0
    if kind == Placement.AT_LESION:
        texts = [
            _("{number} {branch}, {degree}").format(
                number=number, branch=one.branch_name, degree=degree_word(one.percent_diameter)
            )
            for number, one in enumerate(landmarks.lesions, 1)
        ]
        index = -1 if place is None else min(place.number, len(texts) + 1) - 1
        isGiven = place is not None and place.offset is not None
        value = place.offset if isGiven else BY_RULE
    else:
        texts = list(landmarks.branch_names)
        index, value = -1, 0.0
        if place is not None:
            with contextlib.suppress(InputError):  # a branch that is not there: deploying tells it
                index, value = landmarks.branch(place.branch), landmarks.along(place)
    return texts, index if index < len(texts) else -1, value
