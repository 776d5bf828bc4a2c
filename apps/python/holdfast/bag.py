"""Recordings of robots: reads ROS 1 and ROS 2 bags, tracks, and writes poses as a bag (rosbags; no ROS is needed).

    holdfast.bag.track("run.bag", "poses.bag", "object.obj", "pose.txt")

The bag that is written holds geometry_msgs/PoseWithCovarianceStamped and tf2_msgs/TFMessage with the images' stamps, in
the frame that the images are in. Names that end in .bag are ROS 1 bags, others folders of ROS 2.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any, Callable, Iterator

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from . import _core
from ._core import ErrorCode
from .errors import Error
from .geometry import camera_covariance, matrix_of, quaternion
from .tracker import Tracker

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"

_FRAME_TIME = 1 / 30  # seconds, of a frame whose stamp is not later than the one before
_UNKNOWN_VARIANCE = 1e6  # square metres or radians: messages hold no infinity that programs agree on


@dataclasses.dataclass
class BagFrame:
    """An image of a bag."""

    image: np.ndarray  #: uint8: HxWx3 (BGR) or HxW; rows may be apart
    stamp_ns: int  #: of the image's header, nanoseconds
    frame_id: str  #: of the image's header: the camera's optical frame
    bag_time_ns: int  #: when the message was recorded, nanoseconds

    @property
    def time(self) -> float:
        """Seconds of the header's stamp."""
        return 1e-9 * self.stamp_ns


@dataclasses.dataclass
class BagPose:
    """A pose of a bag."""

    T_camera_object: np.ndarray  #: 4x4, metres
    covariance: np.ndarray  #: 6x6: x, y, z, rotation about x, y, z of the camera's axes
    stamp_ns: int
    frame_id: str


def read_images(bag: str | os.PathLike, topic: str | None = None) -> Iterator[BagFrame]:
    """The images of a topic, in the order they were recorded. topic: None: the only one with images."""
    with _open(bag) as reader:
        connections = _connections(reader, (IMAGE, COMPRESSED_IMAGE), topic, bag)
        for connection, bag_time, data in reader.messages(connections=connections):
            message: Any = reader.deserialize(data, connection.msgtype)
            image = _image_of(message) if connection.msgtype == IMAGE else _decoded(message)
            yield BagFrame(image, _nanoseconds(message.header.stamp), message.header.frame_id, bag_time)


def read_camera(bag: str | os.PathLike, topic: str | None = None, *, rectified: bool = False) -> _core.Camera:
    """The camera of the first CameraInfo of a topic. topic: None: the only one. rectified: of images that image_proc
    has rectified (matrix P, no distortion)."""
    with _open(bag) as reader:
        connections = _connections(reader, (CAMERA_INFO,), topic, bag)
        for connection, _, data in reader.messages(connections=connections):
            return _camera_of(reader.deserialize(data, connection.msgtype), rectified, connection.topic)
    raise Error(f"'{bag}' holds no message of CameraInfo", ErrorCode.camera)


def read_poses(bag: str | os.PathLike, topic: str | None = None) -> Iterator[BagPose]:
    """The poses that track() wrote. topic: None: the only one with PoseWithCovarianceStamped."""
    with _open(bag) as reader:
        connections = _connections(reader, (POSE,), topic, bag)
        for connection, _, data in reader.messages(connections=connections):
            message: Any = reader.deserialize(data, connection.msgtype)
            yield BagPose(
                _pose_of(message.pose.pose),
                np.array(message.pose.covariance, np.float64).reshape(6, 6),
                _nanoseconds(message.header.stamp),
                message.header.frame_id,
            )


def track(
    bag: str | os.PathLike,
    output: str | os.PathLike,
    model: Any,
    T_camera_object: np.ndarray | str | os.PathLike | None = None,
    *,
    camera: _core.Camera | None = None,
    rectified: bool | None = None,
    image_topic: str | None = None,
    camera_info_topic: str | None = None,
    pose_topic: str = "/holdfast/pose",
    object_frame_id: str = "object",
    after_frame: Callable[[BagFrame, _core.FrameResult | None], None] | None = None,
    **options: Any,
) -> list[_core.FrameResult | None]:
    """Tracks through a bag's images and writes a bag of the poses of frames that are held. Returns a result for each
    image, None for those before the object is found.

    model: see Tracker. T_camera_object: pose in the first image, 4x4, metres, or a file of it; None: the object is
    looked for by its texture (Tracker.find()). camera: None: the bag's CameraInfo. rectified: whether it is the camera
    of images that image_proc has rectified (see read_camera()); None: it is where the images' topic is named
    image_rect or image_rect_..., as ROS has it.
    output: must not exist, and does not after an exception; *.bag: ROS 1, else a folder of ROS 2.
    object_frame_id: child frame of the transforms.
    after_frame: called with each frame and its result. options: Tracker's keyword arguments.
    """
    if isinstance(T_camera_object, (str, os.PathLike)):
        T_camera_object = _core.load_pose(T_camera_object)
    output_bag = PoseWriter(output, pose_topic, object_frame_id)
    if camera is None:
        if rectified is None:
            rectified = _is_rectified(_image_topic(bag, image_topic))
        camera = read_camera(bag, camera_info_topic, rectified=rectified)
    tracker = Tracker(model, camera, **options)
    if T_camera_object is not None:
        tracker.reset(T_camera_object)
    found = T_camera_object is not None
    results: list[_core.FrameResult | None] = []
    time = -np.inf
    with output_bag as writer:
        for frame in read_images(bag, image_topic):
            # Stamps may stand still or go back, the tracker's times must rise.
            time = frame.time if frame.time > time else time + _FRAME_TIME
            result = tracker.track(frame.image, time) if found else tracker.find(frame.image, time)
            found = found or result is not None
            results.append(result)
            if result is not None and result.held:
                writer.write(result, frame.stamp_ns, frame.frame_id, frame.bag_time_ns)
            if after_frame is not None:
                after_frame(frame, result)
    return results


