"""What stands for a model or a camera in arguments."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ._core import Camera, Mesh


def as_mesh(model: Any, scale: float = 1.0) -> Mesh:
    """The mesh that `model` stands for.

    model: a Mesh, the name of a file, arrays (vertices, faces[, uv, image[, colors]]) or a dict of them (see Mesh), or
        an object with such fields as trimesh's.
    scale: the model's unit in metres, 0.001 for millimetres; of a Mesh it must be 1.
    """
    if isinstance(model, Mesh):
        if scale != 1.0:
            raise ValueError("model_scale: a Mesh is in metres already")
        return model
    if isinstance(model, (str, os.PathLike)):
        return Mesh.load(model, scale)
    if isinstance(model, dict):
        arrays = dict(model)
    elif isinstance(model, (tuple, list)) and 2 <= len(model) <= 5:
        arrays = dict(zip(("vertices", "faces", "uv", "image", "colors"), model))
    elif hasattr(model, "vertices") and hasattr(model, "faces"):
        arrays = _trimesh_arrays(model)
    else:
        raise TypeError(
            "model: expected a Mesh, a file name, arrays (vertices, faces, uv, image) or a trimesh object, got "
            f"{type(model).__name__}"
        )
    unknown = sorted(set(arrays) - {"vertices", "faces", "uv", "image", "colors"})
    missing = [name for name in ("vertices", "faces") if name not in arrays]
    if unknown or missing:
        what = f"'{unknown[0]}' is not known" if unknown else f"'{missing[0]}' is missing"
        raise TypeError(f"model: {what}; a dict has vertices and faces, and may have uv, image and colors")
    arrays["vertices"] = np.asarray(arrays["vertices"], np.float64) * scale
    return Mesh(**arrays)


def as_camera(camera: Any) -> Camera:
    """The camera that `camera` stands for: a Camera, or the name of a calibration file that names the frames' size."""
    if isinstance(camera, Camera):
        return camera
    if isinstance(camera, (str, os.PathLike)):
        return Camera.load(camera)
    raise TypeError(
        f"camera: expected a Camera or a file name, got {type(camera).__name__}; of a 3x3 matrix: "
        "Camera.from_matrix(matrix, width, height)"
    )


def _trimesh_arrays(model: Any) -> dict[str, Any]:
    arrays = {"vertices": model.vertices, "faces": model.faces}
    visual: Any = getattr(model, "visual", None)
    uv = getattr(visual, "uv", None)
    material = getattr(visual, "material", None)
    image = getattr(material, "image", None)
    if image is None:
        image = getattr(material, "baseColorTexture", None)
    if uv is not None and image is not None:
        if getattr(image, "mode", "RGB") not in ("L", "RGB", "RGBA"):  # a PIL image with a palette, say
            image = image.convert("RGBA")
        arrays |= {"uv": uv, "image": np.asarray(image)}
    elif getattr(visual, "kind", None) == "vertex":
        arrays["colors"] = visual.vertex_colors
    return arrays
