"""The documents: their commands and their Python are run on a simulated sequence, their links lead somewhere, and what
commands write in them is what they would write now. C++ and C: tests/consumer."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import types
import urllib.parse

import numpy as np
import pytest

import holdfast

ROOT = pathlib.Path(__file__).parents[2]
PAGES = ["README.md", *sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md"))]


def blocks(page, language):
    return re.findall(r"^```{}\n(.*?)^```".format(language), (ROOT / page).read_text(), re.DOTALL | re.MULTILINE)


def pages_with(language):
    return [page for page in PAGES if blocks(page, language)]


@pytest.fixture(scope="module")
def files(box, camera, simulation, tmp_path_factory):
    """A folder with what the examples name; its videos are folders of pictures."""
    folder = tmp_path_factory.mktemp("documents")
    simulation.save(folder / "sequence")
    shutil.move(folder / "sequence" / "frames", folder / "video.mp4")
    shutil.move(folder / "sequence" / "poses_gt.txt", folder / "truth.txt")
    camera.save(folder / "camera.yml")
    for name in ("pose.txt", "guide.txt"):
        holdfast.save_pose(folder / name, simulation.poses[0])
    for name in ("object.obj", "textured.obj"):
        box.save(folder / name)
    holdfast.Mesh(box.vertices, box.faces).save(folder / "plain.obj")
    corners = np.unique(box.vertices, axis=0).astype(float)
    pixels = camera.project(corners @ simulation.poses[0][:3, :3].T + simulation.poses[0][:3, 3])
    lines = ["{},{},{},{},{}".format(*row) for row in np.hstack([corners, pixels])]
    (folder / "points.csv").write_text("\n".join(["x,y,z,u,v", *lines]))
    recordings = next(text for text in blocks("docs/guide/many_recordings.md", "text") if "\t" in text)
    (folder / "recordings.tsv").write_text(recordings)
    for line in recordings.splitlines():
        name, video, _, _, pose = line.split("\t")
        (folder / video).symlink_to("video.mp4")
        (folder / pose).symlink_to("pose.txt")
    return folder


@pytest.fixture
def here(files, tmp_path, monkeypatch):
    """A copy of that folder, where the example is run."""
    shutil.copytree(files, tmp_path / "run", symlinks=True)
    monkeypatch.chdir(tmp_path / "run")


@pytest.mark.parametrize("page", pages_with("sh"))
def test_commands_run(page, here, program, tmp_path):
    programs = tmp_path / "programs"
    programs.mkdir()
    (programs / "holdfast").symlink_to(os.environ["HOLDFAST_PROGRAM"])
    (programs / "holdfast-batch").symlink_to(ROOT / "apps" / "batch" / "holdfast-batch")
    environment = dict(os.environ, PATH="{}:{}".format(programs, os.environ["PATH"]))
    for block in blocks(page, "sh"):
        done = subprocess.run(["sh", "-eu", "-c", block], env=environment, capture_output=True, text=True)
        assert done.returncode == 0, block + done.stdout + done.stderr
        for name in re.findall(r"--(?:pose|picture|poses|overlay|out|tum|json|contact-sheet|camera-out) (\S+)", block):
            assert pathlib.Path(name).stat().st_size > 0, name


def test_a_guide_written_by_hand_is_a_pose(tmp_path):
    (text,) = (block for block in blocks("docs/guide/first_pose.md", "text") if "," not in block)
    (tmp_path / "guide.txt").write_text(text)
    axes = holdfast.load_pose(tmp_path / "guide.txt")[:3, :3]
    assert np.array_equal(axes[:, 1], [0, -1, 0]) and np.array_equal(axes[:, 2], [0, 0, -1])  # y up, z to the camera


def test_readme_holds_the_box(here, program):
    track = next(line for line in "".join(blocks("README.md", "sh")).splitlines() if line.startswith("holdfast track"))
    program(*track.split()[1:])
    rows = pathlib.Path("poses.csv").read_text().splitlines()[1:]
    assert len(rows) == len(list(pathlib.Path("video.mp4").iterdir())) and all(",held," in row for row in rows)


class FakeRos(types.ModuleType):
    """As much of rclpy and its messages as the node of docs/guide/python.md needs."""

    def __init__(self, images):
        super().__init__("rclpy")
        self.images, self.sent = images, []
        self.PoseWithCovarianceStamped = lambda header: types.SimpleNamespace(
            header=header,
            pose=types.SimpleNamespace(
                pose=types.SimpleNamespace(position=types.SimpleNamespace(), orientation=types.SimpleNamespace())
            ),
        )
        self.Image = None

    def init(self):
        pass

    def create_node(self, name):
        return self

    def create_publisher(self, kind, topic, depth):
        return types.SimpleNamespace(publish=self.sent.append)

    def create_subscription(self, kind, topic, callback, depth):
        self.callback = callback

    def spin(self, node):
        for i, image in enumerate(self.images):
            stamp = types.SimpleNamespace(sec=1, nanosec=33_000_000 * i)
            self.callback(
                types.SimpleNamespace(
                    height=image.shape[0], width=image.shape[1], step=3 * image.shape[1], data=image.tobytes(),
                    header=types.SimpleNamespace(stamp=stamp),
                )
            )


@pytest.mark.parametrize("page", pages_with("python"))
def test_python_runs(page, here, frames, camera, monkeypatch):
    text = "\n".join(blocks(page, "python"))
    if "holdfast.bag" in text:
        pytest.importorskip("rosbags")
        from test_bag import record

        record(pathlib.Path("run.bag"), True, frames, camera)
    if "holdfast.view" in text:
        pytest.importorskip("rerun")
    ros = FakeRos(frames)
    for name in ("rclpy", "geometry_msgs", "geometry_msgs.msg", "sensor_msgs", "sensor_msgs.msg"):
        monkeypatch.setitem(sys.modules, name, ros)
    names = {}
    for block in blocks(page, "python"):
        exec(compile(block, page, "exec"), names)
    assert ("rclpy" in text) == bool(ros.sent)


def test_readme_tracks_a_video(here, simulation):
    (snippet,) = blocks("README.md", "python")
    names = {}
    exec(snippet, names)
    assert len(names["poses"]) == len(simulation)
    assert all(holdfast.pose_error(a, b)[0] < 0.001 for a, b in zip(simulation.poses, names["poses"]))


def test_the_packages_own_example(here, capsys):
    (example,) = re.findall(r"\n((?:    .*\n|\n)+)Units", holdfast.__doc__)
    exec(re.sub(r"^    ", "", example, flags=re.MULTILINE), {})
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("0 held") and np.isfinite(float(printed[0].split("[")[1].split()[0]))


def test_the_notebook_runs(files, tmp_path, monkeypatch):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    demo = tmp_path / "demo"
    shutil.copytree(files, demo, symlinks=True)
    (demo / "video.mp4").rename(demo / "box.mp4")
    holdfast.Mesh.load(demo / "object.obj").save(demo / "box_textured.obj")
    monkeypatch.setenv("HOLDFAST_DEMO", str(demo))
    monkeypatch.setenv("PYTHONPATH", str(pathlib.Path(holdfast.__file__).parents[1]))
    monkeypatch.delenv("MPLBACKEND", raising=False)
    notebook = nbformat.read(ROOT / "docs" / "guide" / "demo.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    frames = len(list((demo / "box.mp4").iterdir()))
    assert any("held in {0} of {0} frames".format(frames) in output.get("text", "") for output in outputs)
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 3


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE))


def places(path):
    """What '#...' may name in a page, as GitHub makes it of headings."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", path.read_text(), flags=re.DOTALL | re.MULTILINE), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    path = ROOT / page
    for link in re.findall(r"\]\(([^)\s]+)\)", without_code(path.read_text())):
        parts = urllib.parse.urlsplit(link)
        if parts.scheme:
            continue
        target = path.parent / parts.path if parts.path else path
        assert target.exists(), link
        assert not parts.fragment or parts.fragment in places(target), link