class PoseWriter:
    """Writes poses to a new bag: *.bag for ROS 1, else a folder of ROS 2. A context manager; after an exception nothing
    is left of the bag."""

    def __init__(
        self, path: str | os.PathLike, pose_topic: str = "/holdfast/pose", object_frame_id: str = "object"
    ) -> None:
        path = Path(path)
        if path.exists():
            raise Error(f"'{path}' exists already: remove it or name another bag", ErrorCode.output)
        self._ros1 = path.suffix == ".bag"
        self._types = get_typestore(Stores.ROS1_NOETIC if self._ros1 else Stores.ROS2_HUMBLE)
        if TRANSFORMS not in self._types.types:
            self._types.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))
        self._path = path
        self._object_frame_id = object_frame_id
        self._pose_topic = pose_topic
        self._written = 0
        self._writer = Writer1(path) if self._ros1 else Writer2(path, version=9)

    def __enter__(self) -> PoseWriter:
        self._writer.open()
        self._poses = self._writer.add_connection(self._pose_topic, POSE, typestore=self._types)
        self._transforms = self._writer.add_connection("/tf", TRANSFORMS, typestore=self._types)
        return self

    def __exit__(self, raised: type[BaseException] | None, *_: object) -> None:
        self._writer.close()
        if raised is not None:  # half a bag would only be in the way of the next try
            self._path.unlink() if self._ros1 else shutil.rmtree(self._path)

    def write(
        self, result: _core.FrameResult, stamp_ns: int, frame_id: str, bag_time_ns: int | None = None
    ) -> None:
        """Writes a result's pose and transform. frame_id: the camera's optical frame. bag_time_ns: None: the stamp."""
        time = stamp_ns if bag_time_ns is None else bag_time_ns
        header = self._header(stamp_ns, frame_id)
        self._put(self._poses, time, self._pose_message(header, result))
        self._put(self._transforms, time, self._transform_message(header, result))
        self._written += 1

    def _put(self, connection: Any, time: int, message: Any) -> None:
        serialize = self._types.serialize_ros1 if self._ros1 else self._types.serialize_cdr
        self._writer.write(connection, time, serialize(message, message.__msgtype__))

    def _new(self, name: str, **fields: Any) -> Any:
        return self._types.types[name](**fields)

    def _header(self, stamp_ns: int, frame_id: str) -> Any:
        stamp = self._new("builtin_interfaces/msg/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
        sequence = {"seq": self._written} if self._ros1 else {}
        return self._new("std_msgs/msg/Header", stamp=stamp, frame_id=frame_id, **sequence)

    def _pose_message(self, header: Any, result: _core.FrameResult) -> Any:
        pose = result.T_camera_object
        x, y, z = (float(value) for value in pose[:3, 3])
        position = self._new("geometry_msgs/msg/Point", x=x, y=y, z=z)
        covariance = np.nan_to_num(camera_covariance(result), posinf=_UNKNOWN_VARIANCE)
        pose_message = self._new("geometry_msgs/msg/Pose", position=position, orientation=self._quaternion(pose))
        message = self._new("geometry_msgs/msg/PoseWithCovariance", pose=pose_message, covariance=covariance.ravel())
        return self._new(POSE, header=header, pose=message)

    def _transform_message(self, header: Any, result: _core.FrameResult) -> Any:
        pose = result.T_camera_object
        x, y, z = (float(value) for value in pose[:3, 3])
        translation = self._new("geometry_msgs/msg/Vector3", x=x, y=y, z=z)
        transform = self._new(
            "geometry_msgs/msg/Transform", translation=translation, rotation=self._quaternion(pose)
        )
        stamped = self._new(
            "geometry_msgs/msg/TransformStamped",
            header=header,
            child_frame_id=self._object_frame_id,
            transform=transform,
        )
        return self._new(TRANSFORMS, transforms=[stamped])

    def _quaternion(self, pose: np.ndarray) -> Any:
        x, y, z, w = quaternion(pose[:3, :3])
        return self._new("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)


def _pose_of(pose: Any) -> np.ndarray:
    position, q = pose.position, pose.orientation
    return matrix_of((position.x, position.y, position.z), (q.x, q.y, q.z, q.w))


@contextlib.contextmanager
def _open(bag: str | os.PathLike) -> Iterator[AnyReader]:
    if not Path(bag).exists():
        raise Error(f"'{bag}' does not exist", ErrorCode.file)
    try:
        reader = AnyReader([Path(bag)], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    except (AnyReaderError, OSError) as error:
        raise Error(f"'{bag}' is no bag that can be read: {error}", ErrorCode.file) from None
    with contextlib.closing(reader):
        yield reader


def _connections(reader: AnyReader, types: tuple[str, ...], topic: str | None, bag: Any) -> list[Any]:
    found = [each for each in reader.connections if each.msgtype in types and topic in (None, each.topic)]
    topics = sorted({each.topic for each in found})
    if len(topics) == 1:
        return found
    kinds = " or ".join(name.rsplit("/", 1)[1] for name in types)
    if topics:
        raise ValueError(f"topic: '{bag}' has several of {kinds}: {', '.join(topics)}; name one")
    there = ", ".join(sorted(each.topic for each in reader.connections if each.msgtype in types)) or "none"
    named = "" if topic is None else f" named '{topic}'"
    raise Error(f"'{bag}' has no topic of {kinds}{named}; there are: {there}", ErrorCode.file)


def _nanoseconds(stamp: Any) -> int:
    return stamp.sec * 10**9 + stamp.nanosec


def _image_of(message: Any) -> np.ndarray:
    """The message's own memory where Holdfast takes it as it is, else a copy."""
    channels = {"mono8": 1, "8UC1": 1, "bgr8": 3, "8UC3": 3, "rgb8": 3, "bgra8": 4, "rgba8": 4}.get(message.encoding)
    if channels is None:
        raise Error(
            f"images are encoded as {message.encoding}: only mono8, bgr8, rgb8, bgra8 and rgba8 are read",
            ErrorCode.image,
        )
    shape, strides = (message.height, message.width, channels), (message.step, channels, 1)
    if message.step < message.width * channels or len(message.data) < message.height * message.step:
        raise Error(f"an image of {message.width}x{message.height} has too few bytes", ErrorCode.image)
    data = np.frombuffer(message.data, np.uint8)
    image = np.lib.stride_tricks.as_strided(data, shape, strides, writeable=False)
    if channels == 1:
        return image[:, :, 0]
    if message.encoding in ("bgr8", "8UC3"):
        return image
    order = [2, 1, 0] if message.encoding.startswith("rgb") else [0, 1, 2]
    return np.ascontiguousarray(image[:, :, order])


def _decoded(message: Any) -> np.ndarray:
    image = _core.decode_image(bytes(message.data))
    swapped = "compressed rgb8" in message.format  # image_transport stores the bytes of a colour as they came
    return image[:, :, ::-1].copy() if swapped and image.ndim == 3 else image


def _image_topic(bag: Any, topic: str | None) -> str:
    with _open(bag) as reader:
        return _connections(reader, (IMAGE, COMPRESSED_IMAGE), topic, bag)[0].topic


def _is_rectified(topic: str) -> bool:
    return any(part.startswith("image_rect") for part in topic.split("/"))  # image_rect_color/compressed is, too


def _camera_of(info: Any, rectified: bool, topic: str) -> _core.Camera:
    def field(name: str) -> np.ndarray:  # ROS 1 has upper case names
        return np.array(getattr(info, name.upper()) if hasattr(info, name.upper()) else getattr(info, name), float)

    name, matrix = ("P", field("p").reshape(3, 4)[:, :3]) if rectified else ("K", field("k").reshape(3, 3))
    if not matrix.any():
        raise Error(f"CameraInfo on '{topic}' is not calibrated ({name} is zero): pass camera=", ErrorCode.camera)
    roi = {name: int(getattr(info.roi, name)) for name in ("x_offset", "y_offset", "width", "height")}
    document = {
        "image_width": int(info.width),
        "image_height": int(info.height),
        "camera_matrix": matrix.ravel().tolist(),
        "distortion_model": "plumb_bob" if rectified else info.distortion_model,
        "distortion_coefficients": [0.0] * 5 if rectified else field("d").tolist(),
        "binning_x": int(info.binning_x),
        "binning_y": int(info.binning_y),
        "roi": roi,
    }
    # Read as a file, so that all that holds for files of ROS holds here.
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "camera_info.json"
        path.write_text(json.dumps(document))
        try:
            return _core.Camera.load(path)
        except Error as error:
            message = str(error).replace(f"camera file '{path}'", f"CameraInfo on '{topic}'")
            raise Error(message, error.code) from None
