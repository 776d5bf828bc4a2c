"""Values, which are copied and sent to other processes, and objects that are not."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest

import holdfast


def same(a, b):
    """Equal in all that is public, arrays and values within values included."""
    assert type(a) is type(b)
    if isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b)
    elif isinstance(a, (list, tuple)):
        assert len(a) == len(b) and all(same(x, y) for x, y in zip(a, b))
    elif type(a).__module__ == "holdfast._core" and not hasattr(type(a), "__members__"):
        for name in dir(a):
            if not name.startswith("_") and not callable(getattr(a, name)):
                assert same(getattr(a, name), getattr(b, name)), name
    else:
        assert a == b
    return True


def copies_of(value):
    return [copy.copy(value), copy.deepcopy(value), pickle.loads(pickle.dumps(value))]


def refined(pose):  # in another process
    box, camera = holdfast.textured_box(), holdfast.Camera(330, 330, 159.5, 119.5, 320, 240)
    tracker = holdfast.Tracker(box, camera)
    return tracker.refine(holdfast.Simulation(box, camera, poses=[pose], samples=1)[0].image, pose)


def test_values_are_copied_and_pickled(tracker, simulation, frames, box, camera, tmp_path):
    result = tracker.track(frames[1])
    simulation.save(tmp_path / "saved", masks=True)
    video = holdfast.Video(tmp_path / "saved" / "frames")
    points = box.vertices[[0, 5, 11, 17, 20, 23]]
    pixels = camera.project(points @ simulation.poses[0][:3, :3].T + simulation.poses[0][:3, 3])
    fisheye = holdfast.Camera(330, 330, 160, 120, 320, 240, [0.1, 0.2, 0.3, 0.4], lens="fisheye")
    for value in [
        result, result.texture, result.ms, camera, fisheye, box, tracker.rendered_view(), simulation[1], next(video),
        holdfast.load_sequence(tmp_path / "saved"), holdfast.pose_from_points(points, pixels, camera),
        holdfast.evaluate(tracker, frames[:2], simulation.poses[:2])[1], holdfast.devices()[0], holdfast.Status.lost,
        holdfast.PixelFormat.rgb8, holdfast.Mesh(box.vertices, box.faces, colors=np.ones((24, 3))),
    ]:  # fmt: skip
        for again in copies_of(value):
            assert same(again, value)


def test_results_come_back_from_other_processes(simulation):
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        (result,) = pool.map(refined, [simulation.poses[0]])
    assert result.held and holdfast.pose_error(simulation.poses[0], result.T_camera_object)[0] < 0.001


def test_what_is_no_value_says_so(tracker, simulation, device, box, camera, tmp_path):
    renderer = holdfast.Renderer(box, 320, 240)
    baker = holdfast.TextureBaker(box, camera, simulation.poses[0])
    for unique in [tracker, simulation, device, renderer, baker]:
        for way in [copy.copy, copy.deepcopy, pickle.dumps]:
            with pytest.raises(TypeError, match=f"a {type(unique).__name__} cannot be copied or pickled: make one"):
                way(unique)


def test_a_damaged_pickle_is_refused(camera):
    for state in [(), (1, 2), (320, 240, 1.0, 1.0, 0.0, 0.0, b"short", 0)]:
        with pytest.raises(ValueError, match="another version"):
            holdfast.Camera.__new__(holdfast.Camera).__setstate__(state)


def test_damaged_pictures_and_meshes_are_refused(tracker, simulation, frames, box, camera):
    tracker.track(frames[1])
    evaluated = holdfast.evaluate(tracker, frames[:2], simulation.poses[:2])[1]
    for value, place, wrong in [
        (tracker.rendered_view(), 0, 7777), (tracker.rendered_view(), 1, -1), (tracker.rendered_view(), 2, b""),
        (simulation[1], 0, np.uint8(3)), (simulation[1], 0, np.zeros(3, np.uint8)), (simulation[1], 0, "frame"),
        (box, 5, [("name", (1000, 1000, b"rgba"))]), (camera, 0, "wide"), (evaluated, 11, (1, 2)),
    ]:  # fmt: skip
        state = list(value.__getstate__())
        state[place] = wrong
        with pytest.raises(ValueError, match="another version"):
            type(value).__new__(type(value)).__setstate__(tuple(state))
    state = list(box.__getstate__())
    state[0] = state[0][:12]
    with pytest.raises(holdfast.Error, match="vertices"):
        holdfast.Mesh.__new__(holdfast.Mesh).__setstate__(tuple(state))


def test_attributes_of_subclasses_are_not_lost_in_silence():
    class Named(holdfast.Camera):
        pass

    named = Named(330, 330, 160, 120, 320, 240)
    assert copy.copy(named) == named and type(copy.copy(named)) is Named
    named.name = "left"
    with pytest.raises(TypeError, match="attributes of a subclass"):
        copy.copy(named)
