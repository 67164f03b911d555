"""The scroll area in which the application shows the panels of its modules, one at a time."""

from PySide6 import QtWidgets


class ModulePanel:
    """As `qSlicerModulePanel`, of one panel.

    It takes a panel out with `takeAt`, and nobody deletes the item of the layout, to which the panel stays tied. So the item of every later
    visit never hears that sizes have changed, and keeps the height that it was told first for a width.
    """

    def __init__(self, host, panel, width, height):
        self._host, self._panel, self._items = host, panel, []
        self.area, contents = QtWidgets.QScrollArea(), QtWidgets.QWidget()
        self._layout = QtWidgets.QVBoxLayout(contents)
        self._layout.setSizeConstraint(QtWidgets.QLayout.SetMinAndMaxSize)
        self._layout.addWidget(QtWidgets.QWidget())  # help
        self.area.setWidget(contents)
        self.area.setWidgetResizable(True)
        self.area.resize(width, height)
        self.area.show()

    def visit(self):
        """Change over to the panel's module."""
        self._layout.insertWidget(1, self._panel.parent, 1)
        self._panel.parent.setVisible(True)
        self._host.enter(self._panel)

    def leave(self):
        """Change over to another module."""
        parent = self._panel.parent
        self._host.leave(self._panel)
        self._items.append(self._layout.takeAt(self._layout.indexOf(parent)))
        parent.setVisible(False)
        parent.setParent(None)
