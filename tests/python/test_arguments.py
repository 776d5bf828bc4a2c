"""Arrays and files as arguments: what is taken, and what is said of what is not."""

import inspect
import warnings

import numpy as np
import pytest
from conftest import distance

import holdfast


def padded(frame, by=13):
    """The same pixels as a view of a wider picture."""
    wide = np.full((frame.shape[0], frame.shape[1] + by, *frame.shape[2:]), 77, np.uint8)
    wide[:, : frame.shape[1]] = frame
    return wide[:, : frame.shape[1]]


def pose_of(tracker, start, frame, **arguments):
    tracker.reset(start)
    return tracker.track(frame, **arguments).T_camera_object


def test_formats_and_strides_of_one_picture_give_one_pose(tracker, simulation, frames):
    start, frame = simulation.poses[0], frames[1]
    expected = pose_of(tracker, start, frame)
    rgb = np.ascontiguousarray(frame[:, :, ::-1])
    rgba = np.dstack([rgb, np.zeros(rgb.shape[:2], np.uint8)])
    assert distance(pose_of(tracker, start, padded(frame)), expected) == 0
    assert distance(pose_of(tracker, start, rgba), expected) == 0
    assert distance(pose_of(tracker, start, padded(rgba)), expected) == 0
    assert distance(pose_of(tracker, start, rgb, format=holdfast.PixelFormat.rgb8), expected) == 0
    assert distance(pose_of(tracker, start, rgb), expected) > 0  # taken for BGR
    read_only = frame.copy()
    read_only.flags.writeable = False
    assert distance(pose_of(tracker, start, read_only), expected) == 0


def test_grey_frames_are_taken(tracker, simulation, frames):
    grey = padded(frames[1].mean(axis=2).astype(np.uint8))
    found = pose_of(tracker, simulation.poses[0], grey)
    assert holdfast.pose_error(simulation.poses[1], found)[0] < 0.001


@pytest.mark.parametrize(
    "spoil, error, words",
    [
        (lambda f: f.tolist(), TypeError, ["frame", "list"]),
        (lambda f: None, TypeError, ["frame", "NoneType"]),
        (lambda f: f.astype(np.float32), TypeError, ["frame", "uint8", "float32", "(240, 320, 3)"]),
        (lambda f: f.astype(np.int8), TypeError, ["frame", "int8"]),
        (lambda f: f[:, :, :2], ValueError, ["frame", "(240, 320, 2)"]),
        (lambda f: f[None], ValueError, ["frame", "(1, 240, 320, 3)"]),
        (lambda f: f[0, 0], ValueError, ["frame", "(3,)"]),
        (lambda f: f[:0], ValueError, ["frame", "(0, 320, 3)"]),
        (lambda f: f[:120], ValueError, ["frame", "240 rows", "(120, 320, 3)"]),
        (lambda f: f.transpose(1, 0, 2).copy(), ValueError, ["frame", "240 rows", "(320, 240, 3)", "exchanged"]),
        (lambda f: f[::-1], ValueError, ["frame", "strides", "ascontiguousarray"]),
        (lambda f: f[:, ::-1], ValueError, ["frame", "strides", "ascontiguousarray"]),
        (lambda f: f[:, :, ::-1], ValueError, ["frame", "strides", "ascontiguousarray"]),
        (lambda f: np.asfortranarray(f), ValueError, ["frame", "strides"]),
        (lambda f: np.broadcast_to(f[:1], f.shape), ValueError, ["frame", "strides"]),
        (lambda f: np.dstack([f, f[:, :, :1]])[:, :, :3], ValueError, ["frame", "strides"]),
    ],
)
def test_wrong_frames_are_named(tracker, frames, spoil, error, words):
    with pytest.raises(error) as raised:
        tracker.track(spoil(frames[0]))
    for word in words:
        assert word in str(raised.value)


def test_a_format_that_does_not_fit_is_refused(tracker, frames):
    for wrong in (holdfast.PixelFormat.rgba8, holdfast.PixelFormat.grey8, holdfast.PixelFormat.nv12):
        with pytest.raises(ValueError, match="frame.*format"):
            tracker.track(frames[0], format=wrong)


