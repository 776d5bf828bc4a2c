#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "base/turns.hpp"
#include "detection/feature_data.hpp"
#include "holdfast/error.hpp"
#include "holdfast/renderer.hpp"

namespace holdfast::detection {
namespace {

/// Pixels of a view, and of the model's sphere in it.
constexpr int kViewSide = 448;
constexpr double kSphere = 420;
/// Radii from which views are drawn: nearer than usual, perspective hides a part of the sides.
constexpr double kDistance = 5;
constexpr int kMostOfView = 700;
constexpr std::size_t kFewest = 20;
/// Features of low contrast are wanted too: frames are blurred and darker than textures.
constexpr double kContrast = 0.015;

/// Directions well spread over the sphere: an icosahedron's vertices and the middles of its edges, 32 to 36 degrees
/// apart, which is what SIFT bears.
std::vector<Eigen::Vector3d> directions() {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::Vector3d> vertices;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-golden, golden}) {
      vertices.insert(vertices.end(), {{0, a, b}, {a, b, 0}, {b, 0, a}});
    }
  }
  std::vector<Eigen::Vector3d> all = vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if ((vertices[i] - vertices[j]).norm() < 2.1) all.push_back(vertices[i] + vertices[j]);
    }
  }
  for (Eigen::Vector3d& direction : all) direction.normalize();
  return all;
}

class ViewReader {
 public:
  ViewReader(const Mesh& mesh)
      : p_center_(mesh.center()),
        radius_(mesh.radius()),
        renderer_(mesh, kViewSide, kViewSide),
        rgba_(kViewSide, kViewSide, CV_8UC4),
        depth_(kViewSide, kViewSide, CV_32F) {
    const double focal = 0.5 * kSphere * kDistance;
    const double middle = 0.5 * (kViewSide - 1);
    camera_ = {kViewSide, kViewSide, focal, focal, middle, middle, {}};
  }

  void read(const Eigen::Vector3d& direction, ModelFeatures::Data& data) {
    const Pose T = anchored(Eigen::Quaterniond::FromTwoVectors(direction, -Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                            p_center_, {0, 0, kDistance * radius_});
    const DepthRange range =
        renderer_.render(T, camera_, {0, 0, kViewSide, kViewSide}, {rgba_.data, depth_.ptr<float>(), kViewSide});
    cv::Mat alpha, grey, known, inside;
    cv::extractChannel(rgba_, alpha, 3);
    known = alpha == 255;
    if (cv::countNonZero(known) == 0) return;
    cv::cvtColor(rgba_, grey, cv::COLOR_RGBA2GRAY);
    grey.setTo(cv::mean(grey, known), ~known);  // no edges but the texture's own
    cv::distanceTransform(known, inside, cv::DIST_L2, 3);
    PictureFeatures found = features_of(grey, kMostOfView);
    const Pose T_object_camera = T.inverse();
    for (std::size_t i = 0; i < found.places.size(); ++i) {
      const cv::KeyPoint& place = found.places[i];
      const cv::Point pixel(cvRound(place.pt.x), cvRound(place.pt.y));
      if (inside.at<float>(pixel) < std::max(2.0f, 0.5f * place.size)) continue;  // the silhouette is a part of it
      const double z = range.metric(static_cast<double>(depth_.at<float>(pixel)));
      data.add(found.descriptors.row(static_cast<int>(i)), place.pt, z, camera_, T_object_camera);
    }
  }

 private:
  Eigen::Vector3d p_center_;
  double radius_;
  Renderer renderer_;
  Camera camera_;
  cv::Mat rgba_, depth_;
};

std::shared_ptr<const ModelFeatures::Data> read_model(const Mesh& mesh) {
  mesh.validate();
  if (!mesh.has_appearance()) {
    throw Error(ErrorCode::model,
                "the model has neither texture nor vertex colours to recognize it by: give a first pose or a guide, or "
                "a texture ('holdfast bake' makes one from a video)");
  }
  const auto data = std::make_shared<ModelFeatures::Data>(ModelFeatures::Data{model_hash(mesh), mesh.radius(), {}, {}});
  ViewReader views(mesh);
  for (const Eigen::Vector3d& direction : directions()) views.read(direction, *data);
  if (data->p_object.size() < kFewest) {
    throw Error(ErrorCode::model, "the model's texture has next to no features to recognize it by (" +
                                      std::to_string(data->p_object.size()) + "): give a first pose or a guide");
  }
  return data;
}

}  // namespace

PictureFeatures features_of(const cv::Mat& grey, int most) {
  // Three layers an octave, edges and scale: SIFT's own defaults.
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(most, 3, kContrast, 10, 1.6, CV_8U);
  PictureFeatures found;
  sift->detectAndCompute(grey, cv::noArray(), found.places, found.descriptors);
  return found;
}

cv::Mat comparable(const cv::Mat& descriptors) {
  cv::Mat result;
  descriptors.convertTo(result, CV_32F);
  for (int row = 0; row < result.rows; ++row) {
    cv::Mat values = result.row(row);
    values /= std::max(1.0, cv::norm(values, cv::NORM_L1));
  }
  cv::sqrt(result, result);
  return result;
}

ModelFeatures::ModelFeatures(const Mesh& mesh) : data_(read_model(mesh)) {}

ModelFeatures ModelFeatures::none(const Mesh& mesh) {
  mesh.validate();
  return ModelFeatures(std::make_shared<const Data>(Data{model_hash(mesh), mesh.radius(), {}, {}}));
}

ModelFeatures ModelFeatures::with(const ModelFeatures& other) const {
  if (other.data().hash != data_->hash) throw Error(ErrorCode::invalid_argument, "features of two different models");
  const auto both = std::make_shared<Data>(*data_);
  both->p_object.insert(both->p_object.end(), other.data().p_object.begin(), other.data().p_object.end());
  both->descriptors = data_->descriptors.clone();  // a matrix is shared by its copies
  both->descriptors.push_back(other.data().descriptors);
  return ModelFeatures(both);
}

std::size_t ModelFeatures::count() const { return data_->p_object.size(); }

}  // namespace holdfast::detection
