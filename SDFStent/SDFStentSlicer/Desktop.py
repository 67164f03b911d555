"""Desktop of the module: questions for files, cells of tables, keys. Qt's in Slicer, another one where an application has it."""


class QtDesktop:
    """Qt's dialogs, table cells and shortcuts; questions are answered with "" or () by a user who cancels."""

    def __init__(self):
        import qt

        self._qt = qt

    def openFile(self, parent, title, kinds):
        """Path of an existing file by the user's choice. `kinds` is Qt's filter, such as "Plan (*.json)"."""
        return self._qt.QFileDialog.getOpenFileName(parent, title, "", kinds)

    def openFiles(self, parent, title, kinds):
        """The paths of files that are there."""
        return self._qt.QFileDialog.getOpenFileNames(parent, title, "", kinds)

    def saveFile(self, parent, title, name, kinds):
        """The path of a file to write; `name` is proposed."""
        return self._qt.QFileDialog.getSaveFileName(parent, title, name, kinds)

    def folder(self, parent, title):
        """Path of an existing folder by the user's choice."""
        return self._qt.QFileDialog.getExistingDirectory(parent, title)

    def show(self, path):
        """Open a file with the program that the desktop has for it."""
        self._qt.QDesktopServices.openUrl(self._qt.QUrl.fromLocalFile(str(path)))

    def cell(self, text="", isSelectable=True, isEditable=False, isChecked=None):
        """A cell of a table; it has a box to check unless `isChecked` is None."""
        kinds, cell = self._qt.Qt, self._qt.QTableWidgetItem(text)
        flags = kinds.ItemIsEnabled
        for isWanted, flag in (
            (isSelectable, kinds.ItemIsSelectable),
            (isEditable, kinds.ItemIsEditable),
            (isChecked is not None, kinds.ItemIsUserCheckable),
        ):
            flags = flags | flag if isWanted else flags
        cell.setFlags(flags)
        if isChecked is not None:
            cell.setCheckState(kinds.Checked if isChecked else kinds.Unchecked)
        return cell

    def isChecked(self, cell):
        """Whether the box of a cell is checked."""
        return cell.checkState() == self._qt.Qt.Checked

    def fitColumns(self, table):
        """Let the first column, with the names, have the room that the others leave, which are as wide as what they hold."""
        header = table.horizontalHeader()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(self._qt.QHeaderView.ResizeToContents)
        header.setSectionResizeMode(0, self._qt.QHeaderView.Stretch)

    def onKey(self, key, widget, action, isEverywhere=False):
        """Call `action` at a key, in a widget with its children or everywhere in the application; the shortcut's `setEnabled` turns it off."""
        shortcut = self._qt.QShortcut(self._qt.QKeySequence(key), widget)
        where = self._qt.Qt
        shortcut.setContext(
            where.ApplicationShortcut if isEverywhere else where.WidgetWithChildrenShortcut
        )
        shortcut.connect("activated()", action)
        return shortcut

    def onEvent(self, widget, kind, action):
        """Call `action()` at every event of a kind, such as "Resize", of a widget. Keep what is returned; call it to have no more of it."""
        wanted = getattr(self._qt.QEvent, kind)

        class EventFilter(self._qt.QObject):
            def eventFilter(self, _watched, event):
                if event.type() == wanted:
                    action()
                return False

        watch = EventFilter()
        widget.installEventFilter(watch)
        return lambda: widget.removeEventFilter(watch)

    def layOut(self):
        """Let layouts hear of changes, which they do one within the other, each by an event."""
        self._qt.QCoreApplication.sendPostedEvents(None, self._qt.QEvent.LayoutRequest)


_kinds, _made = [QtDesktop], []


def desktop():
    """Desktop in use."""
    if not _made:
        _made.append(_kinds[-1]())
    return _made[-1]


def use(kind):
    """Use a desktop of another class from now on, for an application without Qt; it is made without arguments and asked as `QtDesktop`."""
    _kinds[:], _made[:] = [kind], []
