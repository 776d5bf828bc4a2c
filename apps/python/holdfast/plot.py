"""Pictures of what a tracker found, by matplotlib.

    figure = holdfast.plot.frame(image, result, holdfast.Renderer(mesh, camera.width, camera.height), camera)
    figure = holdfast.plot.trajectory(results, times)
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Sequence

import numpy as np

from . import _core
from .geometry import standard_deviations
from .pictures import blended_classes, outlines, rgb_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_AXIS_COLORS = ("tab:red", "tab:green", "tab:blue")


def frame(
    image: np.ndarray,
    result: _core.FrameResult | np.ndarray | None,
    renderer: _core.Renderer,
    camera: _core.Camera,
    *,
    mask: np.ndarray | None = None,
    axes: Axes | None = None,
) -> Axes:
    """The frame with the model's contour and the object's axes; x red, y green, z blue.

    image: as given to Tracker.track (BGR, RGBA or grey). result: a FrameResult or a pose, 4x4; None: not found, the frame
    alone. mask: of Tracker.mask(): pixels that were used in green, rejected ones in red. axes: None: those of a new
    figure, axes.figure, which pyplot does not know; plt.gca(): for plt.show().
    """
    from matplotlib.collections import LineCollection

    axes = axes or _new_axes()
    axes.imshow(rgb_of(image) if mask is None else blended_classes(image, mask))
    if result is not None:
        pose = result.T_camera_object if isinstance(result, _core.FrameResult) else np.asarray(result)
        lines = list(outlines(renderer, pose, camera))
        axes.add_collection(LineCollection(lines, colors="yellow", linewidths=1))
        _draw_axes(axes, pose, camera)
    axes.set_xlim(-0.5, camera.width - 0.5)
    axes.set_ylim(camera.height - 0.5, -0.5)
    axes.set_axis_off()
    if isinstance(result, _core.FrameResult):
        axes.set_title(f"{result.status.name}{': ' if result.message else ''}{result.message}")
    return axes


def trajectory(
    results: Sequence[_core.FrameResult | None],
    times: Sequence[float] | None = None,
    *,
    truth: np.ndarray | None = None,
    figure: Figure | None = None,
) -> Figure:
    """Position and standard deviations over time; lost frames in grey.

    results: None: a frame in which the object was not found, a gap.
    times: seconds, one a result; None: frame numbers. truth: true poses, Nx4x4, drawn dashed.
    """
    import matplotlib.pyplot as plt

    figure = figure or plt.figure(figsize=(8, 6), layout="constrained")
    position, spread = figure.subplots(2, 1, sharex=True)
    at = np.arange(len(results)) if times is None else np.asarray(times, float)
    poses = np.array([np.eye(4) if result is None else result.T_camera_object for result in results]).reshape(-1, 4, 4)
    held = np.array([result is not None and result.held for result in results], bool)
    for axis, (name, color) in enumerate(zip("xyz", _AXIS_COLORS)):
        position.plot(at, np.where(held, 1000 * poses[:, axis, 3], np.nan), color=color, label=name)
        if truth is not None:
            position.plot(at, 1000 * np.asarray(truth)[:, axis, 3], color=color, linestyle="--", linewidth=0.8)
    position.set_ylabel("position in the camera's frame (mm)")
    position.legend()
    unknown = (np.nan, np.nan)
    sigma = np.array([unknown if result is None else standard_deviations(result) for result in results]).reshape(-1, 2)
    spread.semilogy(at, 1000 * sigma[:, 0], label="position (mm)")
    spread.semilogy(at, np.degrees(sigma[:, 1]), label="rotation (degrees)")
    spread.set_ylabel("standard deviation")
    spread.set_xlabel("frame" if times is None else "time (s)")
    spread.legend()
    for axes in (position, spread):
        for i in np.flatnonzero(~held):
            axes.axvspan(at[i] - 0.5 * _step(at), at[i] + 0.5 * _step(at), color="0.85", linewidth=0)
    return figure


def _new_axes() -> Axes:
    from matplotlib.figure import Figure

    return Figure(layout="constrained").subplots()  # pyplot's would stay in memory, one a frame of a loop


def _step(at: np.ndarray) -> float:
    return float(np.median(np.diff(at))) if len(at) > 1 else 1.0


def _draw_axes(axes: Axes, pose: np.ndarray, camera: _core.Camera) -> None:
    length = 0.1 * float(np.linalg.norm(pose[:3, 3]))  # a tenth of the distance: seen well at any
    ends = pose[:3, 3] + length * np.vstack([np.zeros(3), pose[:3, :3].T])
    if np.any(ends[:, 2] <= 0):
        return
    pixels = camera.project(ends)
    for end, color in zip(pixels[1:], _AXIS_COLORS):
        axes.plot([pixels[0, 0], end[0]], [pixels[0, 1], end[1]], color=color, linewidth=2)
