"""Bags of ROS 1 and ROS 2: written with rosbags from a simulated sequence, tracked, and read back by rosbags."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from conftest import distance

import holdfast

pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'holdfast[bag]'")
from rosbags.highlevel import AnyReader  # noqa: E402
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

import holdfast.bag  # noqa: E402

START = 1_700_000_000_123_456_789
STEP = 33_333_333
FRAMES = 6


@dataclasses.dataclass
class Recorder:
    """Writes messages to a bag."""

    ros1: bool
    path: Path

    def __enter__(self):
        self.types = get_typestore(Stores.ROS1_NOETIC if self.ros1 else Stores.ROS2_HUMBLE)
        self.writer = Writer1(self.path) if self.ros1 else Writer2(self.path, version=9)
        self.writer.open()
        self.connections = {}
        return self

    def __exit__(self, *_):
        self.writer.close()

    def header(self, stamp):
        time = self.types.types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
        fields = {"seq": 0} if self.ros1 else {}
        return self.types.types["std_msgs/msg/Header"](stamp=time, frame_id="camera_optical", **fields)

    def write(self, topic, name, stamp, **fields):
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, name, typestore=self.types)
        message = self.types.types[name](header=self.header(stamp), **fields)
        serialize = self.types.serialize_ros1 if self.ros1 else self.types.serialize_cdr
        self.writer.write(self.connections[topic], stamp + 5_000_000, serialize(message, name))

    def image(self, topic, stamp, pixels, encoding, padding):
        height, width = pixels.shape[:2]
        rows = pixels.reshape(height, -1)
        data = np.pad(rows, ((0, 0), (0, padding)), constant_values=9)
        self.write(
            topic, "sensor_msgs/msg/Image", stamp, height=height, width=width, encoding=encoding, is_bigendian=0,
            step=data.shape[1], data=data.ravel(),
        )  # fmt: skip

    def camera_info(self, topic, stamp, camera, k=None, d=(0, 0, 0, 0, 0), model="plumb_bob", binning=0, roi=(0, 0, 0, 0)):
        """camera: of P, and of K unless that is given."""
        roi = self.types.types["sensor_msgs/msg/RegionOfInterest"](*roi, False)
        matrices = {
            "D": np.array(d, float),
            "K": (camera.matrix if k is None else np.asarray(k, float)).ravel(),
            "R": np.eye(3).ravel(),
            "P": np.hstack([camera.matrix, np.zeros((3, 1))]).ravel(),
        }
        if not self.ros1:
            matrices = {name.lower(): value for name, value in matrices.items()}
        self.write(
            topic, "sensor_msgs/msg/CameraInfo", stamp, height=camera.height, width=camera.width,
            distortion_model=model, binning_x=binning, binning_y=binning, roi=roi, **matrices,
        )  # fmt: skip


def encoded(image, encoding):
    if encoding == "mono8":
        return image[:, :, 1]
    order = {"b": 0, "g": 1, "r": 2, "a": 0}
    return np.ascontiguousarray(image[:, :, [order[letter] for letter in encoding[:-1]]])


def record(path, ros1, frames, camera, encoding="bgr8"):
    with Recorder(ros1, path) as recorder:
        for i, image in enumerate(frames[:FRAMES]):
            stamp = START + i * STEP
            recorder.camera_info("/camera/camera_info", stamp, camera)
            recorder.image("/camera/image_raw", stamp, encoded(image, encoding), encoding, padding=7)


@pytest.mark.parametrize("name", ["run.bag", "run"])
@pytest.mark.parametrize("output", ["poses.bag", "poses"])
def test_bags_are_tracked(name, output, box, camera, simulation, frames, tmp_path):
    if (name, output) == ("run", "poses.bag"):
        pytest.skip("each kind is read and written in the other three")
    record(tmp_path / name, name.endswith(".bag"), frames, camera)
    assert holdfast.bag.read_camera(tmp_path / name) == camera

    results = holdfast.bag.track(
        tmp_path / name, tmp_path / output, box, simulation.poses[0], object_frame_id="box", pose_topic="/box/pose"
    )
    tracker = holdfast.Tracker(box, camera)
    tracker.reset(simulation.poses[0])
    expected = [tracker.track(frame, 1e-9 * (START + i * STEP)) for i, frame in enumerate(frames[:FRAMES])]
    assert distance([r.T_camera_object for r in results], [r.T_camera_object for r in expected]) == 0

    with AnyReader([tmp_path / output], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        assert {each.topic: each.msgtype for each in reader.connections} == {
            "/box/pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
            "/tf": "tf2_msgs/msg/TFMessage",
        }
        messages = [(c.topic, t, reader.deserialize(data, c.msgtype)) for c, t, data in reader.messages()]
    poses = [(time, message) for topic, time, message in messages if topic == "/box/pose"]
    transforms = [message for topic, _, message in messages if topic == "/tf"]
    assert len(poses) == len(transforms) == FRAMES
    for i, ((time, pose), transform) in enumerate(zip(poses, transforms)):
        stamped = transform.transforms[0]
        for header in (pose.header, stamped.header):
            assert header.stamp.sec * 10**9 + header.stamp.nanosec == START + i * STEP
            assert header.frame_id == "camera_optical"
        assert time == START + i * STEP + 5_000_000
        assert stamped.child_frame_id == "box"
        x, y, z = results[i].T_camera_object[:3, 3]
        assert (pose.pose.pose.position.x, pose.pose.pose.position.y, pose.pose.pose.position.z) == (x, y, z)
        assert (stamped.transform.translation.x, stamped.transform.translation.y) == (x, y)
        assert stamped.transform.rotation == pose.pose.pose.orientation
        covariance = pose.pose.covariance.reshape(6, 6)
        assert np.all(np.linalg.eigvalsh(covariance) > 0) and np.allclose(covariance, covariance.T)
        assert np.sqrt(np.trace(covariance[:3, :3])) < 0.01
    read = list(holdfast.bag.read_poses(tmp_path / output))
    assert distance([each.T_camera_object for each in read], [r.T_camera_object for r in results]) < 1e-12


@pytest.mark.parametrize("encoding", ["bgr8", "rgb8", "bgra8", "rgba8", "mono8"])
def test_encodings(encoding, camera, frames, tmp_path):
    record(tmp_path / "run.bag", True, frames[:2], camera, encoding)
    read = list(holdfast.bag.read_images(tmp_path / "run.bag"))
    assert len(read) == 2
    for i, frame in enumerate(read):
        expected = frames[i][:, :, 1] if encoding == "mono8" else frames[i]
        assert np.array_equal(frame.image, expected)
        assert frame.stamp_ns == START + i * STEP and frame.frame_id == "camera_optical"


def test_compressed_images(box, camera, tmp_path):
    simulation = holdfast.Simulation(box, camera, frames=2, samples=1)
    simulation.save(tmp_path / "sequence")
    files = holdfast.load_sequence(tmp_path / "sequence").frames
    with Recorder(False, tmp_path / "run") as recorder:
        for i, file in enumerate(files):
            data = np.frombuffer(file.read_bytes(), np.uint8)
            kind = "sensor_msgs/msg/CompressedImage"
            recorder.write("/image/compressed", kind, START + i, format="bgr8; png compressed bgr8", data=data)
    read = list(holdfast.bag.read_images(tmp_path / "run"))
    assert [frame.stamp_ns for frame in read] == [START, START + 1]
    assert all(np.array_equal(frame.image, simulation[i].image) for i, frame in enumerate(read))


def test_stamps_need_not_rise(box, camera, simulation, frames, tmp_path):
    with Recorder(True, tmp_path / "run.bag") as recorder:
        for stamp, image in zip([START, START + STEP, START + STEP, START - STEP], frames):
            recorder.image("/camera/image_raw", stamp, image, "bgr8", padding=0)
    results = holdfast.bag.track(tmp_path / "run.bag", tmp_path / "poses", box, simulation.poses[0], camera=camera)
    assert [result.held for result in results] == [True] * 4


def test_starts_from_a_file_or_without_a_pose(box, camera, simulation, frames, tmp_path):
    empty = np.full_like(frames[0], 90)
    with Recorder(True, tmp_path / "run.bag") as recorder:
        for i, image in enumerate([empty, *frames[:2]]):
            recorder.image("/camera/image_raw", START + i * STEP, image, "bgr8", padding=0)
    seen = []
    results = holdfast.bag.track(
        tmp_path / "run.bag", tmp_path / "found", box, camera=camera, after_frame=lambda _, result: seen.append(result)
    )
    assert results[0] is None and seen[0] is None and all(result.held for result in results[1:])
    assert len(list(holdfast.bag.read_poses(tmp_path / "found"))) == 2
    holdfast.save_pose(tmp_path / "pose.txt", simulation.poses[0])
    given = holdfast.bag.track(tmp_path / "run.bag", tmp_path / "given", box, tmp_path / "pose.txt", camera=camera)
    assert len(given) == 3 and not given[0].held


@pytest.mark.parametrize("ros1", [True, False])
@pytest.mark.parametrize("topic, rectified", [
    ("/camera/image_rect_color", None), ("/camera/image_rect/compressed", None), ("/camera/image", True)
])  # fmt: skip
def test_rectified_images_are_not_undistorted_again(topic, rectified, ros1, box, camera, simulation, frames, tmp_path):
    run = tmp_path / ("run.bag" if ros1 else "run")
    with Recorder(ros1, run) as recorder:
        recorder.camera_info("/camera/camera_info", START, camera, k=camera.matrix * [[1.1], [1.1], [1]], d=[-0.3, 0.1, 0, 0, 0])
        recorder.image(topic, START, frames[0], "bgr8", padding=0)
    assert holdfast.bag.read_camera(run).distortion[0] == -0.3
    (result,) = holdfast.bag.track(run, tmp_path / "poses", box, simulation.poses[0], rectified=rectified)
    tracker = holdfast.Tracker(box, camera)
    tracker.reset(simulation.poses[0])
    assert distance(result.T_camera_object, tracker.track(frames[0]).T_camera_object) == 0


def test_camera_info_is_read_as_files_are(camera, tmp_path):
    def read(name, **fields):
        with Recorder(True, tmp_path / name) as recorder:
            recorder.camera_info("/info", START, camera, **fields)
        return holdfast.bag.read_camera(tmp_path / name)

    part = read("roi.bag", binning=2, roi=(10, 20, 200, 100))  # x, y, height, width
    assert (part.width, part.height, part.fx) == (50, 100, camera.fx / 2)
    assert (part.cx, part.cy) == ((camera.cx - 10 + 0.5) / 2 - 0.5, (camera.cy - 20 + 0.5) / 2 - 0.5)
    fisheye = read("fisheye.bag", d=[0.1, 0.02, 0, 0], model="equidistant")
    fisheye.save(tmp_path / "fisheye.yml")
    assert "equidistant" in (tmp_path / "fisheye.yml").read_text()
    assert fisheye == holdfast.Camera.load(tmp_path / "fisheye.yml") != read("plain.bag", d=[0.1, 0.02, 0, 0])
    with pytest.raises(holdfast.Error, match=r"^CameraInfo on '/info' is not calibrated \(K is zero\)"):
        read("zero.bag", k=np.zeros((3, 3)))
    with pytest.raises(holdfast.Error, match="^CameraInfo on '/info': .*'omni'") as raised:
        read("omni.bag", model="omni")
    assert raised.value.code == holdfast.ErrorCode.camera


@pytest.mark.parametrize("output", ["poses.bag", "poses"])
def test_a_run_that_fails_leaves_no_bag(output, box, camera, simulation, frames, tmp_path):
    record(tmp_path / "run.bag", True, frames, camera)

    def stop(frame, result):
        raise KeyboardInterrupt

    arguments = tmp_path / "run.bag", tmp_path / output, box, simulation.poses[0]
    with pytest.raises(KeyboardInterrupt):
        holdfast.bag.track(*arguments, after_frame=stop)
    assert not (tmp_path / output).exists()
    assert len(holdfast.bag.track(*arguments)) == FRAMES


def test_what_is_wrong_with_a_bag_is_said(camera, frames, tmp_path):
    with pytest.raises(holdfast.Error, match="no-such.bag' does not exist$") as raised:
        list(holdfast.bag.read_images(tmp_path / "no-such.bag"))
    assert raised.value.code == holdfast.ErrorCode.file
    with Recorder(True, tmp_path / "run.bag") as recorder:
        recorder.image("/left", START, frames[0], "bgr8", 0)
        recorder.image("/right", START, frames[0], "bgr8", 0)
        recorder.image("/depth", START, frames[0][:, :, :2], "16UC1", 0)
    with pytest.raises(ValueError, match="/depth, /left, /right"):
        list(holdfast.bag.read_images(tmp_path / "run.bag"))
    with pytest.raises(holdfast.Error, match="'/middle'.*/left"):
        list(holdfast.bag.read_images(tmp_path / "run.bag", "/middle"))
    with pytest.raises(holdfast.Error, match="16UC1"):
        list(holdfast.bag.read_images(tmp_path / "run.bag", "/depth"))
    with pytest.raises(holdfast.Error, match="CameraInfo"):
        holdfast.bag.read_camera(tmp_path / "run.bag")
    with pytest.raises(holdfast.Error) as raised:
        holdfast.bag.PoseWriter(tmp_path / "run.bag")
    assert raised.value.code == holdfast.ErrorCode.output
