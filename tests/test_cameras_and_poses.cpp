// Reading and writing cameras and poses: every layout that is about, and one line for what cannot be used.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "holdfast/io.hpp"
#include "support/check_error.hpp"

using namespace holdfast;
using holdfast::test::TemporaryFolder;

namespace {

void check_camera(const Camera& camera, int width, int height) {
  CHECK(camera.width == width);
  CHECK(camera.height == height);
  CHECK(camera.fx == 661.5);
  CHECK(camera.fy == 662.25);
  CHECK(camera.cx == 318.75);
  CHECK(camera.cy == 241);
}

const std::array<double, 8> kFive{-0.25, 0.125, 0.001, -0.002, 0.03, 0, 0, 0};

}  // namespace

TEST_CASE("Cameras: OpenCV's calibration files, as OpenCV itself writes them") {
  const TemporaryFolder folder;
  const cv::Matx33d matrix(661.5, 0, 318.75, 0, 662.25, 241, 0, 0, 1);
  const cv::Matx<double, 1, 5> distortion(-0.25, 0.125, 0.001, -0.002, 0.03);
  for (const char* name : {"c.yml", "c.yaml", "c.json", "c.xml"}) {
    CAPTURE(name);
    for (const auto& [width, matrix_name, distortion_name] :
         {std::tuple{"image_width", "camera_matrix", "distortion_coefficients"},
          std::tuple{"image_Width", "cameraMatrix", "distCoeffs"},
          std::tuple{"width", "Camera_Matrix", "Distortion_Coefficients"}}) {
      const std::string height = std::string(width) == "width" ? "height" : "image_height";
      {
        cv::FileStorage storage((folder / name).string(), cv::FileStorage::WRITE);
        storage << "calibration_time"
                << "Tue 02 Mar 2021 10:00:00"
                << "nframes" << 30;
        storage << width << 640 << height << 480 << matrix_name << cv::Mat(matrix);
        storage << distortion_name << cv::Mat(distortion).t() << "avg_reprojection_error" << 0.3;
      }
      const Camera camera = io::load_camera(folder / name);
      check_camera(camera, 640, 480);
      CHECK(camera.distortion == kFive);
    }
  }
}

TEST_CASE("Cameras: ROS camera_info") {
  const TemporaryFolder folder;
  const auto ros = [&folder](const std::string& model, const std::string& coefficients) {
    return folder.write("ros.yaml",
                        "image_width: 640\nimage_height: 480\ncamera_name: head_camera\ncamera_matrix:\n  rows: 3\n  "
                        "cols: 3\n  data: [661.5, 0., 318.75, 0., 662.25, 241., 0., 0., 1.]\ndistortion_model: " +
                            model + "\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [" + coefficients +
                            "]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1., 0., 0., 0., 1., 0., 0., 0., "
                            "1.]\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: [600., 0., 300., 0., 0., 610., "
                            "240., 0., 0., 0., 1., 0.]\n");
  };
  Camera camera = io::load_camera(ros("plumb_bob", "-0.25, 0.125, 0.001, -0.002, 3.0e-02"));
  check_camera(camera, 640, 480);
  CHECK(camera.distortion == kFive);
  camera = io::load_camera(ros("rational_polynomial", "1, 2, 3, 4, 5, 6, 7, 8"));
  CHECK(camera.distortion == std::array<double, 8>{1, 2, 3, 4, 5, 6, 7, 8});
  CHECK_ERROR(io::load_camera(ros("fov", "1, 2, 3, 4")), ErrorCode::camera, "ros.yaml", "distortion model 'fov'",
              "not supported");
  CHECK_ERROR(io::load_camera(ros("plumb_bob", "1, 2, 3")), ErrorCode::camera, "3 distortion coefficients");
  CHECK_ERROR(io::load_camera(ros("plumb_bob", "1, 2, 3, x")), ErrorCode::camera, "not a number");
}

