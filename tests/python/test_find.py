"""Tracker.find(): starts without a pose, by texture or near a guide."""

import numpy as np
import pytest

import holdfast

SEEN = 3  # frames in a row that a guide needs


@pytest.fixture(autouse=True, scope="module")
def views_of_its_own(tmp_path_factory):
    """Models are drawn here, not in the user's cache folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOLDFAST_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        yield


def turned(pose, axis, degrees):
    """About the object's origin."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    k, angle = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.radians(degrees)
    result = pose.copy()
    result[:3, :3] = (np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k) @ pose[:3, :3]
    return result


def is_right(truth, pose, metres=0.002, degrees=1.0):
    off_metres, off_radians = holdfast.pose_error(truth, pose)
    return off_metres < metres and off_radians < np.radians(degrees)


@pytest.fixture(scope="module")
def big_camera():
    return holdfast.Camera(fx=650, fy=650, cx=319.5, cy=239.5, width=640, height=480)


@pytest.fixture(scope="module")
def anywhere(box, big_camera):
    """The box shown from six sides, in six places."""
    front = holdfast.Simulation(box, big_camera, frames=1, seed=3).poses[0]
    poses = []
    for i, (axis, degrees) in enumerate([((0, 1, 0), 0), ((0, 1, 0), 130), ((1, 0.3, 0), 100), ((1, 1, 0), 180),
                                         ((0, 0, 1), 90), ((0.2, 1, 0.4), 250)]):
        pose = turned(front, axis, degrees)
        pose[:3, 3] = [0.05 * (i % 3 - 1), 0.03 * (i % 2), 0.6 + 0.04 * i]
        poses.append(pose)
    return holdfast.Simulation(box, big_camera, frames=len(poses), poses=poses, seed=4)


def test_a_textured_object_is_found_anywhere_and_followed(box, big_camera, device, anywhere):
    tracker = holdfast.Tracker(box, big_camera, device=device)
    found = 0
    for i, pose in enumerate(anywhere.poses):
        result = tracker.find(anywhere[i].image)
        if result is None:
            continue
        assert result.held and is_right(pose, result.T_camera_object)
        assert is_right(pose, tracker.track(anywhere[i].image).T_camera_object)
        found += 1
    assert found >= 5


def test_the_loop_of_the_documents(box, camera, device, simulation, frames):
    tracker = holdfast.Tracker(box, camera, device=device)
    results, result = [], None
    for number, frame in enumerate([np.full_like(frames[0], 90), *frames[:5]]):
        result = tracker.track(frame, 0.1 * number) if result else tracker.find(frame, 0.1 * number)
        results.append(result)
    assert results[0] is None
    assert all(is_right(pose, result.T_camera_object) for pose, result in zip(simulation.poses, results[1:]))


def test_what_is_not_there_is_none_and_changes_nothing(box, camera, device, simulation, frames):
    def run(looking):
        tracker = holdfast.Tracker(box, camera, device=device)
        tracker.reset(simulation.poses[0])
        rng = np.random.default_rng(2)
        poses = []
        for frame in frames[:3]:
            poses.append(tracker.track(frame).T_camera_object)
            if looking:
                assert tracker.find(rng.integers(0, 255, frame.shape, np.uint8)) is None
        return np.array(poses)

    assert np.array_equal(run(True), run(False))


def test_a_plain_object_is_found_near_a_guide(box, camera, device):
    plain = holdfast.Mesh(box.vertices, box.faces, colors=np.tile([200, 60, 40], (len(box.vertices), 1)))
    shown = holdfast.Simulation(plain, camera, frames=SEEN + 2, samples=2, seed=3, motion={"speed": 0.5})
    tracker = holdfast.Tracker((box.vertices, box.faces), camera, device=device)
    guide = turned(shown.poses[0], (0.4, 1, 0.2), 8)
    guide[0, 3] += 0.01
    results = [tracker.find(shown[i].image, guide=guide) for i in range(SEEN)]
    assert results[: SEEN - 1] == [None] * (SEEN - 1)
    assert is_right(shown.poses[SEEN - 1], results[-1].T_camera_object, 0.01, 3)
    assert tracker.track(shown[SEEN].image).held
    with pytest.raises(holdfast.Error, match="texture") as raised:
        tracker.find(shown[0].image)
    assert raised.value.code == holdfast.ErrorCode.model


def test_wrong_arguments_are_named(tracker, frames, simulation):
    with pytest.raises(ValueError, match="guide"):
        tracker.find(frames[0], guide=np.eye(3))
    with pytest.raises(ValueError, match="frame"):
        tracker.find(frames[0][:100])
    behind = simulation.poses[0].copy()
    behind[2, 3] = -1
    with pytest.raises(holdfast.Error, match="behind") as raised:
        tracker.find(frames[0], guide=behind)
    assert raised.value.code == holdfast.ErrorCode.pose


def test_what_a_run_remembers_starts_the_next_one(box, big_camera, device, tmp_path):
    """The print is on the object, not in the model."""
    shown = holdfast.Simulation(box, big_camera, frames=6, samples=2, seed=3, motion={"speed": 2.0})
    shape, path = (box.vertices, box.faces), tmp_path / "box.seen"

    def tracker():
        made = holdfast.Tracker(shape, big_camera, device=device)
        made.remember(path)
        return made

    first = tracker()
    with pytest.raises(holdfast.Error, match="texture.*box.seen' does not exist"):
        first.find(shown[0].image)
    assert not path.exists()
    first.reset(shown.poses[0])
    assert all(first.track(shown[i].image).held for i in range(len(shown)))
    assert 1000 < path.stat().st_size < 200_000

    found = tracker().find(shown[5].image)
    assert found.held and is_right(shown.poses[5], found.T_camera_object, 0.01, 3)
    # What is learned counts at once: after a loss, say.
    assert first.find(shown[2].image).held

    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(holdfast.Error, match="damaged") as raised:
        tracker()
    assert raised.value.code == holdfast.ErrorCode.file
    with pytest.raises(holdfast.Error, match="nowhere") as raised:
        first.remember(tmp_path / "nowhere" / "box.seen")
    assert raised.value.code == holdfast.ErrorCode.output
    path.write_text("x,y,z,u,v\n0,0,0,1,1\n")
    with pytest.raises(holdfast.Error, match="is no file of views or of remembered features: name another file$"):
        first.remember(path)
