"""plot, view and what they share."""

import numpy as np
import pytest
from conftest import distance

import holdfast
from holdfast import pictures


@pytest.fixture
def results(tracker, frames):
    return [tracker.track(frame) for frame in frames[:4]]


def test_outlines_go_round_the_object(box, camera, simulation):
    renderer = holdfast.Renderer(box, camera.width, camera.height)
    lines = holdfast.outlines(renderer, simulation.poses[0], camera)
    assert lines.shape[1:] == (2, 2)
    seen = pictures.silhouette(renderer, simulation.poses[0], camera)
    # A closed contour: going along x as far forwards as backwards encloses its area (Green's theorem, by rows).
    horizontal = lines[np.isclose(lines[:, 0, 1], lines[:, 1, 1])]
    area = 0.0
    for (x0, y), (x1, _) in horizontal:
        column = int(np.ceil(x0))
        below = y < camera.height - 1 and seen[int(y + 0.5), column]
        area += (x1 - x0) * (-y if below else y)
    assert area == pytest.approx(np.count_nonzero(seen))


def test_plots(box, camera, tracker, frames, results, simulation, tmp_path):
    plot = pytest.importorskip("holdfast.plot", exc_type=ImportError)
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install 'holdfast[plot]'")
    import matplotlib.pyplot as plt

    renderer = holdfast.Renderer(box, camera.width, camera.height)
    axes = plot.frame(frames[3], results[3], renderer, camera, mask=tracker.mask())
    figure = plot.trajectory(results, [0, 0.1, 0.2, 0.3], truth=simulation.poses[:4])
    for each in (axes.figure, figure):
        each.savefig(tmp_path / "picture.png")
        assert (tmp_path / "picture.png").stat().st_size > 10000
    plt.close("all")
    assert len(figure.axes[0].lines) == 6
    np.testing.assert_allclose(
        figure.axes[0].lines[0].get_ydata(), [1000 * result.T_camera_object[0, 3] for result in results]
    )


def test_frames_without_a_pose_are_gaps(box, camera, frames, results):
    plot = pytest.importorskip("holdfast.plot", exc_type=ImportError)
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install 'holdfast[plot]'")
    import matplotlib.pyplot as plt

    opened = plt.get_fignums()
    renderer = holdfast.Renderer(box, camera.width, camera.height)
    axes = plot.frame(frames[0], None, renderer, camera)
    assert not axes.lines and not axes.collections
    assert plt.get_fignums() == opened  # a loop over frames leaves no figures behind
    figure = plot.trajectory([None, *results])
    x = figure.axes[0].lines[0].get_ydata()
    assert np.isnan(x[0]) and x[1] == 1000 * results[0].T_camera_object[0, 3]
    plt.close(figure)


def test_view_writes_a_recording(box, camera, tracker, frames, results, tmp_path):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed: pip install 'holdfast[view]'")
    from holdfast.view import View

    sizes = []
    for count in (1, 4):
        path = tmp_path / f"{count}.rrd"
        with View(box, camera, path) as view:
            for i in range(count):
                view.log(frames[i], results[i], 0.1 * i, mask=tracker.mask())
            view.log(None, None, 1.0)
        sizes.append(path.stat().st_size)
    assert (tmp_path / "4.rrd").read_bytes()[:3] == b"RRF"
    assert sizes[1] - sizes[0] > 2 * frames[0].nbytes / 10


def test_classes_are_blended(frames):
    mask = np.zeros(frames[0].shape[:2], np.uint8)
    mask[10, 20] = int(holdfast.PixelClass.used)
    picture = pictures.blended_classes(frames[0], mask)
    rgb = frames[0][:, :, ::-1]
    assert distance(np.delete(picture.reshape(-1, 3), 10 * 320 + 20, 0), np.delete(rgb.reshape(-1, 3), 10 * 320 + 20, 0)) == 0
    assert picture[10, 20, 1] == (int(rgb[10, 20, 1]) + 200) // 2
