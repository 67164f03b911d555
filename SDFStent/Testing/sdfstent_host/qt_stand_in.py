"""Modules `qt` and `ctk`: PySide6 classes that answer as PythonQt's do.

Each Qt class is wrapped once: its meta-properties become Python attributes while the setters stay callable, and
`connect("signal(types)", function)` works beside `signal.connect(function)`.
"""

import types

from PySide6 import QtCore, QtGui, QtWidgets

from SDFStentApp.widgets import Widget

from .event_loop import QTimer

# Virtual or static methods that share a property's name; PythonQt keeps the method.
NOT_AS_ATTRIBUTE = {"sizeHint", "minimumSizeHint", "singleShot", "objectName"}
VIRTUAL = ("QProgressBar", "text")
"""Qt itself asks Python for it: as an attribute it would ask itself without end."""
_wrapped = {}
QtWidgets.QLineEdit.className = lambda _self: "QLineEdit"  # also of those that Qt makes itself


class SignalStrings:
    """`connect("signal(types)", f)` with as many arguments as the signature names."""

    def connect(self, signature, function):
        name, _, rest = signature.partition("(")
        arguments = rest.rstrip(")").strip()
        signal = getattr(self, name)
        count = len(arguments.split(",")) if arguments else 0

        def slot(*values):
            return function(*values[:count])

        self.__dict__.setdefault("_slots", {})[(signature, function)] = slot
        signal.connect(slot)
        return True

    def disconnect(self, signature, function):
        slot = self.__dict__.get("_slots", {}).pop((signature, function), None)
        if slot is None:
            return False
        getattr(self, signature.partition("(")[0]).disconnect(slot)
        return True


def wrapped(qtClass):
    """The class as PythonQt would show it; the same object each time."""
    if qtClass in _wrapped:
        return _wrapped[qtClass]
    signals = Widget if issubclass(qtClass, Widget) else SignalStrings
    members = {
        "__doc__": qtClass.__doc__,
        "connect": signals.connect,
        "disconnect": signals.disconnect,
    }
    meta = qtClass.staticMetaObject
    for i in range(meta.propertyCount()):
        name = meta.property(i).name()
        if name not in NOT_AS_ATTRIBUTE and (qtClass.__name__, name) != VIRTUAL:
            members[name] = _attribute(name)
    members["objectName"] = members["name"] = _attribute("objectName")
    members["className"] = lambda self: qtClass.__name__
    if hasattr(qtClass, "exec"):
        members["exec_"] = qtClass.exec
    result = type(qtClass.__name__, (qtClass,), members)
    _wrapped[qtClass] = result
    return result


def _attribute(name):
    def read(self):
        return QtCore.QObject.property(self, name)

    def write(self, value):
        if not QtCore.QObject.setProperty(self, name, value):
            raise AttributeError(f"{type(self).__name__}.{name} does not accept {value!r}")

    return property(read, write)


class StandInModule(types.ModuleType):
    """A module whose classes are wrapped at first use."""

    def __init__(self, name, sources):
        super().__init__(name)
        self.__path__ = []
        self._sources = sources

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        for source in self._sources:
            found = getattr(source, name, None)
            if found is not None:
                isObject = isinstance(found, type) and issubclass(found, QtCore.QObject)
                value = wrapped(found) if isObject else found
                setattr(self, name, value)
                return value
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


def qtModule():
    return StandInModule("qt", (types.SimpleNamespace(QTimer=QTimer), QtWidgets, QtGui, QtCore))


def ctkModule():
    from . import skins

    return StandInModule("ctk", (types.SimpleNamespace(**skins.CTK),))
