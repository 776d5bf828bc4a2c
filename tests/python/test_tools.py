"""Simulation, evaluation, baking and first poses."""

import numpy as np
import pytest
from conftest import distance

import holdfast


def test_a_simulation_is_a_sequence(simulation, box, camera, frames):
    assert len(simulation) == len(simulation.poses) == len(frames)
    assert len(list(simulation)) == len(frames)
    frame = simulation[3]
    assert frame.image.shape == (camera.height, camera.width, 3) and frame.image.dtype == np.uint8
    assert distance(frame.T_camera_object, simulation.poses[3]) == 0
    assert np.array_equal(simulation[-1].image, frames[-1])
    with pytest.raises(IndexError):
        simulation[len(simulation)]
    same = holdfast.Simulation(box, camera, poses=simulation.poses[:4], samples=2, seed=3)
    assert len(same) == 4 and np.array_equal(same[3].image, frames[3])
    with pytest.raises(TypeError, match="no option 'velocity'.*speed"):
        holdfast.Simulation(box, motion={"velocity": 3})
    far = np.diag([1.0, 1.0, 1.0, 1.0])
    far[2, 3] = 0.2  # a cube before the camera hides all of it
    hidden = holdfast.Simulation(box, camera, poses=simulation.poses[:1], occluders=[(holdfast.lettered_cube(0.3), [far])])
    assert hidden[0].visible_share == 0 and hidden[0].occluder_mask.min() == 255
    with pytest.raises(ValueError, match="occluders.*ball"):
        holdfast.Simulation(box, occluders=["ball"])
    with pytest.raises(ValueError, match="style.*wild"):
        holdfast.Simulation(box, style="wild")


def test_a_saved_simulation_is_read_again(box, camera, tmp_path):
    simulation = holdfast.Simulation(box, camera, frames=3, samples=1, occluders=["bar"])
    assert simulation.save(tmp_path / "sequence", masks=True) == 3
    recorded = holdfast.load_sequence(tmp_path / "sequence")
    assert recorded.camera == camera and len(recorded.frames) == 3
    assert distance(recorded.poses, simulation.poses) < 1e-8
    for i, frame in enumerate(holdfast.Video(tmp_path / "sequence" / "frames", frame_rate=10)):
        assert frame.index == i and frame.time == pytest.approx(0.1 * i)
        assert np.array_equal(frame.image, simulation[i].image)
        encoded = recorded.frames[i].read_bytes()
        assert np.array_equal(holdfast.decode_image(encoded), simulation[i].image)
    with pytest.raises(holdfast.Error) as raised:
        holdfast.decode_image(encoded[:40])
    assert raised.value.code == holdfast.ErrorCode.image


@pytest.mark.parametrize("protocol", ["never-reset", "rbot"])
def test_evaluation_says_how_far_off_poses_are(tracker, simulation, frames, protocol):
    records = holdfast.evaluate(tracker, frames, simulation.poses, protocol=protocol, step=2)
    assert [record.frame for record in records] == list(range(0 if protocol == "never-reset" else 2, len(frames), 2))
    for record in records:
        truth, found = simulation.poses[record.frame], record.result.T_camera_object
        assert record.translation_error == pytest.approx(np.linalg.norm(truth[:3, 3] - found[:3, 3]))
        cosine = (np.trace(truth[:3, :3].T @ found[:3, :3]) - 1) / 2
        assert record.rotation_error == pytest.approx(np.arccos(min(cosine, 1)), abs=1e-6)
        assert not record.failed and record.counted
        assert repr(record).startswith(f"<FrameRecord of frame {record.frame}: held, ")
    with pytest.raises(ValueError, match="protocol.*often"):
        holdfast.evaluate(tracker, frames, simulation.poses, protocol="often")
    with pytest.raises(ValueError, match=f"truth.*{len(frames)} poses for {len(frames) - 1} frames"):
        holdfast.evaluate(tracker, frames[1:], simulation.poses, protocol=protocol)


def test_a_failing_frame_ends_an_evaluation(tracker, simulation):
    class Frames:
        def __getitem__(self, i):
            raise KeyError(i)

    with pytest.raises(KeyError):
        holdfast.evaluate(tracker, Frames(), simulation.poses)


def test_a_baked_model_is_tracked(box, camera, device, simulation, frames):
    plain = holdfast.Mesh(box.vertices, box.faces, box.uv)
    assert box.has_appearance and not plain.has_appearance
    baker = holdfast.TextureBaker(plain, camera, simulation.poses[0])
    for i in (0, 8, 16):
        assert baker.add(frames[i], simulation.poses[i])
    assert 0.2 < baker.coverage < 0.9  # a box is never seen from behind here
    tracker = holdfast.Tracker(baker.mesh, camera, device=device)
    tracker.reset(simulation.poses[0])
    for pose, frame in zip(simulation.poses[:6], frames):
        result = tracker.track(frame)
        assert result.held
        assert holdfast.pose_error(pose, result.T_camera_object)[0] < 0.003