@pytest.mark.parametrize(
    "pose, error, words",
    [
        (np.eye(3), ValueError, ["T_camera_object", "(4, 4)", "(3, 3)"]),
        (np.zeros(16), ValueError, ["T_camera_object", "(16,)"]),
        ("here", TypeError, ["T_camera_object", "str"]),
        (np.ones((4, 4)), ValueError, ["T_camera_object", "last row"]),
    ],
)
def test_wrong_poses_are_named(tracker, pose, error, words):
    with pytest.raises(error) as raised:
        tracker.reset(pose)
    for word in words:
        assert word in str(raised.value)


def test_poses_of_other_kinds_are_taken(tracker, simulation, frames):
    start = simulation.poses[0]
    expected = pose_of(tracker, start, frames[1])
    for same in (start.tolist(), start[:3], np.asfortranarray(start)):
        assert distance(pose_of(tracker, same, frames[1]), expected) == 0


def test_the_librarys_errors_have_a_code(box, camera, tmp_path):
    assert issubclass(holdfast.Error, RuntimeError)
    with pytest.raises(holdfast.Error, match="no-such.obj") as raised:
        holdfast.Tracker(tmp_path / "no-such.obj", camera)
    assert raised.value.code == holdfast.ErrorCode.file
    with pytest.raises(holdfast.Error) as raised:
        holdfast.Camera(fx=-1, fy=300, cx=160, cy=120, width=320, height=240)
    assert raised.value.code == holdfast.ErrorCode.camera
    with pytest.raises(holdfast.Error) as raised:
        holdfast.Device("no such device")
    assert raised.value.code == holdfast.ErrorCode.device
    with pytest.raises(holdfast.Error) as raised:
        box.save(tmp_path / "no-folder" / "box.obj")
    assert raised.value.code == holdfast.ErrorCode.output


def test_tracking_before_reset_is_an_error(box, camera, device, frames):
    with pytest.raises(holdfast.Error) as raised:
        holdfast.Tracker(box, camera, device=device).track(frames[0])
    assert raised.value.code == holdfast.ErrorCode.invalid_argument


def test_options(box, camera, device):
    chosen = holdfast.Tracker(box, camera, device=device, mode="fast", levels=2, occlusion={"block_vote": False})
    expected = holdfast.default_options("fast")
    expected["levels"] = 2
    expected["occlusion"]["block_vote"] = False
    assert chosen.options == expected
    assert expected["quality"] == "fast" and expected["ablate"] == []
    again = holdfast.Tracker(box, camera, device=device, **{**expected, "ablate": ["velocity"]})
    assert again.options == {**expected, "ablate": ["velocity"]}
    for wrong, words in [
        ({"level": 2}, "no option 'level'.*levels"),
        ({"levels": "two"}, "levels.*'two'"),
        ({"levels": 2.5}, "levels.*2.5"),
        ({"recovery": 1}, "recovery.*True or False"),
        ({"quality": "best"}, "quality.*accurate, fast or paper"),
        ({"ablate": "velocity"}, "ablate.*list of str"),
        ({"occlusion": True}, "occlusion.*dict"),
        ({"occlusion": {"vote": 1}}, "no option 'vote'.*vote_share"),
    ]:
        with pytest.raises(TypeError, match=words):
            holdfast.Tracker(box, camera, device=device, **wrong)
    with pytest.raises(ValueError, match="mode.*quick"):
        holdfast.Tracker(box, camera, device=device, mode="quick")
    with pytest.raises(holdfast.Error, match="ablate.*'luck'.*velocity"):
        holdfast.Tracker(box, camera, device=device, ablate=["luck"])
    with pytest.raises(holdfast.Error, match="levels") as raised:
        holdfast.Tracker(box, camera, device=device, levels=77)
    assert raised.value.code == holdfast.ErrorCode.invalid_argument


