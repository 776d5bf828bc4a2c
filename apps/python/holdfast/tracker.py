"""The tracker as Python has it: models and cameras by name, options as keyword arguments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypedDict

from . import _core
from .models import as_camera, as_mesh

if TYPE_CHECKING:
    import os

    from typing_extensions import Unpack


class OcclusionOptions(TypedDict, total=False):
    """The tests of one pixel's gradients."""

    gradient_test: bool
    angle_test: bool
    magnitude_test: bool
    block_vote: bool
    angle_together: bool
    gradient_minimum: float
    angle_maximum: float
    difference_maximum: float
    difference_relative: float
    vote_share: float
    redundancy: bool
    redundancy_cosine: float


class TrackerOptions(TypedDict, total=False):
    """Options of a tracker, each with its mode's value where it is not given (default_options())."""

    quality: Literal["accurate", "fast", "paper"]
    levels: int
    search_radius: int
    contour: bool
    light_compensation: bool
    motion_blur: bool
    recovery: bool
    recovery_budget_ms: float
    occlusion: OcclusionOptions
    ablate: list[str]


class Tracker(_core.Tracker):
    """Follows one object through the frames of one camera.

    Several trackers may run in several threads. Threads may share a tracker: its calls run one after the other.
    """

    def __init__(
        self,
        model: _core.Mesh | str | os.PathLike | tuple | dict | Any,
        camera: _core.Camera | str | os.PathLike,
        *,
        mode: Literal["default", "fast", "paper"] = "default",
        model_scale: float = 1.0,
        device: _core.Device | str | None = None,
        **options: Unpack[TrackerOptions],
    ) -> None:
        """Compiles kernels and allocates all that frames need; half a minute the first time on a machine.

        model: a file, a Mesh, arrays (vertices, faces, uv, image), or an object with trimesh's fields; metres, or what
            model_scale turns into metres.
        camera: a Camera or a calibration file that names the frames' size.
        mode: the values of options that are not given.
        device: a Device, or its name: 'cpu', 'gpu', 'P:D' or a part of a name. None: HOLDFAST_DEVICE, else a CPU.
        options: see default_options(); `occlusion` is a dict.

        Raises Error(file, model, camera, device, renderer, invalid_argument), TypeError for an option that is not
        there.
        """
        if device is not None and not isinstance(device, _core.Device):
            device = _core.Device(device)
        super().__init__(as_mesh(model, model_scale), as_camera(camera), mode, dict(options), device)