TEST_CASE("Cameras: lists, single numbers, text") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_camera(folder.write("c.txt", text)); };
  Camera camera = load(R"({"camera_matrix": [[661.5, 0, 318.75], [0, 662.25, 241], [0, 0, 1]],
                          "dist_coeff": [[-0.25, 0.125, 0.001, -0.002, 0.03]], "image_size": [640, 480]})");
  check_camera(camera, 640, 480);
  CHECK(camera.distortion == kFive);
  check_camera(load("fx: 661.5\nfy: 662.25\ncx: 318.75\ncy: 241\nwidth: 640\nheight: 480\n"), 640, 480);
  check_camera(load("# fx fy cx cy\n661.5 662.25 318.75 241\n"), 0, 0);
  check_camera(load("661.5, 662.25, 318.75, 241"), 0, 0);
  check_camera(load("661.5 0 318.75\n0 662.25 241\n0 0 1\n"), 0, 0);
}

TEST_CASE("Cameras: fisheyes under every name, Kalibr's chain") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_camera(folder.write("c.yaml", text)); };
  const std::array<double, 8> four{0.1, -0.02, 0.003, -0.0004, 0, 0, 0, 0};
  const std::string rest =
      "image_width: 640\nimage_height: 480\ncamera_matrix: [661.5, 0, 318.75, 0, 662.25, 241, 0, 0, "
      "1]\ndistortion_coefficients: [0.1, -0.02, 0.003, -0.0004]\n";
  for (const char* name : {"distortion_model: equidistant", "distortion_model: fisheye", "camera_model: fisheye",
                           "camera_model: fisheye\ndistortion_model: plumb_bob", "fisheye_model: 1", "fisheye: true",
                           "model_type: KANNALA_BRANDT", "camera_model: pinhole\ndistortion_model: equidistant"}) {
    CAPTURE(name);
    const Camera camera = load(std::string(name) + "\n" + rest);
    check_camera(camera, 640, 480);
    CHECK(camera.lens == LensModel::fisheye);
    CHECK(camera.distortion == four);
    CHECK(camera.has_distortion());
  }
  CHECK(load(rest).lens == LensModel::polynomial);
  const std::string chain =
      "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: [0.1, -0.02, 0.003, -0.0004]\n  "
      "distortion_model: equidistant\n  intrinsics: [661.5, 662.25, 318.75, 241]\n  resolution: [640, 480]\n  "
      "rostopic: "
      "/cam0\n";
  check_camera(load(chain), 640, 480);
  CHECK(load(chain).lens == LensModel::fisheye);
  std::string radtan = chain;
  radtan.replace(radtan.find("equidistant"), 11, "radtan");
  CHECK(load(radtan).lens == LensModel::polynomial);
  CHECK(load(radtan).distortion == four);
  std::string second = chain;
  second.replace(0, 4, "cam1");
  CHECK_ERROR(load(chain + second), ErrorCode::camera, "several cameras");

  const Camera camera = load("fisheye: 1\n" + rest);
  for (const char* name : {"f.yml", "f.json", "f.xml"}) {
    io::save_camera(folder / name, camera);
    CHECK(io::load_camera(folder / name).lens == LensModel::fisheye);
    CHECK(io::load_camera(folder / name).distortion == camera.distortion);
  }
}

