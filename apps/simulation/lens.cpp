#include "simulation/lens.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "holdfast/error.hpp"

namespace holdfast::simulation {
namespace {

// The ideal pixel that distortion moves to `pixel`, by Newton's method from `guess`.
Eigen::Vector2d undistort(const Camera& camera, const Eigen::Vector2d& pixel, Eigen::Vector2d guess) {
  constexpr double step = 1e-3;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d here = camera.distort(guess);
    const Eigen::Vector2d miss = pixel - here;
    if (miss.norm() < 1e-6) return guess;
    Eigen::Matrix2d slope;
    slope.col(0) = (camera.distort(guess + Eigen::Vector2d(step, 0)) - here) / step;
    slope.col(1) = (camera.distort(guess + Eigen::Vector2d(0, step)) - here) / step;
    if (!(slope.determinant() > 1e-3)) break;  // the picture folds over
    guess += slope.inverse() * miss;
  }
  throw Error(ErrorCode::camera, "camera: the lens distortion cannot be inverted at pixel (" +
                                     std::to_string(std::lround(pixel.x())) + ", " +
                                     std::to_string(std::lround(pixel.y())) + "); check its coefficients");
}

}  // namespace

Lens::Lens(const Camera& camera) : camera_(camera), ideal_(camera) {
  if (!camera.has_distortion()) return;
  ideal_.distortion.fill(0);
  ideal_.lens = LensModel::polynomial;
  ideal_pixel_.create(camera.height + 2, camera.width + 2, CV_32FC2);
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::max());
  Eigen::Array2d high = -low;
  const auto fill = [&](int x, int y, const Eigen::Vector2d& guess) {
    const Eigen::Vector2d ideal = undistort(camera, {x, y}, guess);
    ideal_pixel_.at<cv::Vec2f>(y + 1, x + 1) = {static_cast<float>(ideal.x()), static_cast<float>(ideal.y())};
    low = low.min(ideal.array());
    high = high.max(ideal.array());
    return ideal;
  };
  // From the middle outwards: distortion is small there, and each solution is the next one's first guess.
  const int middle_x = std::clamp(static_cast<int>(camera.cx), 0, camera.width - 1);
  const int middle_y = std::clamp(static_cast<int>(camera.cy), 0, camera.height - 1);
  const auto fill_row = [&](int y, const Eigen::Vector2d& guess) {
    const Eigen::Vector2d first = fill(middle_x, y, guess);
    Eigen::Vector2d last = first;
    for (int x = middle_x + 1; x <= camera.width; ++x) last = fill(x, y, last);
    last = first;
    for (int x = middle_x - 1; x >= -1; --x) last = fill(x, y, last);
    return first;
  };
  const Eigen::Vector2d middle = fill_row(middle_y, {middle_x, middle_y});
  Eigen::Vector2d last = middle;
  for (int y = middle_y + 1; y <= camera.height; ++y) last = fill_row(y, last);
  last = middle;
  for (int y = middle_y - 1; y >= -1; --y) last = fill_row(y, last);

  const Eigen::Array2d first = low.floor() - 2;
  const Eigen::Array2d size = high.ceil() + 3 - first;
  if (size.x() > 8.0 * camera.width || size.y() > 8.0 * camera.height) {
    throw Error(ErrorCode::camera,
                "camera: the lens distortion gathers more than eight times the frame; check its coefficients");
  }
  ideal_.width = static_cast<int>(size.x());
  ideal_.height = static_cast<int>(size.y());
  ideal_.cx -= first.x();
  ideal_.cy -= first.y();
  ideal_pixel_ -= cv::Scalar(first.x(), first.y());
}

// Values at the samples of the ideal picture's region, averaged to the pixels of the frame.
cv::Mat Lens::bend(const cv::Mat& ideal, const cv::Rect& region, int samples) const {
  cv::Mat at;
  cv::resize(ideal_pixel_, at, ideal_pixel_.size() * samples, 0, 0, cv::INTER_LINEAR);
  at = at(cv::Rect(samples, samples, camera_.width * samples, camera_.height * samples));
  cv::Mat sample_at;
  const double offset = 0.5 * samples - 0.5;  // of sample coordinates: pixel centres are integers in both
  at.convertTo(sample_at, CV_32F, samples);
  sample_at += cv::Scalar(offset - region.x, offset - region.y);
  cv::Mat bent, result;
  cv::remap(ideal, bent, sample_at, {}, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  cv::resize(bent, result, cv::Size(camera_.width, camera_.height), 0, 0, cv::INTER_AREA);
  return result;
}

Layer Lens::draw(const Scene& scene, int samples, bool shade) const {
  if (ideal_pixel_.empty()) return simulation::draw(scene, camera_, samples, shade);
  Camera fine = ideal_;
  fine.width *= samples;
  fine.height *= samples;
  fine.fx *= samples;
  fine.fy *= samples;
  fine.cx = (fine.cx + 0.5) * samples - 0.5;
  fine.cy = (fine.cy + 0.5) * samples - 0.5;
  const Layer ideal = simulation::draw(scene, fine, 1, shade);
  Layer layer;
  if (ideal.region.empty()) return layer;
  layer.region = cv::Rect(0, 0, camera_.width, camera_.height);
  if (shade) layer.light = bend(ideal.light, ideal.region, samples);
  layer.object_share = bend(ideal.object_share, ideal.region, samples);
  layer.other_share = bend(ideal.other_share, ideal.region, samples);
  const auto samples_in = [&](const cv::Mat& share) { return std::llround(cv::sum(share)[0] * samples * samples); };
  layer.visible_samples = samples_in(layer.object_share);
  layer.object_samples = layer.visible_samples;
  if (!scene.occluders.empty()) {
    Scene alone = scene;
    alone.occluders.clear();
    const Layer silhouette = simulation::draw(alone, fine, 1, false);
    layer.object_samples =
        silhouette.region.empty() ? 0 : samples_in(bend(silhouette.object_share, silhouette.region, samples));
  }
  return layer;
}

}  // namespace holdfast::simulation