def test_cameras(tmp_path):
    k = np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]])
    camera = holdfast.Camera.from_matrix(k, 640, 480, np.array([[0.1, -0.2, 0.001, 0.002, 0.05]]))
    assert distance(camera.matrix, k) == 0
    assert repr(camera) == "Camera(fx=500, fy=510, cx=320, cy=240, width=640, height=480, distortion=...)"
    np.testing.assert_array_equal(camera.distortion, [0.1, -0.2, 0.001, 0.002, 0.05, 0, 0, 0])
    camera.save(tmp_path / "camera.yml")
    assert holdfast.Camera.load(tmp_path / "camera.yml") == camera
    (tmp_path / "K.txt").write_text("500 510 320 240")
    assert holdfast.Camera.load(tmp_path / "K.txt", 640, 480) == holdfast.Camera(500, 510, 320, 240, 640, 480)
    with pytest.raises(holdfast.Error, match="size"):
        holdfast.Camera.load(tmp_path / "K.txt")
    with pytest.raises(ValueError, match="distortion"):
        holdfast.Camera(500, 500, 320, 240, 640, 480, np.arange(1, 15))
    with pytest.raises(ValueError, match="distortion: 3 coefficients.*4, 5 or 8"):
        holdfast.Camera(500, 500, 320, 240, 640, 480, [0.1, 0.2, 0.3])
    with pytest.raises(ValueError, match=r"matrix.*\(3, 3\).*\(2, 2\)"):
        holdfast.Camera.from_matrix(np.eye(2), 640, 480)
    with pytest.raises(ValueError, match="matrix.*transposed"):
        holdfast.Camera.from_matrix(k.T, 640, 480)
    with pytest.raises(ValueError, match="matrix.*scaled"):
        holdfast.Camera.from_matrix(2 * k, 640, 480)
    with pytest.raises(ValueError, match="matrix.*skew of 40"):
        holdfast.Camera.from_matrix(k + [[0, 40, 0], [0, 0, 0], [0, 0, 0]], 640, 480)

    points = np.array([[0.1, -0.05, 0.6], [-0.2, 0.1, 1.0]])
    pinhole = (k @ points.T).T
    np.testing.assert_allclose(camera.project(points, distorted=False), pinhole[:, :2] / pinhole[:, 2:], rtol=1e-12)
    x, y = points[0, :2] / points[0, 2]
    r2 = x * x + y * y  # OpenCV's model, written out
    radial = 1 + 0.1 * r2 - 0.2 * r2**2 + 0.05 * r2**3
    u = 500 * (x * radial + 2 * 0.001 * x * y + 0.002 * (r2 + 2 * x * x)) + 320
    v = 510 * (y * radial + 0.001 * (r2 + 2 * y * y) + 2 * 0.002 * x * y) + 240
    np.testing.assert_allclose(camera.project(points)[0], [u, v], rtol=1e-9)


def test_meshes_of_arrays_and_files(box, camera, device, simulation, frames, tmp_path):
    expected = pose_of(holdfast.Tracker(box, camera, device=device), simulation.poses[0], frames[1])
    box.save(tmp_path / "box.obj")
    arrays = (box.vertices, box.faces, box.uv, box.images[0])

    class Material:
        image = box.images[0]

    class Visual:
        uv, material = box.uv, Material()

    class Trimesh:
        vertices, faces, visual = 1000 * box.vertices.astype(np.float64), box.faces, Visual()

    for model, scale in [(arrays, 1), (tmp_path / "box.obj", 1), (str(tmp_path / "box.obj"), 1), (Trimesh(), 0.001)]:
        tracker = holdfast.Tracker(model, camera, device=device, model_scale=scale)
        assert distance(pose_of(tracker, simulation.poses[0], frames[1]), expected) < 1e-5


def test_a_picture_of_pillow_is_a_texture(box):
    class Picture:  # as much of PIL.Image as is asked of it
        mode = "P"

        def convert(self, mode):
            assert mode == "RGBA"
            return box.images[0]

    mesh = holdfast.Mesh(box.vertices, box.faces, box.uv, Picture())
    assert np.array_equal(mesh.images[0], box.images[0])


