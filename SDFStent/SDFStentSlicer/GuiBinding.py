"""Parameters and widgets bound to each other, and parted again without a trace."""


class GuiBinding:
    """Binds the widgets of `ui` to a parameter node until `release`.

    Slicer 5.10.0 leaves an observer on the node at every `disconnectGui`: changes become slower with every visit of the panel,
    and the observer of a parameter node that nobody holds any more crashes. So what `connectGui` adds is remembered here.
    """

    def __init__(self, parameterNode, ui):
        self._parameterNode, self._tags = parameterNode, []
        addObserver = parameterNode.AddObserver

        def remembered(*arguments):
            self._tags.append(addObserver(*arguments))
            return self._tags[-1]

        parameterNode.AddObserver = remembered  # of this object only, and only while it connects
        try:
            self._guiTag = parameterNode.connectGui(ui)
        finally:
            del parameterNode.AddObserver

    def release(self):
        """Part them; an observer that Slicer has removed itself is removed once more, which does nothing."""
        self._parameterNode.disconnectGui(self._guiTag)
        for tag in self._tags:
            self._parameterNode.RemoveObserver(tag)
