"""The package as a whole: what importing it brings, and what editors see of it."""

import ast
import inspect
import pathlib
import subprocess
import sys

import pytest

import holdfast
from holdfast import _core


def test_import_is_fast_and_brings_numpy_at_most():
    code = (
        "import sys, time; start = time.process_time(); import holdfast; seconds = time.process_time() - start;"
        "heavy = {'matplotlib', 'rerun', 'rosbags', 'cv2', 'scipy', 'PIL', 'pytest'} & set(sys.modules);"
        "print(seconds, *heavy)"
    )
    seconds = []
    for _ in range(3):
        output = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=True).stdout
        taken, *heavy = output.split()
        assert not heavy
        seconds.append(float(taken))
    assert min(seconds) < 1.0


def test_nothing_is_left_at_exit():
    code = "import holdfast; box = holdfast.textured_box(); camera = holdfast.Camera(300, 300, 160, 120, 320, 240)"
    done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == ""  # nanobind tells of objects that are never freed


def test_types_are_right(tmp_path):
    pytest.importorskip("mypy")
    package = pathlib.Path(holdfast.__file__).parent
    done = subprocess.run(
        [sys.executable, "-B", "-m", "mypy", "-p", "holdfast", "--cache-dir", tmp_path],
        cwd=package.parent, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("mode", ["default", "fast", "paper"])
def test_annotated_options_are_the_options(mode):
    options = holdfast.default_options(mode)
    assert set(holdfast.TrackerOptions.__annotations__) == set(options)
    assert set(holdfast.OcclusionOptions.__annotations__) == set(options["occlusion"])


def test_all_that_is_public_has_a_docstring():
    assert set(holdfast.__all__) <= set(dir(holdfast))
    for name in holdfast.__all__:
        value = getattr(holdfast, name)
        if not inspect.isclass(value) and not callable(value):
            continue
        assert value.__doc__, name
        if not inspect.isclass(value):
            continue
        for member, attribute in vars(value).items():
            if callable(attribute) and not member.startswith("_") and not issubclass(value, (dict, BaseException)):
                assert attribute.__doc__, f"{name}.{member}"


def test_stub_names_what_the_module_has():
    stub = pathlib.Path(_core.__file__).with_name("_core.pyi")
    tree = ast.parse(stub.read_text())
    named = {node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    assert {name for name in dir(_core) if not name.startswith("_")} - {"version"} <= named
    tracker = next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "Tracker")
    track = next(node for node in tracker.body if isinstance(node, ast.FunctionDef) and node.name == "track")
    assert [argument.arg for argument in track.args.args] == ["self", "frame", "time", "format"]
    assert ast.get_docstring(track)
