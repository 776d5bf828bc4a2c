"""Tracking: the same poses as the program, results, memory, threads and processes."""

import gc
import json
import multiprocessing
import os
import re
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import distance

import holdfast
from holdfast.geometry import camera_covariance, matrix_of, standard_deviations


@pytest.mark.parametrize("mode", ["default", "fast"])
def test_poses_are_the_programs(program, tmp_path, mode):
    program("simulate", tmp_path / "box", "--frames", 20, "--size", "320x240", "--occluder", "bar", "--quiet")
    recorded = holdfast.load_sequence(tmp_path / "box")
    holdfast.save_pose(tmp_path / "pose.txt", recorded.poses[0])
    program(
        *("track", tmp_path / "box" / "frames", "--model", recorded.model, "--camera", tmp_path / "box" / "K.txt"),
        *("--init", tmp_path / "pose.txt", "--json", tmp_path / "run.json", "--quiet", "--mode", mode),
    )
    expected = json.loads((tmp_path / "run.json").read_text())["frames"]

    video = holdfast.Video(tmp_path / "box" / "frames")
    camera = holdfast.Camera.load(tmp_path / "box" / "K.txt", video.width, video.height)
    tracker = holdfast.Tracker(recorded.model, camera, mode=mode)
    tracker.reset(holdfast.load_pose(tmp_path / "pose.txt"))
    results = [tracker.track(frame.image, frame.time) for frame in video]
    assert len(results) == len(expected) == 20
    for result, frame in zip(results, expected):
        assert result.status.name == frame["status"]
        assert distance(result.T_camera_object, matrix_of(frame["translation"], frame["quaternion_xyzw"])) < 1e-9
        np.testing.assert_allclose(result.information, frame["information"], rtol=1e-9)


def test_the_object_is_followed(tracker, simulation, frames):
    for pose, frame in zip(simulation.poses, frames):
        result = tracker.track(frame)
        assert result.held and result.status == holdfast.Status.held
        assert not result.reason and result.reason == holdfast.Reason.none and result.message == ""
        assert result.texture.asked and result.texture.holds
        assert 0 < result.texture.used_pixels <= result.texture.gradient_pixels <= result.visible_pixels
        assert 0 < result.texture.inlier_ratio <= 1
        metres, radians = holdfast.pose_error(pose, result.T_camera_object)
        assert metres < 0.001 and radians < np.radians(0.5)
        assert result.covariance.shape == result.information.shape == (6, 6)
        np.testing.assert_allclose(result.covariance @ result.information, np.eye(6), atol=1e-6)


def test_results_print_what_they_hold(tracker, frames):
    result = tracker.track(frames[1])
    assert re.match(r"<TextureEvidence enough alone: \d+ of \d+ gradient pixels used", repr(result.texture))
    assert re.match("<ContourEvidence .*lines near|<ContourEvidence not asked>", repr(result.contour))
    assert re.match("<EdgeEvidence .*lines near|<EdgeEvidence not asked>", repr(result.edges))
    assert repr(result.snapshot) == "<SnapshotEvidence not asked>"
    assert re.match(r"<RenderedView of \d+x\d+ pixels>", repr(tracker.rendered_view()))


def test_evidence_outlives_its_result(tracker, frames):
    result = tracker.track(frames[0])
    texture, contour, edges = result.texture, result.contour, result.edges
    del result
    gc.collect()
    assert texture.used_pixels > 0 and texture.correlation > 0.5
    assert contour.asked and 0 < contour.near_lines <= contour.lines
    assert isinstance(edges, holdfast.EdgeEvidence)
    assert edges.asked and 0 < edges.near_lines <= edges.lines
    assert 0 < edges.score <= 1 and 0 < edges.residual < 3


def test_what_is_not_there_is_lost_without_an_exception(tracker, frames):
    tracker.track(frames[0])
    rng = np.random.default_rng(1)
    for _ in range(3):
        result = tracker.track(rng.integers(0, 255, frames[0].shape, np.uint8))
    assert result.status == holdfast.Status.lost and result.message and result.reason != holdfast.Reason.none
    assert result.reason and not holdfast.Reason.none
    assert "lost" in repr(result)


