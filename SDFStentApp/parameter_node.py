"""The part of `slicer.parameterNodeWrapper` that the module needs: typed fields of a scripted
module node, bound to widgets.

Covers what panels commonly use: int, float, str, bool, enum, node references and unions of them,
parameter packs (nested by dotted names), lists, `WithinRange`, `Choice`; two-way binding to
widgets. Storage keys follow the real one where it is simple; files are not meant to be exchanged.
"""

import enum
import types
import typing
from dataclasses import dataclass
from functools import cached_property

import slicer
from vtkmodules.vtkCommonCore import vtkCommand, vtkObject

from .connectors import connector as connectorOf


@dataclass(frozen=True)
class WithinRange:
    minimum: float
    maximum: float

    def check(self, value):
        if not self.minimum <= value <= self.maximum:
            raise ValueError(f"Value must be within {self.minimum} and {self.maximum}, got {value}")


@dataclass(frozen=True)
class Choice:
    choices: tuple

    def check(self, value):
        if value not in self.choices:
            raise ValueError(f"Value must be one of {self.choices}, got {value}")


class TypedField:
    """One typed field: it checks a value, writes it to a node and reads it back."""

    def __init__(self, owner, name, hint):
        self.name = name
        self.type, *annotations = (
            typing.get_args(hint) if typing.get_origin(hint) is typing.Annotated else (hint,)
        )
        # Kept, since every access asks for them and they are slow to find out.
        self.isPack, self.isNode = isPack(self.type), _isNodeType(self.type)
        self.isList = typing.get_origin(self.type) is list
        self.validators = [a for a in annotations if hasattr(a, "check")]
        self.default = owner.__dict__.get(name, _emptyValue(self.type))

    def check(self, value):
        for validator in self.validators:
            validator.check(value)
        if self.type is float and isinstance(value, int):
            return float(value)
        if (
            not self.isPack
            and isinstance(self.type, type)
            and typing.get_origin(self.type) is None  # list[str] is a type to Python 3.10
            and not isinstance(value, self.type)
            and not self.isNode
        ):
            raise TypeError(f"{self.name} must be {self.type.__name__}, got {value!r}")
        return value

    def write(self, node, key, value):
        value = self.check(value)
        if self.isPack:
            for field in self.type.allParameters.values():
                field.write(node, f"{key}.{field.name}", getattr(value, field.name))
        elif self.isList:
            values, element = list(value), self.element
            for index in range(len(values), int(node.GetParameter(f"{key}.len") or 0)):
                element.remove(node, f"{key}.{index}")
            for index, item in enumerate(values):
                element.write(node, f"{key}.{index}", item)
            node.SetParameter(f"{key}.len", str(len(values)))
        elif self.isNode:
            node.SetParameter(key, "")
            node.SetNodeReferenceID(key, value.GetID() if value is not None else None)
        else:
            node.SetParameter(key, value.name if isinstance(value, enum.Enum) else str(value))

    def read(self, node, key):
        if self.isPack:
            return self.type._view(node, key)
        if self.isList:
            return [
                self.element.read(node, f"{key}.{i}")
                for i in range(int(node.GetParameter(f"{key}.len") or 0))
            ]
        if self.isNode:
            return node.GetNodeReference(key)
        if not node.HasParameter(key):
            return self.default
        text = node.GetParameter(key)
        if self.type is bool:
            return text == "True"
        return self.type[text] if issubclass(self.type, enum.Enum) else self.type(text)

    def remove(self, node, key):
        if self.isPack:
            for field in self.type.allParameters.values():
                field.remove(node, f"{key}.{field.name}")
        node.UnsetParameter(key)
        if self.isNode:
            node.RemoveNodeReferenceIDs(key)

    def isIn(self, node, key):
        if self.isPack:
            field = next(iter(self.type.allParameters.values()))
            return field.isIn(node, f"{key}.{field.name}")
        return node.HasParameter(f"{key}.len" if self.isList else key)

    @cached_property
    def element(self):
        return TypedField(type("Element", (), {}), self.name, typing.get_args(self.type)[0])

    def startValue(self):
        if self.isPack and self.default is None:
            return self.type()
        return list(self.default) if isinstance(self.default, list) else self.default


def isPack(type_):
    return getattr(type_, "_is_parameterPack", False)


def parameterPack(cls):
    """Class decorator for a value with typed fields, which may be a field of a parameter node or of
    another pack."""
    cls.allParameters = {
        n: TypedField(cls, n, h) for n, h in typing.get_type_hints(cls, include_extras=True).items()
    }
    cls._is_parameterPack = True
    fields = cls.allParameters

    def __init__(self, *args, **values):
        values.update(zip(fields, args, strict=False))
        for name in values:
            if name not in fields:
                raise TypeError(f"{cls.__name__} has no parameter {name!r}")
        for name, field in fields.items():
            object.__setattr__(
                self, name, field.check(values[name]) if name in values else field.startValue()
            )

    def __setattr__(self, name, value):
        if name not in fields:
            raise AttributeError(f"{cls.__name__} has no parameter {name!r}")
        object.__setattr__(self, name, fields[name].check(value))

    cls.__init__, cls.__setattr__ = __init__, __setattr__
    cls._view = _makeView(cls)
    return cls


