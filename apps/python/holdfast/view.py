"""What a tracker sees and finds, in the Rerun viewer (rerun-sdk): live or as an .rrd file.

    view = holdfast.view.View(mesh, camera, "run.rrd")     # without a file: opens the viewer
    view.log(frame, result, time, mask=tracker.mask())
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import rerun as rr

from . import _core
from .geometry import standard_deviations
from .models import as_camera, as_mesh
from .pictures import CLASS_COLORS, outlines, rgb_of

_TRAIL = 3000  # positions of the trajectory that are drawn


class View:
    """Logs frames to one recording.

    Entities: camera (pinhole), camera/image, camera/image/classes, camera/image/contour, object (mesh at its pose, in the
    camera's frame), trajectory, sigma/position_mm, sigma/rotation_deg, correlation, status. Timelines: frame, and time
    where times are given.
    """

    def __init__(
        self,
        model: _core.Mesh | str | os.PathLike | Any,
        camera: _core.Camera | str | os.PathLike,
        path: str | os.PathLike | None = None,
        *,
        application_id: str = "holdfast",
        recording: rr.RecordingStream | None = None,
    ) -> None:
        """model, camera: the tracker's. path: an .rrd file to write; None: the viewer is started and shows it live.
        recording: a stream of the caller's to log to, in place of either."""
        self.mesh = as_mesh(model)
        self.camera = as_camera(camera)
        self.recording = recording or rr.RecordingStream(application_id)
        if recording is None:
            if path is None:
                self.recording.spawn()
            else:
                self.recording.save(os.fspath(path))
        self._renderer = _core.Renderer(self.mesh, self.camera.width, self.camera.height)
        self._trail: list[np.ndarray] = []
        self._frame = 0
        self._log_static()

    def log(
        self,
        frame: np.ndarray | None,
        result: _core.FrameResult | None,
        time: float | None = None,
        *,
        mask: np.ndarray | None = None,
    ) -> None:
        """Logs one frame. frame: as given to Tracker.track (BGR, RGBA or grey); None: not shown.
        result: None: not found, nothing is drawn over the frame. time: seconds. mask: of Tracker.mask()."""
        to = self.recording
        to.set_time("frame", sequence=self._frame)
        if time is not None:
            to.set_time("time", duration=time)
        self._frame += 1
        if frame is not None:
            to.log("camera/image", rr.Image(np.ascontiguousarray(rgb_of(frame))))
        if mask is not None:
            to.log("camera/image/classes", rr.SegmentationImage(mask, opacity=0.5))
        if result is None:
            to.log("camera/image/contour", rr.LineStrips2D([]))
            to.log("status", rr.TextLog("not found", level=rr.TextLogLevel.WARN))
            return
        self._log_pose(result)
        position, rotation = standard_deviations(result)
        to.log("sigma/position_mm", rr.Scalars(1000 * position))
        to.log("sigma/rotation_deg", rr.Scalars(np.degrees(rotation)))
        to.log("correlation", rr.Scalars(result.texture.correlation))
        level = rr.TextLogLevel.INFO if result.held else rr.TextLogLevel.WARN
        to.log("status", rr.TextLog(f"{result.status.name} {result.message}".strip(), level=level))

    def close(self) -> None:
        """Writes what is pending and ends the recording."""
        self.recording.flush()
        self.recording.disconnect()

    def __enter__(self) -> View:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _log_static(self) -> None:
        to = self.recording
        to.log("/", rr.ViewCoordinates.RDF, static=True)
        size = [self.camera.width, self.camera.height]
        to.log("camera", rr.Pinhole(image_from_camera=self.camera.matrix, resolution=size), static=True)
        invisible = (0, 0, 0, 0)
        classes = [(int(each), each.name, CLASS_COLORS.get(each, invisible)) for each in _core.PixelClass]
        to.log("camera/image", rr.AnnotationContext(classes), static=True)
        mesh, image = self.mesh, next((each for each in self.mesh.images if each is not None), None)
        to.log(
            "object",
            rr.Mesh3D(
                vertex_positions=mesh.vertices,
                triangle_indices=mesh.faces,
                vertex_texcoords=mesh.uv * [1, -1] + [0, 1] if len(mesh.uv) and image is not None else None,
                albedo_texture=image[:, :, :3] if len(mesh.uv) and image is not None else None,
                vertex_colors=mesh.colors if len(mesh.colors) else None,
            ),
            static=True,
        )

    def _log_pose(self, result: _core.FrameResult) -> None:
        to = self.recording
        pose = result.T_camera_object
        to.log("object", rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        color = (255, 220, 0) if result.held else (255, 0, 0)
        lines = outlines(self._renderer, pose, self.camera)
        to.log("camera/image/contour", rr.LineStrips2D(lines, colors=[color] * len(lines)))
        if result.held:
            self._trail = [*self._trail[1 - _TRAIL :], pose[:3, 3]]
            if len(self._trail) > 1:
                to.log("trajectory", rr.LineStrips3D([np.array(self._trail)], colors=[(0, 120, 255)]))