def test_every_page_is_reached_from_the_readme():
    reached, new = set(), {ROOT / "README.md"}
    while new:
        reached |= new
        links = {
            (path.parent / link.split("#")[0]).resolve()
            for path in new
            for link in re.findall(r"\]\(([^)\s:]+)\)", path.read_text())
        }
        new = {path for path in links if path.suffix == ".md" and path.is_file()} - reached
    assert {ROOT / page for page in PAGES} == reached


def test_make_knows_what_the_documents_name():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for page in PAGES:
        text = (ROOT / page).read_text()
        named = set(re.findall(r"`make ([a-z-]+)", text)) | set(re.findall(r"^make ([a-z-]+)", text, re.MULTILINE))
        assert named <= targets, page


def test_readme_is_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 120
    assert (ROOT / "docs" / "images" / "demo.webp").stat().st_size < 2_000_000


def test_readme_has_the_figures_of_the_results(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "apps" / "experiments"))
    import rbot

    table = rbot.accuracy((ROOT / "docs" / "results" / "rbot.md").read_text())
    assert len(table.splitlines()) == 2 + 5
    assert "<!-- begin accuracy -->\n{}<!-- end accuracy -->".format(table) in (ROOT / "README.md").read_text()


def test_every_page_is_in_the_site():
    script = (ROOT / "apps" / "docs" / "build.sh").read_text()
    for page in PAGES[1:]:
        assert re.search(r"\b{}\b".format(pathlib.Path(page).stem), script), page


def test_options_are_those_of_the_help(program):
    said = subprocess.check_output([os.environ["HOLDFAST_PROGRAM"], "simulate", "--help"], text=True)
    if "--seed N [1] " in said:
        pytest.skip("this version of CLI11 writes defaults in brackets, the page has them after an equals sign")
    done = subprocess.run(
        [sys.executable, "-B", ROOT / "apps" / "docs" / "options.py", os.environ["HOLDFAST_PROGRAM"], "--check"],
        capture_output=True, text=True,
    )
    assert done.returncode == 0, done.stderr


def test_the_notebook_is_clean():
    notebook = json.loads((ROOT / "docs" / "guide" / "demo.ipynb").read_text())
    assert not any(output["output_type"] == "error" for cell in notebook["cells"] for output in cell.get("outputs", []))


def test_equations_that_the_code_cites_are_there():
    tags = set(re.findall(r"\\tag\{(\w+)\}", (ROOT / "docs" / "math.md").read_text()))
    cited = set()
    for folder in ("lib", "kernels", "include", "apps", "tests"):
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in (".hpp", ".cpp", ".cl", ".h"):
                for first, last in re.findall(r"equations? (\d+[a-z]?)(?: (?:to|and) (\d+[a-z]?))?", path.read_text()):
                    cited |= {first, last} - {""}
    assert cited and cited <= tags
