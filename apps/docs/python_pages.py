#!/usr/bin/env python3
"""python_pages.py PACKAGE OUT: the Python package as pages, by pdoc. The extension module's part is taken from its stub,
whose signatures are Python's."""

import __future__
import pathlib
import sys
import types
import typing

import numpy.typing


class ArrayLike:
    """Stands for numpy's, whose long definition would be printed in its place."""


class NDArray(typing.Generic[typing.TypeVar("Scalar")]):
    """Likewise."""


ArrayLike.__module__ = NDArray.__module__ = "numpy.typing"
numpy.typing.ArrayLike, numpy.typing.NDArray = ArrayLike, NDArray


def load_stub(path):
    module = sys.modules["holdfast._core"] = types.ModuleType("holdfast._core")
    exec(compile(path.read_text(), path, "exec", __future__.annotations.compiler_flag), vars(module))
    return module


package = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(package))
sys.dont_write_bytecode = True
core = load_stub(package / "holdfast" / "_core.pyi")

import holdfast  # noqa: E402
import pdoc  # noqa: E402
import pdoc.render  # noqa: E402

# A page shows what a class has of its own; the tracker has its methods from the class that it extends.
for name, member in vars(core.Tracker).items():
    if not name.startswith("_"):
        setattr(holdfast.Tracker, name, member)

pdoc.render.configure(show_source=False)
modules = ("holdfast", "holdfast.plot", "holdfast.view", "holdfast.bag", "holdfast.geometry")
pdoc.pdoc(*modules, output_directory=pathlib.Path(sys.argv[2]))