TEST_CASE("Cameras: coefficients of distortion by their names, and under names that are not known") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_camera(folder.write("c.yaml", text)); };
  const std::string rest = "fx: 661.5\nfy: 662.25\ncx: 318.75\ncy: 241\nwidth: 640\nheight: 480\n";
  const std::string five = "k1: -0.25\nk2: 0.125\np1: 0.001\np2: -0.002\nk3: 0.03\n";
  check_camera(load(rest + five), 640, 480);
  CHECK(load(rest + five).distortion == kFive);
  CHECK(load(rest + "distortion: {k3: 0.03, p1: 0.001, p2: -0.002, k1: -0.25, k2: 0.125}\n").distortion == kFive);
  CHECK(load(rest + "coeffs: [-0.25, 0.125, 0.001, -0.002, 0.03]\n").distortion == kFive);
  const Camera fisheye = load(rest + "fisheye: 1\nk1: 0.1\nk2: 0.2\nk3: 0.3\nk4: 0.4\n");
  CHECK(fisheye.distortion == std::array<double, 8>{0.1, 0.2, 0.3, 0.4, 0, 0, 0, 0});
  for (const char* name : {"distortion_coefs", "dist_coefs", "distortion_parameters", "lens_distortion"}) {
    CAPTURE(name);
    CHECK_ERROR(load(rest + name + ": [0.1, 0.2]\n"), ErrorCode::camera, name, "distortion_coefficients");
    CHECK_ERROR(load(rest + name + ": {k1: 0.1}\n"), ErrorCode::camera, name);
    CHECK_FALSE(load(rest + name + ": [0, 0]\n").has_distortion());
  }
  CHECK_FALSE(load(rest + "distortion_model: plumb_bob\ndistance: far\n").has_distortion());
  // MATLAB's
  CHECK(load(rest + "radial: [-0.25, 0.125, 0.03]\ntangential: [0.001, -0.002]\n").distortion == kFive);
  CHECK(load(rest + "RadialDistortion: [-0.25, 0.125, 0.03]\nTangentialDistortion: [0.001, -0.002]\n").distortion ==
        kFive);
  CHECK(load(rest + "distortion: {radial: [-0.25, 0.125, 0.03], tangential: [[0.001], [-0.002]]}\n").distortion ==
        kFive);
  CHECK(load(rest + "radial: [0.1, 0.2]\n").distortion == std::array<double, 8>{0.1, 0.2, 0, 0, 0, 0, 0, 0});
  CHECK_ERROR(load(rest + "radial: [0.1]\n"), ErrorCode::camera, "1 radial", "k1 k2 [k3]");
  CHECK_ERROR(load(rest + "fisheye: 1\nradial: [0.1, 0.2]\n"), ErrorCode::camera, "fisheye", "k1 k2 k3 k4");
  CHECK_ERROR(load(rest + "D: [0.1, 0, 0, 0]\nradial: [0.1, 0.2]\n"), ErrorCode::camera, "'radial'");
  CHECK_ERROR(load(rest + "radial_coefficients: [0.1, 0.2]\n"), ErrorCode::camera, "'radial_coefficients'");
}

TEST_CASE("Cameras: the sizes of other dialects, ROS's region and binning") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_camera(folder.write("c.yaml", text)); };
  const std::string matrix = "camera_matrix: [661.5, 0, 318.75, 0, 662.25, 241, 0, 0, 1]\n";
  for (const char* size : {"imageSize_width: 640\nimageSize_height: 480\n", "image_size: {width: 640, height: 480}\n",
                           "resolution: [640, 480]\n", "img_width: 640\nimg_height: 480\n", "w: 640.0\nh: 480\n"}) {
    CAPTURE(size);
    check_camera(load(size + matrix), 640, 480);
  }
  // MATLAB names rows first, beside its own name of the distortion.
  check_camera(load("ImageSize: [480, 640]\nRadialDistortion: [-0.25, 0.125, 0.03]\n"
                    "TangentialDistortion: [0.001, -0.002]\nK: [661.5, 0, 318.75, 0, 662.25, 241, 0, 0, 1]\n"),
               640, 480);
  const Camera exchanged = load("image_size: [480, 640]\n" + matrix);
  CHECK(exchanged.width == 480);
  CHECK_ERROR(io::camera_for_frames(exchanged, 640, 480, true), ErrorCode::camera, "width and height exchanged");
  check_camera(load("w: 640\nh: 480\nfl_x: 661.5\nfl_y: 662.25\ncx: 318.75\ncy: 241\n"), 640, 480);  // NeRF's
  check_camera(load("width: 640\nheight: 480\nfx: 661.5\nfy: 662.25\nppx: 318.75\nppy: 241\n"), 640, 480);
  const std::string ros = "image_width: 640\nimage_height: 480\n" + matrix;
  check_camera(load(ros + "binning_x: 0\nbinning_y: 1\nroi: {x_offset: 0, y_offset: 0, width: 0, height: 0}\n"), 640,
               480);
  // What a pixel of the whole picture shows, a binned one of the cut picture shows at the place that is left of it.
  const Camera camera =
      load(ros + "binning_x: 2\nbinning_y: 4\nroi: {x_offset: 100, y_offset: 40, width: 400, height: 320}\n");
  CHECK(camera.width == 200);
  CHECK(camera.height == 80);
  const Camera whole = load(ros);
  const Eigen::Vector3d point(0.03, -0.02, 0.6);
  const Eigen::Vector2d before = whole.project(point), after = camera.project(point);
  CHECK(after.x() == doctest::Approx((before.x() + 0.5 - 100) / 2 - 0.5));
  CHECK(after.y() == doctest::Approx((before.y() + 0.5 - 40) / 4 - 0.5));
}

