"""Follows the position and orientation of one rigid object of known shape through video.

    import holdfast

    video = holdfast.Video("video.mp4")
    camera = holdfast.Camera.load("camera.yml", video.width, video.height)
    tracker = holdfast.Tracker("object.obj", camera)
    tracker.reset(holdfast.load_pose("pose.txt"))
    for frame in video:
        result = tracker.track(frame.image, frame.time)
        print(frame.index, result.status.name, result.T_camera_object[:3, 3])

Units are metres, radians, pixels and seconds. Poses are 4x4 arrays that map points of the object's frame to the
camera's: x right, y down, z forward. Frames are uint8 arrays: HxWx3 (BGR, as OpenCV has it), HxWx4 (RGBA) or HxW.
The interpreter's lock is released while trackers work, so that several may run in several threads.

holdfast.plot (needs matplotlib), holdfast.view (rerun-sdk) and holdfast.bag (rosbags) are imported by name.
"""

from . import _core
from .arguments import name_arguments

name_arguments(_core)  # before what follows takes its functions

from ._core import (
    Camera,
    ContourEvidence,
    Device,
    DeviceInfo,
    EdgeEvidence,
    ErrorCode,
    Frame,
    FrameRecord,
    FrameResult,
    Mesh,
    ModelCompletion,
    Partition,
    PixelClass,
    PixelFormat,
    PoseFromPoints,
    Reason,
    RecordedSequence,
    RenderedView,
    Renderer,
    RendererChoice,
    SimulatedFrame,
    Simulation,
    SnapshotEvidence,
    StageTimes,
    Status,
    TextureBaker,
    TextureEvidence,
    Video,
    decode_image,
    default_options,
    devices,
    evaluate,
    lettered_cube,
    load_pose,
    load_poses,
    load_sequence,
    pose_error,
    pose_from_points,
    save_pose,
    save_poses,
    textured_box,
    unit_warning,
)
from ._core import version as __version__
from .errors import Error
from .models import as_camera, as_mesh
from .pictures import outlines
from .tracker import OcclusionOptions, Tracker, TrackerOptions

__all__ = [name for name in dir() if name[0].isupper()] + [
    "__version__", "as_camera", "as_mesh", "decode_image", "default_options", "devices", "evaluate", "lettered_cube",
    "load_pose", "load_poses", "load_sequence", "outlines", "pose_error", "pose_from_points", "save_pose", "save_poses",
    "textured_box", "unit_warning",
]
