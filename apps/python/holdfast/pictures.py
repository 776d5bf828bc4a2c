"""What plot and view draw: contours and pixel classes. numpy only."""

from __future__ import annotations

import numpy as np

from . import _core

#: RGB of each PixelClass that is drawn, over the frame.
CLASS_COLORS = {
    _core.PixelClass.used: (0, 200, 0),
    _core.PixelClass.rejected_angle: (255, 0, 0),
    _core.PixelClass.rejected_magnitude: (255, 80, 0),
    _core.PixelClass.rejected_vote: (255, 0, 120),
}


def rgb_of(image: np.ndarray) -> np.ndarray:
    """HxWx3 RGB of a frame as Tracker.track takes it: BGR, RGBA or grey."""
    if image.ndim == 2:
        return np.repeat(image[:, :, None], 3, axis=2)
    return image[:, :, 2::-1] if image.shape[2] == 3 else image[:, :, :3]


def blended_classes(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The frame as RGB, with the pixels that were used or rejected coloured by half."""
    picture = rgb_of(image).copy()
    for pixel_class, color in CLASS_COLORS.items():
        where = mask == int(pixel_class)
        picture[where] = (picture[where].astype(np.uint16) + np.array(color, np.uint16)) // 2
    return picture


def silhouette(renderer: _core.Renderer, pose: np.ndarray, camera: _core.Camera) -> np.ndarray:
    """HxW bool: where the model is seen at a pose (4x4), in the ideal pinhole image."""
    if not isinstance(renderer, _core.Renderer):
        raise TypeError(
            f"renderer: expected a Renderer, got {type(renderer).__name__}; Renderer(mesh, camera.width, camera.height)"
        )
    return renderer.render(pose, camera).depth > 0


def outlines(renderer: _core.Renderer, T_camera_object: np.ndarray, camera: _core.Camera) -> np.ndarray:
    """The contour of a model at a pose (4x4), as lines (Nx2x2: two points x, y) in pixels of the recorded frame.

    renderer: Renderer(mesh, camera.width, camera.height). cv2.polylines(image, lines.round().astype(numpy.int32), False,
    (0, 255, 255)) draws them."""
    seen = np.pad(silhouette(renderer, T_camera_object, camera), 1)
    lines = _runs(seen) + [line[:, ::-1] for line in _runs(seen.T)]
    if not lines:
        return np.zeros((0, 2, 2))
    return camera.distort(np.concatenate(lines)).reshape(-1, 2, 2)


def _runs(seen: np.ndarray) -> list[np.ndarray]:
    """Horizontal edges between the pixels of a padded picture that are seen and others, neighbours joined: lines from
    (x0, y) to (x1, y)."""
    lines = []
    for y, row in enumerate(seen[1:] != seen[:-1]):
        changes = np.flatnonzero(np.diff(row.astype(np.int8)))
        for start, end in zip(changes[::2], changes[1::2]):
            lines.append(np.array([[start - 0.5, y - 0.5], [end - 0.5, y - 0.5]]))
    return lines