TEST_CASE("A focal length that no lens has for the frames is told") {
  const auto warning = [](double fx, double fy, int width = 640, int height = 480) {
    return io::camera_warning({width, height, fx, fy, 0.5 * (width - 1), 0.5 * (height - 1), {}}).value_or("");
  };
  CHECK(warning(4.5, 4.5).find("4.5 pixels, far too short for frames of 640x480: is it in millimetres") !=
        std::string::npos);
  CHECK(warning(0.9375, 1.27).find("shares of the frame") != std::string::npos);
  CHECK(warning(65, 47).find("too short") != std::string::npos);
  CHECK(warning(4500, 1e5).find("1e+05 pixels, far too long") != std::string::npos);
  CHECK(warning(65, 65).empty());               // 157 degrees wide
  CHECK(warning(12000, 12000).empty());         // 3 degrees
  CHECK(warning(7000, 7000, 40, 480).empty());  // a strip of a long lens's frame
  CHECK(warning(4.5, 4.5, 0, 0).empty());
}

TEST_CASE("A principal point far from the middle is told, and frames that are turned") {
  const auto warning = [](double cx, double cy) {
    return io::camera_warning({640, 480, 600, 600, cx, cy, {}}).value_or("");
  };
  CHECK(warning(319.5, 239.5).empty());
  CHECK(warning(350, 210).empty());
  for (const auto& [cx, cy] : {std::pair{640.0, 480.0}, {0.0, 0.0}, {160.0, 240.0}, {320.0, 400.0}}) {
    CAPTURE(cx);
    CHECK(warning(cx, cy).find("principal point") != std::string::npos);
  }
  CHECK_FALSE(io::camera_warning({0, 0, 600, 600, 1e3, 1e3, {}}));
  const Camera calibrated{640, 480, 600, 600, 319.5, 239.5, {}};
  CHECK_ERROR(io::camera_for_frames(calibrated, 480, 640, false), ErrorCode::camera, "480x640", "640x480", "turned");
  CHECK_ERROR(io::camera_for_frames(calibrated, 1080, 1440, true), ErrorCode::camera, "turned");
}