def test_a_model_is_completed_while_it_is_tracked(box, camera, device, simulation, frames):
    plain = holdfast.Mesh(box.vertices, box.faces, box.uv)
    completion = holdfast.ModelCompletion(plain, camera, frames[0], simulation.poses[0])
    tracker = holdfast.Tracker(completion.mesh, camera, device=device)
    tracker.reset(simulation.poses[0])
    for frame in frames[:6]:
        completion.update(tracker, frame, tracker.track(frame))
    assert completion.frames_taken >= 1 and completion.coverage > 0.2
    with pytest.raises(ValueError, match="frame"):
        completion.update(tracker, frames[0][:, :, 0].copy(), tracker.track(frames[0]))


def test_a_pose_of_points(box, camera, simulation):
    pose = simulation.poses[7]
    corners = np.unique(np.round(box.vertices, 6), axis=0)
    pixels = camera.project(corners @ pose[:3, :3].T + pose[:3, 3])
    found = holdfast.pose_from_points(corners, pixels, camera)
    assert distance(found.T_camera_object, pose) < 1e-6 and found.rms < 1e-6
    square = holdfast.Camera(330, 330, 159.5, 119.5, 320, 240)
    estimated = holdfast.pose_from_points(corners, pixels, width=320, height=240)
    assert estimated.camera.fx == pytest.approx(square.fx, rel=1e-4)
    with pytest.raises(ValueError, match=r"pixels.*\(8, 2\).*\(7, 2\)"):
        holdfast.pose_from_points(corners, pixels[:7], camera)
    with pytest.raises(holdfast.Error) as raised:
        holdfast.pose_from_points(corners[:3], pixels[:3], camera)
    assert raised.value.code == holdfast.ErrorCode.pose


def test_files_of_poses(simulation, tmp_path):
    holdfast.save_pose(tmp_path / "pose.txt", simulation.poses[1])
    assert distance(holdfast.load_pose(tmp_path / "pose.txt"), simulation.poses[1]) < 1e-9
    np.savetxt(tmp_path / "poses.txt", simulation.poses[:, :3].reshape(-1, 12), fmt="%.12g")
    assert distance(holdfast.load_poses(tmp_path / "poses.txt"), simulation.poses) < 1e-9
    with pytest.warns(UserWarning, match="poses.txt' holds {} poses".format(len(simulation))):
        assert distance(holdfast.load_pose(tmp_path / "poses.txt"), simulation.poses[0]) < 1e-9


def test_devices_are_listed(device):
    assert any(each.name == device.info.name and each.usable for each in holdfast.devices())


def test_poses_are_saved_as_the_program_saves_them(tracker, simulation, frames, program, tmp_path):
    results = [None, *(tracker.track(frame) for frame in frames[:3]), simulation.poses[3]]
    holdfast.save_poses(tmp_path / "poses.csv", results, times=[0, 0.1, 0.2, 0.3, 0.4])
    header, *rows = (tmp_path / "poses.csv").read_text().splitlines()
    assert header.startswith("frame,time_s,status,tx,") and rows[0].startswith("0,0.000000,lost,0,0,0,0.0")
    assert [row.split(",")[1:3] for row in rows[1:]] == [[f"0.{i}00000", "held"] for i in range(1, 5)]
    poses = holdfast.load_poses(tmp_path / "poses.csv")
    expected = [np.eye(4), *(result.T_camera_object for result in results[1:4]), simulation.poses[3]]
    assert distance(poses, expected) < 1e-8
    np.savetxt(tmp_path / "truth.txt", simulation.poses[[0, 0, 1, 2, 3], :3].reshape(5, 12))
    program("evaluate", "--poses", tmp_path / "poses.csv", "--truth", tmp_path / "truth.txt")
    (tmp_path / "commented.txt").write_text("# a frame's rvec, tvec\n0 0 0 0 0 1\n")
    assert holdfast.load_poses(tmp_path / "commented.txt")[0, 2, 3] == 1
    holdfast.save_poses(tmp_path / "poses.csv", results)
    assert (tmp_path / "poses.csv").read_text().splitlines()[2].startswith("1,0.033333,held,")
    for wrong in ({"results": results, "times": [0]}, {"results": [np.eye(3)]}):
        with pytest.raises(ValueError, match="times: has 1 for 5 results|results: expected shape"):
            holdfast.save_poses(tmp_path / "poses.csv", **wrong)
    with pytest.raises(holdfast.Error, match="no-such.txt"):
        holdfast.load_poses(tmp_path / "no-such.txt")
