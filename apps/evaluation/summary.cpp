#include "evaluation/summary.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>

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

}  // namespace

Summary summarize(std::span<const FrameRecord> records) {
  Runs runs;
  for (const FrameRecord& record : records) {
    runs[record.offset].push_back(&record);
  }
  const auto inside = [&runs](double mm, double degrees) {
    const Tolerance tolerance = tolerance_mm_deg(mm, degrees);
    return within(runs, [&tolerance](const FrameRecord& record) { return tolerance.holds(record.error); });
  };

  Summary out;
  out.failure = within(runs, [](const FrameRecord& record) { return !record.failed; });
  out.within_50mm_5deg = inside(50, 5);
  out.within_20mm_2deg = inside(20, 2);
  out.within_10mm_2deg = inside(10, 2);

  const Tolerance wrong = tolerance_mm_deg(20, 5);
  std::vector<double> distance, rotation, distance_ok, rotation_ok, ms;
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
    if (!record.failed) {
      distance_ok.push_back(record.error.distance());
      rotation_ok.push_back(record.error.rotation);
    }
    const bool held = record.result.status == Status::held;
    out.lost_frames += held ? 0 : 1;
    out.confidently_wrong += held && !wrong.holds(record.error) ? 1 : 0;
  }
  out.distance = spread(distance);
  out.rotation = spread(rotation);
  out.distance_ok = spread(distance_ok);
  out.rotation_ok = spread(rotation_ok);
  out.ms_median = quantile(ms, 0.5);
  out.ms_p95 = quantile(ms, 0.95);
  return out;
}

}  // namespace holdfast::evaluation
