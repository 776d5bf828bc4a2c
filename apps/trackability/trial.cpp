#include "trackability/trial.hpp"

#include <algorithm>
#include <chrono>
#include <future>
#include <numbers>
#include <thread>

#include "evaluation/pose_error.hpp"
#include "evaluation/statistics.hpp"

namespace holdfast::trackability {
namespace {

constexpr double kGoodShareOfDiameter = 0.05;
constexpr double kGoodRotation = 5 * std::numbers::pi / 180;

double diameter_of(const Mesh& mesh) {
  const auto corners = simulation::bounding_corners(mesh);
  return (corners.back() - corners.front()).norm();
}

}  // namespace

TrialResult summarize_trial(std::span<const evaluation::FrameRecord> records, std::span<const double> pixels,
                            double diameter) {
  const evaluation::Tolerance good{kGoodShareOfDiameter * diameter, kGoodRotation};
  TrialResult out;
  std::vector<double> distance, depth, rotation, textured, ms;
  for (const evaluation::FrameRecord& record : records) {
    const FrameResult& result = record.result;
    ++out.frames;
    out.by_contour += !result.texture.holds && result.contour.holds;
    if (result.texture.usable_pixels > 0) {
      textured.push_back(static_cast<double>(result.texture.gradient_pixels) / result.texture.usable_pixels);
    }
    ms.push_back(result.ms.total);
    if (result.status == Status::lost) {
      ++out.lost;
    } else if (!good.holds(record.error)) {
      ++out.wrong;
    } else {
      ++out.good;
      distance.push_back(record.error.distance());
      depth.push_back(record.error.depth());
      rotation.push_back(record.error.rotation);
    }
  }
  const auto median = [](std::span<const double> values) {
    return values.empty() ? 0 : evaluation::quantile({values.begin(), values.end()}, 0.5);
  };
  const auto largest = [](const std::vector<double>& values) {
    return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
  };
  out.median_distance = median(distance);
  out.worst_distance = largest(distance);
  out.worst_depth = largest(depth);
  out.median_rotation = median(rotation);
  out.worst_rotation = largest(rotation);
  out.median_pixels = median(pixels);
  out.least_pixels = pixels.empty() ? 0 : *std::min_element(pixels.begin(), pixels.end());
  out.textured_share = median(textured);
  out.median_ms = median(ms);
  return out;
}

Trial::Trial(const Mesh& mesh, const Camera& camera, const Device& device)
    : tracker_(mesh, camera, {}, device), diameter_(diameter_of(mesh)) {}

void Trial::add(const simulation::SimulatedFrame& frame) {
  evaluation::FrameRecord record;
  record.frame = static_cast<int>(records_.size());
  record.visible = frame.visible_share;
  record.T_camera_object_true = frame.T_camera_object;
  if (records_.empty()) {
    tracker_.reset(frame.T_camera_object);
  }
  const cv::Mat& image = frame.image;
  const auto before = std::chrono::steady_clock::now();
  record.result = tracker_.track({image.data, image.cols, image.rows, image.step[0], PixelFormat::bgr8});
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - before;
  record.result.ms.total = took.count();
  record.error = evaluation::pose_error(frame.T_camera_object, record.result.T_camera_object);
  records_.push_back(record);
  pixels_.push_back(cv::countNonZero(frame.object_mask >= 128));
}

TrialResult Trial::result() const { return summarize_trial(records_, pixels_, diameter_); }

TrialResult run_trial(const simulation::Sequence& sequence, const Mesh& mesh, const Device& device, int threads) {
  Trial trial(mesh, sequence.camera(), device);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int batch = threads > 0 ? threads : cores;
  for (int first = 0; first < sequence.size(); first += batch) {
    std::vector<std::future<simulation::SimulatedFrame>> drawn;
    for (int i = first; i < std::min(first + batch, sequence.size()); ++i) {
      drawn.push_back(std::async(batch > 1 ? std::launch::async : std::launch::deferred,
                                 [&sequence, i] { return sequence.make(i); }));
    }
    for (auto& frame : drawn) {
      trial.add(frame.get());
    }
  }
  return trial.result();
}

}  // namespace holdfast::trackability