@pytest.mark.parametrize(
    "arguments, error, words",
    [
        ({"vertices": np.zeros((4, 2)), "faces": [[0, 1, 2]]}, ValueError, r"vertices.*\(N, 3\).*\(4, 2\)"),
        ({"vertices": np.eye(3), "faces": [[0.5, 1, 2]]}, ValueError, "faces"),
        ({"vertices": np.eye(3), "faces": [[-1, 1, 2]]}, ValueError, "faces"),
        ({"vertices": np.eye(3), "faces": [[0, 1, 3]]}, holdfast.Error, "vertex 3"),
        ({"vertices": np.eye(3), "faces": [[0, 1, 2]], "uv": np.zeros((2, 2))}, ValueError, r"uv.*\(3, 2\).*\(2, 2\)"),
        ({"vertices": np.eye(3), "faces": [[0, 1, 2]], "colors": np.zeros((3, 2))}, ValueError, r"colors.*\(3, 2\)"),
        ({"vertices": np.eye(3), "faces": [[0, 1, 2]], "image": np.zeros((4, 4, 3))}, TypeError, "image.*float64"),
        (
            {"vertices": np.eye(3), "faces": [[0, 1, 2]], "image": np.zeros((4, 4, 3), np.uint8)[:, :, ::-1]},
            ValueError, r"image.*ascontiguousarray of it \(a model's image is RGB\)$",
        ),
        ({"vertices": np.eye(3), "faces": [[0, 1, 2]], "image": "a.png"}, TypeError, "image.*str.*Mesh.load"),
    ],
)
def test_wrong_meshes_are_named(arguments, error, words):
    with pytest.raises(error, match=words):
        holdfast.Mesh(**arguments)


def test_models_and_cameras_of_no_known_kind(box, camera):
    with pytest.raises(TypeError, match="model.*int"):
        holdfast.Tracker(3, camera)
    with pytest.raises(TypeError, match="camera.*tuple"):
        holdfast.Tracker(box, (500, 500))


def test_a_dict_of_a_mesh_has_known_names(camera):
    with pytest.raises(TypeError, match="'verts' is not known.*vertices and faces"):
        holdfast.Tracker({"verts": np.eye(3), "faces": [[0, 1, 2]]}, camera)
    with pytest.raises(TypeError, match="'faces' is missing"):
        holdfast.Tracker({"vertices": np.eye(3)}, camera)


def test_frames_of_another_size_than_the_calibrations_are_refused(camera, tmp_path):
    camera.save(tmp_path / "camera.yml")
    with pytest.raises(holdfast.Error, match="640x480.*320x240: pass rescale=True if"):
        holdfast.Camera.load(tmp_path / "camera.yml", 640, 480)
    with pytest.raises(holdfast.Error, match="no pixels .0x0.: was the video opened"):
        holdfast.Camera.load(tmp_path / "camera.yml", 0, 0)


def test_a_principal_point_far_from_the_middle_is_warned_of(box, device):
    with pytest.warns(UserWarning, match="principal point.*another size"):
        holdfast.Tracker(box, holdfast.Camera(650, 650, 320, 240, 960, 720), device=device)


def test_units_that_cannot_be_right_are_warned_of(tracker, box, camera, device, simulation):
    with pytest.warns(UserWarning, match="millimetres.*model_scale=0.001"):
        holdfast.Tracker((1000 * box.vertices, box.faces), camera, device=device)
    far = simulation.poses[0].copy()
    far[:3, 3] *= 1000
    with pytest.warns(UserWarning, match="too small to see.*millimetres"):
        tracker.reset(far)


def test_what_a_model_has_that_is_not_supported_is_warned_of(tmp_path):
    model = tmp_path / "model.obj"
    model.write_text("mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
    with pytest.warns(UserWarning, match="gone.mtl"):
        mesh = holdfast.Mesh.load(model)
    assert len(mesh.faces) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning):
            holdfast.Mesh.load(model)