def test_the_covariance_of_a_pose_that_nothing_tells_is_infinite(box, camera, device, simulation, frames):
    tracker = holdfast.Tracker(box, camera, device=device, contour=False)
    tracker.reset(simulation.poses[0])
    result = tracker.track(np.full_like(frames[0], 128))
    assert not result.held and not result.information.any()
    expected = np.diag(np.full(6, np.inf))
    assert np.array_equal(result.covariance, expected)
    assert np.array_equal(camera_covariance(result), expected)
    assert standard_deviations(result) == (np.inf, np.inf)


def test_refine_leaves_the_tracker_alone(box, camera, device, simulation, frames):
    def run(refining):
        tracker = holdfast.Tracker(box, camera, device=device)
        tracker.reset(simulation.poses[0])
        poses = []
        for i in range(4):
            poses.append(tracker.track(frames[i]).T_camera_object)
            if refining:
                refined = tracker.refine(frames[20], simulation.poses[19])
                assert holdfast.pose_error(simulation.poses[20], refined.T_camera_object)[0] < 0.001
        return poses

    assert distance(run(refining=True), run(refining=False)) == 0


def test_reset_takes_the_frame_it_is_the_pose_in(tracker, simulation, frames):
    tracker.reset(simulation.poses[2], frames[2], time=0.0)
    result = tracker.track(frames[3], time=0.1)
    assert result.held and holdfast.pose_error(simulation.poses[3], result.T_camera_object)[0] < 0.001
    for time in (0.1, 0.05, float("nan")):
        with pytest.raises(holdfast.Error, match="time") as raised:
            tracker.track(frames[4], time=time)
        assert raised.value.code == holdfast.ErrorCode.invalid_argument
    with pytest.raises(ValueError, match="frame"):
        tracker.reset(simulation.poses[2], frames[2][:10])


@pytest.mark.parametrize("scale", [1 / 30, 1000.0])
def test_the_unit_of_time_does_not_matter(tracker, simulation, frames, scale):
    def run(times):
        tracker.reset(simulation.poses[0])
        return [tracker.track(frame, time).T_camera_object for frame, time in zip(frames[:8], times)]

    assert distance(run([None] * 8), run(scale * np.arange(8))) < 1e-9


def test_mask_and_rendered_view(tracker, simulation, frames, camera):
    result = tracker.track(frames[0])
    mask = tracker.mask()
    assert mask.shape == (camera.height, camera.width) and mask.dtype == np.uint8
    used = mask == int(holdfast.PixelClass.used)
    on_object = simulation[0].object_mask > 0
    assert np.count_nonzero(used) > 500
    assert np.count_nonzero(used & ~on_object) < 0.02 * np.count_nonzero(used)
    assert set(np.unique(mask)) <= {int(each) for each in holdfast.PixelClass}

    view = tracker.rendered_view()
    assert view.rgba.shape == (camera.height, camera.width, 4) and view.depth.shape == mask.shape
    assert distance(view.T_camera_object, result.T_camera_object) < 0.01
    tracker.track(frames[1])  # arrays stay as they are
    assert np.array_equal(mask, mask.copy()) and np.count_nonzero(mask == int(holdfast.PixelClass.used)) > 500


def test_renderer_draws_where_the_simulation_does(box, camera, simulation):
    pose = simulation.poses[5]
    view = holdfast.Renderer(box, camera.width, camera.height).render(pose, camera)
    drawn, seen = view.depth > 0, simulation[5].object_mask > 127
    assert np.count_nonzero(drawn != seen) < 0.01 * np.count_nonzero(seen)
    # A point of the front face is as far away as its pose says.
    front = pose @ [0, 0, box.vertices[:, 2].max(), 1]
    u, v = np.rint(camera.project(front[None, :3])[0]).astype(int)
    assert abs(view.depth[v, u] - front[2]) < 0.001
    part = holdfast.Renderer(box, 64, 48).render(pose, camera, (u - 32, v - 24, 64, 48))
    np.testing.assert_allclose(part.depth, view.depth[v - 24 : v + 24, u - 32 : u + 32], atol=1e-4)


