#include "evaluation/summary.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "evaluation/model_points.hpp"

namespace holdfast::evaluation {
namespace {

using Runs = std::map<int, std::vector<const FrameRecord*>>;  // by offset

Within within(const Runs& runs, const std::function<bool(const FrameRecord&)>& holds) {
  Within out;
  int counted = 0;
  int good = 0;
  int fewest = std::numeric_limits<int>::max();
  for (const auto& [offset, records] : runs) {
    int tracked = 0;
    bool lost = false;
    for (const FrameRecord* record : records) {
      if (record->counted) {
        ++counted;
        const bool ok = holds(*record);
        good += ok ? 1 : 0;
        if (!ok && !lost) {
          lost = true;
          fewest = std::min(fewest, tracked);
          out.first_beyond = out.first_beyond ? std::min(*out.first_beyond, record->frame) : record->frame;
        }
      }
      ++tracked;
    }
    if (!lost) {
      fewest = std::min(fewest, tracked);
    }
  }
  out.share = counted > 0 ? static_cast<double>(good) / counted : std::numeric_limits<double>::quiet_NaN();
  out.frames_to_first_beyond = runs.empty() ? 0 : fewest;
  return out;
}

DistanceScores distance_scores(const std::vector<double>& distances, double diameter) {
  DistanceScores out;
  out.below_2_percent = share_below(distances, 0.02 * diameter);
  out.below_5_percent = share_below(distances, 0.05 * diameter);
  out.below_10_percent = share_below(distances, 0.10 * diameter);
  out.auc_100mm = 100 * area_under_accuracy(distances, 0.1);
  out.auc_opt = 20 * area_under_accuracy(distances, 0.2 * diameter);
  out.distance = spread(distances);
  return out;
}

void append_losses(const std::vector<const FrameRecord*>& run, const Tolerance& failure, std::vector<Loss>& losses) {
  bool inside = false;
  for (const FrameRecord* record : run) {
    const bool good = record->result.status == Status::held && failure.holds(record->error);
    if (good) {
      if (inside) {
        losses.back().reacquired_frame = record->frame;
        if (record->visible < kVisibleAgain) {
          losses.back().frames_since_visible = 0;
        }
      }
      inside = false;
      continue;
    }
    if (!inside) {
      losses.push_back({});
      losses.back().step = record->step;
      losses.back().offset = record->offset;
      losses.back().first_frame = record->frame;
      inside = true;
    }
    Loss& loss = losses.back();
    ++loss.frames;
    loss.frames_since_visible = record->visible < kVisibleAgain ? 0 : loss.frames_since_visible + 1;
  }
}

/// NaN where the frame reports no usable covariance.
double normalized(const FrameRecord& record) {
  const Matrix6& information = record.result.information;
  if (!information.allFinite() || Eigen::LLT<Matrix6>(information).info() != Eigen::Success) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return normalized_error_squared(record.T_camera_object_true, record.result.T_camera_object, information);
}

Coverage coverage_of(const std::vector<double>& normalized_squared) {
  Coverage out;
  out.frames = static_cast<int>(normalized_squared.size());
  const auto inside = std::count_if(normalized_squared.begin(), normalized_squared.end(),
                                    [](double value) { return value <= kChiSquared6At95; });
  out.inside_95 = out.frames > 0 ? static_cast<double>(inside) / out.frames : std::numeric_limits<double>::quiet_NaN();
  out.median_squared = quantile(normalized_squared, 0.5);
  return out;
}

std::optional<OccluderShare> occluder_share(std::span<const FrameRecord> records) {
  OccluderShare out;
  double used = 0;
  double on_occluder = 0;
  for (const FrameRecord& record : records) {
    if (!record.counted || !record.occluder || !record.occluder->overlaps) {
      continue;
    }
    ++out.frames;
    used += record.occluder->used;
    on_occluder += record.occluder->on_occluder;
    if (record.occluder->used > 0) {
      out.worst_frame =
          std::max(out.worst_frame, static_cast<double>(record.occluder->on_occluder) / record.occluder->used);
    }
  }
  if (out.frames == 0) {
    return std::nullopt;
  }
  out.share = used > 0 ? on_occluder / used : 0;
  return out;
}

}  // namespace

Summary summarize(std::span<const FrameRecord> records, const Tolerance& failure, double diameter) {
  Runs runs;
  for (const FrameRecord& record : records) {
    runs[record.offset].push_back(&record);
  }
  const auto inside = [&runs](double mm, double degrees) {
    const Tolerance tolerance = tolerance_mm_deg(mm, degrees);
    return within(runs, [&tolerance](const FrameRecord& record) { return tolerance.holds(record.error); });
  };

  Summary out;
  out.failure = within(runs, [&failure](const FrameRecord& record) { return failure.holds(record.error); });
  out.within_50mm_5deg = inside(50, 5);
  out.within_20mm_2deg = inside(20, 2);
  out.within_10mm_2deg = inside(10, 2);

  for (const auto& [offset, run] : runs) {
    append_losses(run, failure, out.losses);
  }

  const Tolerance wrong = tolerance_mm_deg(20, 5);
  std::vector<double> distance, rotation, distance_ok, rotation_ok, x, y, depth, lateral, add, add_s, covered, ms;
  for (const FrameRecord& record : records) {
    if (record.result.ms.total > 0) {
      ms.push_back(record.result.ms.total);
    }
    if (!record.counted) {
      ++out.skipped;
      continue;
    }
    ++out.frames;
    distance.push_back(record.error.distance());
    rotation.push_back(record.error.rotation);
    x.push_back(std::abs(record.error.translation.x()));
    y.push_back(std::abs(record.error.translation.y()));
    depth.push_back(record.error.depth());
    lateral.push_back(record.error.lateral());
    if (failure.holds(record.error)) {
      distance_ok.push_back(record.error.distance());
      rotation_ok.push_back(record.error.rotation);
    }
    if (record.add >= 0) {
      add.push_back(record.add);
    }
    if (record.add_s >= 0) {
      add_s.push_back(record.add_s);
    }
    if (record.result.status == Status::lost) {
      ++out.lost_frames;
      continue;
    }
    out.confidently_wrong += wrong.holds(record.error) ? 0 : 1;
    if (const double squared = normalized(record); !std::isnan(squared)) {
      covered.push_back(squared);
    }
  }
  out.distance = spread(distance);
  out.rotation = spread(rotation);
  out.distance_ok = spread(distance_ok);
  out.rotation_ok = spread(rotation_ok);
  out.x = spread(x);
  out.y = spread(y);
  out.depth = spread(depth);
  out.lateral = spread(lateral);
  if (diameter > 0 && !add.empty() && add.size() == distance.size()) {
    out.add = distance_scores(add, diameter);
  }
  if (diameter > 0 && !add_s.empty() && add_s.size() == distance.size()) {
    out.add_s = distance_scores(add_s, diameter);
  }
  out.coverage = coverage_of(covered);
  out.occluder = occluder_share(records);
  out.ms_median = quantile(ms, 0.5);
  out.ms_p95 = quantile(ms, 0.95);
  return out;
}

}  // namespace holdfast::evaluation
