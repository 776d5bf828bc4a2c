"""Messages for calls whose arguments do not fit, in place of nanobind's, which name no argument."""

from __future__ import annotations

import ast
import enum
import functools
import inspect
import numbers
import types
from typing import Any, Callable

#: Tests of annotations.
KINDS: dict[str, Callable[[Any], bool]] = {
    "None": lambda value: value is None,
    "bool": lambda value: isinstance(value, bool),
    "bytes": lambda value: isinstance(value, bytes),
    "dict": lambda value: isinstance(value, dict),
    "float": lambda value: isinstance(value, numbers.Real),
    "int": lambda value: isinstance(value, numbers.Integral),
    "os.PathLike": lambda value: hasattr(value, "__fspath__"),
    "str": lambda value: isinstance(value, str),
}

#: Advice for arguments of a class.
ADVICE = {
    "Camera": "Camera.load() reads a file, Camera.from_matrix() takes a 3x3 matrix",
    "Device": "Device('cpu') opens one",
    "FrameResult": "Tracker.track() returns one",
    "Mesh": "Mesh.load() reads a file, as_mesh() takes arrays too",
    "Tracker": "Tracker(model, camera) makes one",
}


def name_arguments(module: types.ModuleType) -> None:
    """Makes the functions and methods of the extension module name the argument that does not fit."""
    for name, value in list(vars(module).items()):
        if not inspect.isclass(value):
            _replace(module, module, name, value)
        elif not issubclass(value, enum.Enum):
            for member, attribute in list(vars(value).items()):
                _replace(module, value, member, attribute)


def _replace(module: types.ModuleType, owner: Any, name: str, function: Any) -> None:
    if not hasattr(function, "__nb_signature__") or (name[:2] == "__" and name not in ("__init__", "__getitem__")):
        return
    shown = owner.__name__ if name == "__init__" else name
    try:
        signature = _signature(function)
    except (AssertionError, IndexError, SyntaxError, TypeError, ValueError):
        return  # a nanobind that writes signatures in another way: its own messages stay

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except TypeError as error:
            if "incompatible function arguments" not in str(error):
                raise
        raise TypeError(_message(module, shown, signature, args, kwargs))

    call.__signature__ = signature  # type: ignore[attr-defined]
    is_static = owner is not module and "self" not in signature.parameters
    setattr(owner, name, staticmethod(call) if is_static else call)


def _signature(function: Any) -> inspect.Signature:
    text, _, defaults = function.__nb_signature__[0]
    called, _, returned = text.replace("holdfast._core.", "").rpartition(" -> ")  # arrays returned are no Python
    head = ast.parse(called.replace("\\", "DEFAULT_") + ": ...").body[0]
    assert isinstance(head, ast.FunctionDef)
    first_default = len(head.args.args) - len(head.args.defaults)
    parameters = []
    for i, each in enumerate(head.args.posonlyargs + head.args.args):
        default: Any = inspect.Parameter.empty
        if i >= first_default:
            value = head.args.defaults[i - first_default]
            is_object = isinstance(value, ast.Name) and value.id.startswith("DEFAULT_")
            default = defaults[int(ast.unparse(value)[8:])] if is_object else ast.literal_eval(value)
        annotation = ast.unparse(each.annotation) if each.annotation else inspect.Parameter.empty
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        parameters.append(inspect.Parameter(each.arg, kind, default=default, annotation=annotation))
    if head.args.kwarg:
        parameters.append(inspect.Parameter(head.args.kwarg.arg, inspect.Parameter.VAR_KEYWORD))
    return inspect.Signature(parameters, return_annotation=returned)


def _message(
    module: types.ModuleType, name: str, signature: inspect.Signature, args: tuple, kwargs: dict[str, Any]
) -> str:
    try:
        given = signature.bind(*args, **kwargs).arguments
    except TypeError as error:
        return f"{name}(): {error}; arguments: {', '.join(each for each in signature.parameters if each != 'self')}"
    for argument, value in given.items():
        expected = signature.parameters[argument].annotation
        if argument != "self" and isinstance(expected, str) and not _fits(module, value, expected):
            return f"{argument}: expected {expected}, got {_described(value)}{_advice(module, expected)}"
    annotations = [str(signature.parameters[argument].annotation) for argument in given]
    is_sure = not any("[" in each and not each.startswith("numpy.typing.") for each in annotations)
    for argument, value in given.items():
        if is_sure and isinstance(value, numbers.Integral) and not 0 <= int(value) < 2**31:
            return f"{argument}: {value} is out of range"
    return f"{name}(): arguments do not fit: {name}{signature}"


def _fits(module: types.ModuleType, value: Any, expected: str) -> bool:
    if "[" in expected or "ArrayLike" in expected:  # arrays and sequences: only None is refused for sure
        return value is not None or expected.endswith("| None")
    return any(_is(module, value, kind) for kind in expected.split(" | "))


def _is(module: types.ModuleType, value: Any, kind: str) -> bool:
    if kind in KINDS:
        return KINDS[kind](value)
    known = getattr(module, kind, None)
    return not inspect.isclass(known) or isinstance(value, known)  # nothing is said against what is not known


def _described(value: Any) -> str:
    if hasattr(value, "dtype") and getattr(value, "shape", ()) != ():
        return f"{value.dtype} array of shape {value.shape}"
    text = str(value) if isinstance(value, numbers.Number) else repr(value)  # numpy's numbers name their type in repr
    is_short = isinstance(value, (str, bytes, numbers.Number)) and len(text) < 60
    return type(value).__name__ + (f" {text}" if is_short else "")


def _advice(module: types.ModuleType, expected: str) -> str:
    for kind in expected.split(" | "):
        known = getattr(module, kind, None)
        if inspect.isclass(known) and issubclass(known, enum.Enum):
            return f"; there are: {', '.join(str(each) for each in known)}"
        if kind in ADVICE:
            return f"; {ADVICE[kind]}"
    return ""