def test_a_call_costs_little_beside_the_frame(tracker, frames):
    """What Python adds: all of the call that is not the tracker's own time."""
    tracker.track(frames[0])
    shares = []
    for frame in frames:
        start = time.perf_counter()
        result = tracker.track(frame)
        shares.append(1 - 1e-3 * result.ms.total / (time.perf_counter() - start))
    assert 0 <= np.median(shares) < 0.05


def test_memory_stays(tracker, simulation, frames):
    """`make endurance` makes 10,000 calls."""
    calls = int(os.environ.get("HOLDFAST_CALLS", 300))

    def run(calls):
        for i in range(calls):
            if i % len(frames) == 0:
                tracker.reset(simulation.poses[0])
            result = tracker.track(frames[i % len(frames)])
            assert result.information.shape == (6, 6)
            tracker.mask()
            tracker.rendered_view().depth
            with pytest.raises(ValueError):
                tracker.track(frames[0][::-1])
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE") / 2**20

    before = run(60)
    after = run(calls)
    print(f"{calls} calls: {after - before:+.1f} MB")
    # One array that is kept a call would be 23 MB (a mask) to 90 MB (a view's depth), of 300 calls.
    assert after - before < 10


@pytest.mark.parametrize("shared", [False, True])
def test_two_trackers_in_two_threads(box, camera, device, simulation, frames, shared):
    def run(results):
        tracker = holdfast.Tracker(box, camera, device=device if shared else None)
        tracker.reset(simulation.poses[0])
        results.extend(tracker.track(frame).T_camera_object for frame in frames)

    alone, found = [], [[], []]
    run(alone)
    threads = [threading.Thread(target=run, args=(results,)) for results in found]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for results in found:
        assert distance(results, alone) == 0


def test_one_tracker_in_two_threads_takes_turns(tracker, simulation, frames):
    expected = tracker.refine(frames[4], simulation.poses[3]).T_camera_object
    found = [[], []]

    def run(results):
        for _ in range(10):
            results.append(tracker.refine(frames[4], simulation.poses[3]).T_camera_object)

    threads = [threading.Thread(target=run, args=(results,)) for results in found]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert distance(found, np.broadcast_to(expected, (2, 10, 4, 4))) == 0


def test_the_interpreter_runs_while_a_tracker_works(tracker, frames):
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.0005)

    thread = threading.Thread(target=tick)
    thread.start()
    spans = []
    for frame in frames:
        start = time.perf_counter()
        tracker.track(frame)
        spans.append((start, time.perf_counter()))
    done.set()
    thread.join()
    # With the lock held throughout, no tick would fall well inside of a call. A busy machine has few.
    inside = sum(any(a + 0.25 * (b - a) < t < b - 0.25 * (b - a) for t in ticks) for a, b in spans)
    assert inside >= 3


def fork(work):
    """The result of `work` in a forked process, or its error."""
    context = multiprocessing.get_context("fork")
    answers = context.Queue()

    def run():
        try:
            answers.put(work())
        except holdfast.Error as error:
            answers.put(error)

    child = context.Process(target=run)
    child.start()
    try:
        return answers.get(timeout=60)
    finally:
        child.kill()
        child.join()


def test_a_forked_process_is_told_to_be_spawned(tracker, box, camera, frames):
    tracker.track(frames[0])
    renderer = holdfast.Renderer(box, camera.width, camera.height)
    for work in (
        lambda: holdfast.Tracker(box, camera),
        lambda: tracker.track(frames[1]),
        lambda: renderer.render(np.eye(4), camera),
        lambda: holdfast.Device(),
    ):
        error = fork(work)
        assert isinstance(error, holdfast.Error) and "'spawn'" in str(error)
        assert error.code == holdfast.ErrorCode.device
    assert tracker.track(frames[1]).held