TEST_CASE("Cameras that cannot be used: one line that names the file and the fault") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_camera(folder.write("bad.yml", text)); };
  CHECK_ERROR(io::load_camera(folder / "none.yml"), ErrorCode::file, "camera file", "none.yml", "does not exist");
  CHECK_ERROR(io::load_camera(folder.path()), ErrorCode::file, "is a folder");
  CHECK_ERROR(load(""), ErrorCode::camera, "bad.yml", "0 numbers");
  CHECK_ERROR(load("1 2 3"), ErrorCode::camera, "3 numbers", "fx fy cx cy");
  CHECK_ERROR(load("nothing to see"), ErrorCode::camera, "bad.yml", "expected");
  CHECK_ERROR(load("a: [1, 2"), ErrorCode::camera, "no valid YAML");
  CHECK_ERROR(load("{\"a\": "), ErrorCode::camera, "no valid JSON");
  CHECK_ERROR(load("<?xml version=\"1.0\"?>\n<opencv_storage>\n<a>"), ErrorCode::camera, "no valid OpenCV XML");
  CHECK_ERROR(load("image_width: 640\nimage_height: 480\n"), ErrorCode::camera, "neither a camera_matrix nor fx");
  CHECK_ERROR(load("camera_matrix: [1, 2, 3]"), ErrorCode::camera, "3 numbers, not 9");
  CHECK_ERROR(load("camera_matrix: [600, 0, 0, 0, 600, 0, 320, 240, 1]"), ErrorCode::camera, "transposed");
  CHECK_ERROR(load("camera_matrix: [600, 5, 320, 0, 600, 240, 0, 0, 1]"), ErrorCode::camera, "skew");
  CHECK_ERROR(load("camera_matrix: [-600, 0, 320, 0, 600, 240, 0, 0, 1]"), ErrorCode::camera, "bad.yml");
  CHECK_ERROR(load("600 600 nan 240"), ErrorCode::camera, "bad.yml");
  CHECK_ERROR(load("fx: 1\nfy: 1\ncx: 1\ncy: 1\nimage_width: 640.5\nimage_height: 480"), ErrorCode::camera, "640.5",
              "pixels");
  CHECK_ERROR(load("camera_model: omni\nfx: 1\nfy: 1\ncx: 1\ncy: 1"), ErrorCode::camera, "camera model 'omni'",
              "not supported");
  CHECK_ERROR(load("camera_model: ds\nintrinsics: [-0.2, 0.6, 600, 600, 320, 240]"), ErrorCode::camera, "'ds'",
              "not supported");
  const std::string one = "fx: 1\nfy: 1\ncx: 1\ncy: 1\n";
  for (const char* other : {"type: omnidirectional", "projection: equirectangular", "projection_type: spherical",
                            "model: distortion.ftheta", "lens: cylindrical", "model: DS"}) {
    CAPTURE(other);
    CHECK_ERROR(load(one + other), ErrorCode::camera, "camera model '", "not supported");
  }
  CHECK_ERROR(load(one + "xi: 0.9"), ErrorCode::camera, "'xi' is 0.9", "not supported");
  for (const char* usual : {"type: OmniVision OV9281", "model: D435", "projection: frame", "type: perspective",
                            "lens: 8 mm", "xi: 0", "projection: rectilinear", "distortion_type: radial",
                            "tangential: true", "radial:", "NumRadialDistortionCoefficients: 2"}) {
    CAPTURE(usual);
    CHECK(load(one + usual).lens == LensModel::polynomial);
  }
  CHECK(load(one + "model: distortion.kannala_brandt4").lens == LensModel::fisheye);
  CHECK_ERROR(load("model: inverse_brown_conrady\nfx: 1\nfy: 1\ncx: 1\ncy: 1"), ErrorCode::camera, "inverse");
  CHECK_ERROR(load("fx: 1\nfy: 1\ncx: 1\ncy: 1\nwidth: 640\nheight: 480\nroi: {x_offset: 600, y_offset: 0, width: 320, "
                   "height: 240}"),
              ErrorCode::camera, "'roi'", "640x480");
  CHECK_ERROR(load("fisheye_model: 1\nfx: 1\nfy: 1\ncx: 1\ncy: 1\ndist: [0.1, 0, 0, 0, 0]"), ErrorCode::camera,
              "5 distortion coefficients", "k1 k2 k3 k4");
  CHECK_ERROR(load("fx: 1\nfy: 1\ncx: 1\ncy: 1\ndist: [0,0,0,0,0,0,0,0,0.5,0,0,0]"), ErrorCode::camera, "thin prism");
  CHECK(load("fx: 1\nfy: 1\ncx: 1\ncy: 1\ndist: [1,0,0,0,0,0,0,0,0,0,0,0]").distortion[0] == 1);
}

