"""The part of `slicer.parameterNodeWrapper` that the module needs: typed fields of a scripted
module node.

Covers float, str, bool, enum, node references and unions of them, and `WithinRange`. Storage keys
follow the real one where it is simple; files are not meant to be exchanged.
"""

import enum
import types
import typing
from dataclasses import dataclass

import slicer
from vtkmodules.vtkCommonCore import vtkObject


@dataclass(frozen=True)
class WithinRange:
    minimum: float
    maximum: float

    def check(self, value):
        if not self.minimum <= value <= self.maximum:
            raise ValueError(f"Value must be within {self.minimum} and {self.maximum}, got {value}")


class TypedField:
    """A typed field: it checks a value, writes it to a node and reads it back."""

    def __init__(self, owner, name, hint):
        self.name = name
        self.type, *annotations = (
            typing.get_args(hint) if typing.get_origin(hint) is typing.Annotated else (hint,)
        )
        # Kept, since every access asks for it and it is slow to find out.
        self.isNode = _isNodeType(self.type)
        self.validators = [a for a in annotations if hasattr(a, "check")]
        self.default = owner.__dict__.get(name, _emptyValue(self.type))

    def check(self, value):
        for validator in self.validators:
            validator.check(value)
        if self.type is float and isinstance(value, int):
            return float(value)
        if not self.isNode and not isinstance(value, self.type):
            raise TypeError(f"{self.name} must be {self.type.__name__}, got {value!r}")
        return value

    def write(self, node, value):
        value = self.check(value)
        if self.isNode:
            node.SetParameter(self.name, "")
            node.SetNodeReferenceID(self.name, value.GetID() if value is not None else None)
        else:
            text = value.name if isinstance(value, enum.Enum) else str(value)
            node.SetParameter(self.name, text)

    def read(self, node):
        if self.isNode:
            return node.GetNodeReference(self.name)
        if not node.HasParameter(self.name):
            return self.default
        text = node.GetParameter(self.name)
        if self.type is bool:
            return text == "True"
        return self.type[text] if issubclass(self.type, enum.Enum) else self.type(text)


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
        with slicer.util.NodeModify(parameterNode):
            for name, field in self.allParameters.items():
                if not parameterNode.HasParameter(name):
                    field.write(parameterNode, field.default)

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
            field.write(self.parameterNode, value)

    return property(lambda self: field.read(self.parameterNode), write)


def _isNodeType(type_):
    options = (
        [t for t in typing.get_args(type_) if t is not type(None)] if _isUnion(type_) else [type_]
    )
    return all(isinstance(t, type) and issubclass(t, vtkObject) for t in options)


def _isUnion(type_):
    return typing.get_origin(type_) in (typing.Union, types.UnionType)


def _emptyValue(type_):
    if type_ in (float, str, bool):
        return type_()
    if isinstance(type_, type) and issubclass(type_, enum.Enum):
        return next(iter(type_))
    return None