def _makeView(cls):
    """The class of a pack that lives in a node: its fields are read from the node and written to it
    directly."""

    class PackView(cls):
        def __init__(self, node, key):
            object.__setattr__(self, "_node", node)
            object.__setattr__(self, "_key", key)

        def __getattribute__(self, name):
            fields = cls.allParameters
            if name in fields:
                return fields[name].read(
                    object.__getattribute__(self, "_node"),
                    f"{object.__getattribute__(self, '_key')}.{name}",
                )
            return object.__getattribute__(self, name)

        def __setattr__(self, name, value):
            with slicer.util.NodeModify(self._node):
                cls.allParameters[name].write(self._node, f"{self._key}.{name}", value)

    PackView.__name__ = cls.__name__
    return PackView


def parameterNodeWrapper(cls):
    """Class decorator that gives a class typed fields, stored in a `vtkMRMLScriptedModuleNode`."""
    fields = {
        n: TypedField(cls, n, h) for n, h in typing.get_type_hints(cls, include_extras=True).items()
    }
    members = dict(WrapperMembers.__dict__)
    for name in ("__dict__", "__weakref__", "__doc__", "__module__", "__qualname__"):
        members.pop(name, None)
    for name in fields:
        if name in members:
            raise ValueError(f"Cannot use reserved name '{name}' in a parameterNodeWrapper")
    for name, member in members.items():
        setattr(cls, name, member)
    for name, field in fields.items():
        setattr(cls, name, _property(field))
    cls.allParameters = fields
    return cls


class WrapperMembers:
    """Members that every parameter node class receives."""

    def __init__(self, parameterNode):
        self.parameterNode = parameterNode
        self._bindings, self._updating = {}, False
        with slicer.util.NodeModify(parameterNode):
            for name, field in self.allParameters.items():
                if not field.isIn(parameterNode, name):
                    field.write(parameterNode, name, field.startValue())

    def getValue(self, name):
        value = self
        for part in name.split("."):
            value = getattr(value, part)
        return value

    def setValue(self, name, value):
        *packs, last = name.split(".")
        owner = self
        for part in packs:
            owner = getattr(owner, part)
        setattr(owner, last, value)

    def connectGui(self, gui):
        widgets = [w for w in vars(gui).values() if hasattr(w, "property")]
        names = [(w.property("SlicerParameterName"), w) for w in widgets]
        bound = {n: connectorOf(w, self._field(n)) for n, w in names if n}
        for name, connector in bound.items():
            connector.write(self.getValue(name))
            connector.onChanged(self._callback(name, connector))
        fields = [(name, self._field(name), connector) for name, connector in bound.items()]
        tag = self.AddObserver(vtkCommand.ModifiedEvent, lambda *_: self._updateGui(fields))
        self._bindings[tag] = bound
        return tag

    def disconnectGui(self, tag):
        """Stop following the widgets. As in Slicer 5.10.0, the observer that `connectGui` added
        stays."""
        for connector in self._bindings.pop(tag, {}).values():
            connector.onChanged(None)

    def _field(self, name):
        fields = self.allParameters
        for part in name.split("."):
            if part not in fields:
                raise ValueError(f"Cannot find a param with the given name: {name}")
            field = fields[part]
            fields = getattr(field.type, "allParameters", {})
        return field

    def _callback(self, name, connector):
        def changed():
            if not self._updating:
                self.setValue(name, connector.read())

        return changed

    def _updateGui(self, fields):
        if self._updating:
            return
        self._updating = True
        try:
            with slicer.util.NodeModify(self.parameterNode):
                for name, field, connector in fields:
                    connector.write(field.read(self.parameterNode, name))
        finally:
            self._updating = False

    def StartModify(self):
        return self.parameterNode.StartModify()

    def EndModify(self, wasModified):
        return self.parameterNode.EndModify(wasModified)

    def AddObserver(self, event, callback, priority=0.0):
        return self.parameterNode.AddObserver(event, callback, priority)

    def RemoveObserver(self, tag):
        self.parameterNode.RemoveObserver(tag)

    def Modified(self):
        self.parameterNode.Modified()


def _property(field):
    def write(self, value):
        with slicer.util.NodeModify(self.parameterNode):
            field.write(self.parameterNode, field.name, value)

    return property(lambda self: field.read(self.parameterNode, field.name), write)


def _isNodeType(type_):
    options = (
        [t for t in typing.get_args(type_) if t is not type(None)] if _isUnion(type_) else [type_]
    )
    return all(isinstance(t, type) and issubclass(t, vtkObject) for t in options)


def _isUnion(type_):
    return typing.get_origin(type_) in (typing.Union, types.UnionType)


def _emptyValue(type_):
    if type_ in (int, float, str, bool):
        return type_()
    if typing.get_origin(type_) is list:
        return []
    if isinstance(type_, type) and issubclass(type_, enum.Enum):
        return next(iter(type_))
    return None