def test_a_video_that_ends_early_is_warned_of(program, box, simulation, tmp_path):
    simulation.save(tmp_path)
    box.save(tmp_path / "box.obj")
    holdfast.save_pose(tmp_path / "pose.txt", simulation.poses[0])
    program("track", tmp_path / "frames", "--model", tmp_path / "box.obj", "--camera", tmp_path / "K.txt",
            "--init", tmp_path / "pose.txt", "--overlay", tmp_path / "whole.avi", "--quiet")  # fmt: skip
    whole = (tmp_path / "whole.avi").read_bytes()
    (tmp_path / "cut.avi").write_bytes(whole[: len(whole) // 2])
    with pytest.warns(UserWarning, match="cut.avi.*cut short"):
        frames = list(holdfast.Video(tmp_path / "cut.avi"))
    assert 0 < len(frames) < len(simulation)


def test_fisheye_cameras_of_arrays(tmp_path):
    k, d = np.array([[280.0, 0, 320], [0, 281, 240], [0, 0, 1]]), np.array([[0.1], [-0.02], [0.003], [-0.0004]])
    camera = holdfast.Camera.from_matrix(k, 640, 480, d, lens="fisheye")  # as cv2.fisheye.calibrate returns them
    assert camera == holdfast.Camera(280, 281, 320, 240, 640, 480, d, lens="fisheye")
    assert camera.lens == "fisheye" and repr(camera).endswith("lens='fisheye')")
    np.testing.assert_array_equal(camera.distortion, d.ravel())
    point = np.array([[0.5, -0.3, 1.0]])
    r = np.hypot(0.5, 0.3)
    angle = np.arctan(r)
    bent = angle * (1 + 0.1 * angle**2 - 0.02 * angle**4 + 0.003 * angle**6 - 0.0004 * angle**8) / r
    np.testing.assert_allclose(camera.project(point)[0], [280 * 0.5 * bent + 320, -281 * 0.3 * bent + 240], rtol=1e-9)
    camera.save(tmp_path / "fisheye.yml")
    assert holdfast.Camera.load(tmp_path / "fisheye.yml") == camera
    assert holdfast.Camera.from_matrix(k, 640, 480, lens="fisheye").lens == "fisheye"
    assert holdfast.Camera.from_matrix(k, 640, 480).lens == "polynomial"
    with pytest.raises(ValueError, match="distortion: 5 coefficients; a fisheye lens has 4"):
        holdfast.Camera.from_matrix(k, 640, 480, np.zeros(5), lens="fisheye")
    with pytest.raises(ValueError, match="lens: expected polynomial or fisheye, got 'equidistant'"):
        holdfast.Camera.from_matrix(k, 640, 480, d, lens="equidistant")
    with pytest.raises(ValueError, match="skew of 1.*CALIB_FIX_SKEW"):
        holdfast.Camera.from_matrix(k + [[0, 1, 0], [0, 0, 0], [0, 0, 0]], 640, 480, d, lens="fisheye")


def test_bgra_frames_are_those_of_bgr(tracker, simulation, frames):
    start, frame = simulation.poses[0], frames[1]
    bgra = np.dstack([frame, np.zeros(frame.shape[:2], np.uint8)])
    expected = pose_of(tracker, start, frame)
    assert distance(pose_of(tracker, start, bgra, format=holdfast.PixelFormat.bgra8), expected) < 1e-6
    assert distance(pose_of(tracker, start, padded(bgra), format=holdfast.PixelFormat.bgra8), expected) < 1e-6
    tracker.find(bgra, format=holdfast.PixelFormat.bgra8)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda h, t: h.Camera("300", 300, 160, 120, 320, 240), "^fx: expected float, got str '300'$"),
        (lambda h, t: h.Camera(300, 300, 160, 120, 320.5, 240), "^width: expected int, got float 320.5$"),
        (lambda h, t: h.Camera(300, 300, 160, 120), r"^Camera\(\): missing .*'width'; arguments: fx, fy, cx, cy, width"),
        (lambda h, t: h.Camera(300, 300, 160, 120, 320, 240, w=3), r"^Camera\(\): .*unexpected keyword argument 'w'"),
        (lambda h, t: h.Camera(1, 1, 1, 1, np.float64(320), 240), "^width: expected int, got float64 320.0$"),
        (lambda h, t: h.Camera.from_matrix(None, 640, 480), "^matrix: expected numpy.typing.ArrayLike, got NoneType$"),
        (lambda h, t: h.Camera.load("c.yml", "640", 480), r"^width: expected int \| None, got str '640'$"),
        (lambda h, t: h.Camera.load(3), r"^path: expected str \| os.PathLike, got int 3$"),
        (lambda h, t: h.Mesh(np.eye(3)), r"^Mesh\(\): missing .*'faces'"),
        (lambda h, t: h.Mesh.load("m.obj", "mm"), "^scale: expected float, got str 'mm'$"),
        (lambda h, t: h.Renderer("m.obj", 3, 4), r"^mesh: expected Mesh, got str 'm.obj'; Mesh.load\(\) reads a file"),
        (lambda h, t: h.Simulation(None), "^mesh: expected Mesh, got NoneType; "),
        (lambda h, t: h.Device(3), "^device: expected str, got int 3$"),
        (lambda h, t: h.Device("cpu", "strips"), "^partition: expected Partition, got str .*; .*Partition.strips"),
        (lambda h, t: h.load_pose(np.eye(4)), "^path: expected .*, got float64 array of shape"),
        (lambda h, t: h.save_poses("p.csv", []) or h.save_poses("p.csv"), "^save_poses.*missing.*'results'"),
        (lambda h, t: t.track(), r"^track\(\): missing a required argument: 'frame'"),
        (lambda h, t: t.track(np.zeros((240, 320), np.uint8), "0.1"), r"^time: expected float \| None, got str '0.1'"),
        (lambda h, t: t.track(np.zeros((240, 320), np.uint8), format="rgb8"), "^format: .*'rgb8'; .*PixelFormat.rgb8"),
        (lambda h, t: t.reset(), r"^reset\(\): missing a required argument: 'T_camera_object'; arguments: T_camera"),
        (lambda h, t: t.remember(None), "^path: expected .*, got NoneType$"),
        (lambda h, t: t.set_texture(-1, np.zeros((4, 4), np.uint8)), "^material: -1 is out of range$"),
        (lambda h, t: h.evaluate("t", [], []), r"^tracker: expected Tracker, got str 't'; Tracker\(model, camera\)"),
        (lambda h, t: h.evaluate(t, [], [], visible="all", offset=-1), r"^evaluate\(\): arguments do not fit: "),
        (lambda h, t: h.decode_image(bytearray(b"x")), "^data: expected bytes, got bytearray$"),
        (lambda h, t: h.decode_image(np.zeros(3, np.uint8)), r"^data: expected bytes, got uint8 array of shape \(3,\)"),
        (lambda h, t: h.default_options(3), "^mode: expected str, got int 3$"),
    ],
)  # fmt: skip
def test_arguments_of_the_wrong_type_are_named(tracker, tmp_path, monkeypatch, call, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(TypeError, match=words):
        call(holdfast, tracker)


def test_signatures_are_known_to_tools():
    assert str(inspect.signature(holdfast.Camera.load)) == (
        "(path: 'str | os.PathLike', width: 'int | None' = None, height: 'int | None' = None, rescale: 'bool' = False)"
        " -> 'Camera'"
    )
    assert list(inspect.signature(holdfast.Tracker.track).parameters) == ["self", "frame", "time", "format"]


def test_a_picture_of_pillow_is_no_frame(tracker, frames):
    class Picture:  # as much of PIL.Image as is asked of it
        mode = "RGB"

        def convert(self, mode):
            assert mode == "RGB"
            return frames[0][..., ::-1]

    with pytest.raises(TypeError) as raised:
        tracker.track(Picture())
    repair = str(raised.value).partition(": pass ")[2]
    assert np.array_equal(eval(repair, {"numpy": np, "picture": Picture()}), frames[0])
    tracker.track(eval(repair, {"numpy": np, "picture": Picture()}))


def test_what_newcomers_pass_is_answered(tracker, simulation, box, camera, frames, device):
    with pytest.raises(TypeError, match=r"frames: expected a list.*\[frame.image for frame in Video"):
        holdfast.evaluate(tracker, iter(frames), simulation.poses)
    with pytest.raises(ValueError, match=r"T_camera_object: .*\(3,\); of OpenCV's rvec and tvec: .*cv2.Rodrigues"):
        tracker.reset(np.zeros(3), np.zeros(3))
    with pytest.raises(ValueError, match=r"estimate: expected shape \(4, 4\), got list of shape \(2, 4, 4\)$"):
        holdfast.pose_error(np.eye(4), [np.eye(4), np.eye(4)])
    with pytest.raises(TypeError, match=r"no option 'speed'.*it is one of motion: motion=\{'speed': ...\}"):
        holdfast.Simulation(box, camera, speed=3)
    with pytest.raises(TypeError, match="renderer: expected a Renderer, got Mesh; Renderer"):
        holdfast.outlines(box, np.eye(4), camera)
    assert repr(simulation) == f"<Simulation of {len(frames)} frames of 320x240 pixels>"