TEST_CASE("save_camera writes what load_camera and OpenCV read back") {
  const TemporaryFolder folder;
  const Camera camera{640, 480, 660.123456789012, 661, 320.1, 240.2, {-0.1, 0.02, 1e-5, 2e-6, 0.3, 0.4, 0.5, 0.6}};
  for (const char* name : {"c.yml", "c.yaml", "c.json", "c.xml"}) {
    CAPTURE(name);
    io::save_camera(folder / name, camera);
    const Camera read = io::load_camera(folder / name);
    CHECK(read.width == 640);
    CHECK(read.height == 480);
    CHECK(read.fx == camera.fx);
    CHECK(read.cy == camera.cy);
    CHECK(read.distortion == camera.distortion);
    const cv::FileStorage storage((folder / name).string(), cv::FileStorage::READ);
    cv::Mat matrix;
    storage["camera_matrix"] >> matrix;
    REQUIRE(matrix.rows == 3);
    CHECK(matrix.at<double>(1, 1) == 661);
  }
  CHECK_ERROR(io::save_camera(folder / "c.txt", camera), ErrorCode::invalid_argument, "c.txt", ".yml");
  CHECK_ERROR(io::save_camera(folder / "no/such/c.yml", camera), ErrorCode::output, "cannot be written");
  Camera unknown = camera;
  unknown.cx = std::nan("");
  CHECK_ERROR(io::save_camera(folder / "unknown.yml", unknown), ErrorCode::camera, "unknown.yml", "NaN");
  Pose nowhere = Pose::Identity();
  nowhere.translation().x() = std::nan("");
  CHECK_ERROR(io::save_pose(folder / "nowhere.txt", nowhere), ErrorCode::pose, "nowhere.txt", "NaN");
}

TEST_CASE("The camera for frames of a size") {
  const Camera text{0, 0, 600, 600, 319.5, 239.5, {}};
  CHECK(io::camera_for_frames(text, 640, 480, false).width == 640);
  const Camera calibrated{640, 480, 600, 600, 319.5, 239.5, {}};
  CHECK(io::camera_for_frames(calibrated, 640, 480, false).fx == 600);
  CHECK_ERROR(io::camera_for_frames(calibrated, 1280, 960, false), ErrorCode::camera, "1280x960", "640x480",
              "rescale it if");
  const Camera rescaled = io::camera_for_frames(calibrated, 1280, 960, true);
  CHECK(rescaled.fx == doctest::Approx(1200));
  CHECK(rescaled.cx == doctest::Approx(639.5));  // the centre stays the centre: pixel centres are integers
  CHECK(io::camera_for_frames(calibrated, 427, 320, true).fx == doctest::Approx(600 * 427 / 640.0));
  for (const bool rescale : {false, true}) {
    CHECK_ERROR(io::camera_for_frames(calibrated, 1280, 720, rescale), ErrorCode::camera, "1280x720", "640x480",
                "cropped");
  }
  for (const Camera& camera : {text, calibrated}) {
    CHECK_ERROR(io::camera_for_frames(camera, 0, 0), ErrorCode::camera, "no pixels (0x0)", "was the video opened?");
  }
}

