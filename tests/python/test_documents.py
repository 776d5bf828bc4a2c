"""The documents' Python, run on a simulated sequence."""

import pathlib
import re

import numpy as np
import pytest

import holdfast

ROOT = pathlib.Path(__file__).parents[2]


def snippets(document):
    return re.findall(r"```python\n(.*?)```", (ROOT / document).read_text(), re.DOTALL)


@pytest.fixture
def files(box, camera, simulation, tmp_path, monkeypatch):
    """A folder with what the snippets name; its video is a folder of pictures."""
    simulation.save(tmp_path / "sequence")
    (tmp_path / "sequence" / "frames").rename(tmp_path / "video.mp4")
    camera.save(tmp_path / "camera.yml")
    holdfast.save_pose(tmp_path / "pose.txt", simulation.poses[0])
    for name in ("object.obj", "textured.obj"):
        box.save(tmp_path / name)
    monkeypatch.chdir(tmp_path)


def test_readme_tracks_a_video(files, simulation):
    (snippet,) = snippets("README.md")
    names = {}
    exec(snippet, names)
    assert len(names["poses"]) == len(simulation)
    assert all(holdfast.pose_error(a, b)[0] < 0.001 for a, b in zip(simulation.poses, names["poses"]))


def test_the_guide_tracks_a_video(files, simulation):
    track, *others = snippets("docs/python.md")
    names = {}
    exec(track, names)
    assert len(names["results"]) == len(simulation) and all(result.held for result in names["results"])
    for other in others:
        compile(other, "docs/python.md", "exec")  # these need a bag, and ROS


def test_the_packages_own_example(files, capsys):
    (example,) = re.findall(r"\n((?:    .*\n|\n)+)Units", holdfast.__doc__)
    exec(re.sub(r"^    ", "", example, flags=re.MULTILINE), {})
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("0 held") and np.isfinite(float(printed[0].split("[")[1].split()[0]))