TEST_CASE("Poses: matrices in any line layout and TUM") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_pose(folder.write("p.txt", text)); };
  Pose expected = Pose::Identity();
  expected.linear() = Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  expected.translation() << 0.1, -0.2, 0.7;
  for (const char* text :
       {"0 -1 0 0.1 1 0 0 -0.2 0 0 1 0.7\n", "0 -1 0 0.1\n1 0 0 -0.2\n0 0 1 0.7\n",
        "# first pose\n0 -1 0 0.1\n1 0 0 -0.2\n0 0 1 0.7\n0 0 0 1\n", "0 -1 0 0.1 1 0 0 -0.2 0 0 1 0.7 0 0 0 1",
        "[[0, -1, 0, 0.1],\n [1, 0, 0, -0.2],\n [0, 0, 1, 0.7]]", "0\n-1\n0\n0.1\n1\n0\n0\n-0.2\n0\n0\n1\n0.7\n",
        "0 -1 0 0.1 1 0\r\n0 -0.2 0 0 1 0.7\r\n",
        "12.5 0.1 -0.2 0.7 0 0 0.70710678 0.70710678 # TUM\n12.6 0 0 1 0 0 0 1\n",
        "0 -1 0 0.1 1 0 0 -0.2 0 0 1 0.7\n1 0 0 0 0 1 0 0 0 0 1 9\n",
        "0 -1 0 0.1\n1 0 0 -0.2\n0 0 1 0.7\n0 0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 9\n0 0 0 1\n",
        "0 -1 0 0.1\n1 0 0 -0.2\n0 0 1 0.7\n1 0 0 0\n0 1 0 0\n0 0 1 9\n"}) {
    CAPTURE(text);
    CHECK((load(text).matrix() - expected.matrix()).norm() < 1e-7);
  }
  const std::vector<Pose> poses = io::load_poses(folder.write(
      "all.txt", "# three\n1 0 0 0 0 1 0 0 0 0 1 5\n\n3 0 0 6 0 0 0 1\n1 0 0 0 0 1 0 0 0 0 1 7 0 0 0 1\n"));
  REQUIRE(poses.size() == 3);
  CHECK(poses[0].translation().z() == 5);
  CHECK(poses[1].translation().z() == 6);
  CHECK(poses[2].translation().z() == 7);

  io::save_pose(folder / "saved.txt", expected);
  CHECK(io::load_pose(folder / "saved.txt").isApprox(expected, 1e-15));
  CHECK_ERROR(io::save_pose(folder / "no/such/p.txt", expected), ErrorCode::output, "cannot be written");
}

TEST_CASE("Poses of six numbers: OpenCV's rvec and tvec, ViSP's the other way round") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_pose(folder.write("p.txt", text)); };
  Pose expected = Pose::Identity();
  expected.linear() = Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  expected.translation() << 0.1, -0.2, 0.7;
  for (const char* text : {"0 0 1.5707963267949 0.1 -0.2 0.7\n", "[0, 0, 1.5707963267949]\n[0.1, -0.2, 0.7]\n",
                           "0.1\n-0.2\n0.7\n0\n0\n1.5707963267949\n",  // vpPoseVector, a number a line
                           "0 0 1.5707963267949 0.1 -0.2 0.7\n0 0 0 0 0 1\n0 0 0 0 0 2\n",
                           "rvec: [0, 0, 1.5707963267949]\ntvec: [1e-1, -0.2, 0.7]\n",
                           R"({"tvec": [[0.1], [-0.2], [0.7]], "rvec": [[0], [0], [1.5707963267949]]})"}) {
    CAPTURE(text);
    CHECK((load(text).matrix() - expected.matrix()).norm() < 1e-9);
  }
  CHECK(load("0 0 0 0.1 0.2 0.3").linear().isIdentity());
  CHECK_ERROR(load("rvec: 0 0 1\ntvec: [0.1, -0.2, 0.7]\n"), ErrorCode::pose, "p.txt", "'rvec:' is not a number");
  const std::string both = "rvec: [0, 0, 1]\ntvec: [0.1, -0.2, 0.7]\n";
  CHECK_ERROR(load(both + both), ErrorCode::pose, "p.txt", "'rvec:' is not a number");
  CHECK_ERROR(load("rvec: [0, 0]\ntvec: [0.1, -0.2, 0.7]\n"), ErrorCode::pose, "p.txt", "'rvec:' is not a number");
  CHECK_ERROR(load("0 0 90 0.1 -0.2 0.7"), ErrorCode::pose, "p.txt", "rotation vector", "degrees");
  const std::vector<Pose> poses = io::load_poses(folder.write("all.txt", "0 0 0 0 0 1\n0 0 0 0 0 2\n"));
  REQUIRE(poses.size() == 2);
  CHECK(poses[1].translation().z() == 2);
}

TEST_CASE("Rotations of few digits become rotations") {
  const TemporaryFolder folder;
  const Pose pose = io::load_pose(folder.write("p.txt", "0.866 -0.5 0 0\n0.5 0.866 0 0\n0 0 1 1\n"));
  CHECK((pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-14);
}

TEST_CASE("Poses that cannot be used: one line that names file, line and fault") {
  const TemporaryFolder folder;
  const auto load = [&folder](const std::string& text) { return io::load_pose(folder.write("p.txt", text)); };
  CHECK_ERROR(io::load_pose(folder / "none.txt"), ErrorCode::file, "pose file", "none.txt", "does not exist");
  CHECK_ERROR(load(""), ErrorCode::pose, "p.txt", "no numbers");
  CHECK_ERROR(load("# only words\n"), ErrorCode::pose, "no numbers");
  CHECK_ERROR(load("1 0 0 0\n0 1 zero 0\n"), ErrorCode::pose, "line 2", "'zero'", "not a number");
  CHECK_ERROR(load("1 2 3"), ErrorCode::pose, "line 1", "3 numbers");
  CHECK_ERROR(load("2 0 0 0 0 2 0 0 0 0 2 1"), ErrorCode::pose, "line 1", "rotation");
  CHECK_ERROR(load("-1 0 0 0 0 1 0 0 0 0 1 1"), ErrorCode::pose, "line 1", "reflection");
  CHECK_ERROR(load("1 0 0 nan 0 1 0 0 0 0 1 1"), ErrorCode::pose, "line 1");
  CHECK_ERROR(load("1 0 0 0 0 1 0 0 0 0 1 0 0 0 5 1"), ErrorCode::pose, "fourth row", "transposed");
  CHECK_ERROR(load("0 0 0 1 0 0 0 2"), ErrorCode::pose, "quaternion");
  CHECK_ERROR(io::load_poses(folder.write("p.txt", "1 0 0 0 0 1 0 0 0 0 1 5\n1 2 3\n")), ErrorCode::pose, "line 2",
              "3 numbers");
}

TEST_CASE("What is no text is said not to be") {
  const TemporaryFolder folder;
  const std::string video("\0\0\0 ftypisom", 12);
  CHECK_ERROR(io::load_camera(folder.write("c.txt", video)), ErrorCode::file, "c.txt", "not a text file");
  CHECK_ERROR(io::load_pose(folder.write("p.txt", video)), ErrorCode::file, "p.txt", "not a text file");
}

TEST_CASE("Text in UTF-16 is said to be that") {
  const TemporaryFolder folder;
  const std::string text(
      "\xff\xfe"
      "6\0"
      "0\0",
      6);
  CHECK_ERROR(io::load_camera(folder.write("c.txt", text)), ErrorCode::file, "c.txt", "UTF-16");
  CHECK_ERROR(io::load_pose(folder.write("p.txt", text)), ErrorCode::file, "p.txt", "UTF-16");
  CHECK_ERROR(io::load_model(folder.write("m.obj", text)), ErrorCode::file, "m.obj", "UTF-16");
}

TEST_CASE("A file that cannot be read though it exists says why") {
  CHECK_ERROR(io::load_camera("/proc/self/mem"), ErrorCode::file, "/proc/self/mem", "cannot be read", "permissions");
}
