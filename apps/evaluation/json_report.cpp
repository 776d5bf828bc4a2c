#include <fmt/core.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "evaluation/report.hpp"
#include "track/output_file.hpp"

namespace holdfast::evaluation {
namespace {

using nlohmann::ordered_json;

constexpr double kMillimetres = 1e3;
const double kDegrees = to_degrees(1.0);

ordered_json json_of(const Spread& spread, double unit) {
  return {{"median", unit * spread.median}, {"p95", unit * spread.p95}, {"max", unit * spread.maximum}};
}

ordered_json json_of(const Within& within) {
  return {{"share", within.share},
          {"first_beyond", within.first_beyond ? ordered_json(*within.first_beyond) : ordered_json()},
          {"frames_to_first_beyond", within.frames_to_first_beyond}};
}

ordered_json json_of(const std::optional<DistanceScores>& scores) {
  if (!scores) {
    return {};
  }
  return {{"below_2_percent", scores->below_2_percent},
          {"below_5_percent", scores->below_5_percent},
          {"below_10_percent", scores->below_10_percent},
          {"auc_100mm", scores->auc_100mm},
          {"auc_opt", scores->auc_opt},
          {"mm", json_of(scores->distance, kMillimetres)}};
}

ordered_json json_of(const std::optional<OccluderShare>& occluder) {
  if (!occluder) {
    return {};
  }
  return {{"frames", occluder->frames}, {"share", occluder->share}, {"worst_frame", occluder->worst_frame}};
}

ordered_json json_of(const Loss& loss) {
  return {{"offset", loss.offset},
          {"first_frame", loss.first_frame},
          {"reacquired_frame", loss.reacquired_frame ? ordered_json(*loss.reacquired_frame) : ordered_json()},
          {"frames", loss.frames},
          {"frames_since_visible", loss.frames_since_visible}};
}

ordered_json json_of(const Summary& summary) {
  ordered_json losses = ordered_json::array();
  for (const Loss& loss : summary.losses) {
    losses.push_back(json_of(loss));
  }
  return {{"frames", summary.frames},
          {"skipped", summary.skipped},
          {"success", json_of(summary.failure)},
          {"within_50mm_5deg", json_of(summary.within_50mm_5deg)},
          {"within_20mm_2deg", json_of(summary.within_20mm_2deg)},
          {"within_10mm_2deg", json_of(summary.within_10mm_2deg)},
          {"translation_mm", json_of(summary.distance, kMillimetres)},
          {"rotation_deg", json_of(summary.rotation, kDegrees)},
          {"translation_mm_not_failed", json_of(summary.distance_ok, kMillimetres)},
          {"rotation_deg_not_failed", json_of(summary.rotation_ok, kDegrees)},
          {"x_mm", json_of(summary.x, kMillimetres)},
          {"y_mm", json_of(summary.y, kMillimetres)},
          {"depth_mm", json_of(summary.depth, kMillimetres)},
          {"lateral_mm", json_of(summary.lateral, kMillimetres)},
          {"add", json_of(summary.add)},
          {"add_s", json_of(summary.add_s)},
          {"lost_frames", summary.lost_frames},
          {"confidently_wrong_frames", summary.confidently_wrong},
          {"losses", losses},
          {"coverage",
           {{"frames", summary.coverage.frames},
            {"inside_95", summary.coverage.inside_95},
            {"median_chi_squared", summary.coverage.median_squared},
            {"expected_median_chi_squared", kChiSquared6Median}}},
          {"occluder_pixels_used", json_of(summary.occluder)},
          {"ms_median", summary.ms_median},
          {"ms_p95", summary.ms_p95}};
}

/// A column a quantity: what plots read.
ordered_json json_of(const std::vector<FrameRecord>& records) {
  const auto column = [&records](const std::function<ordered_json(const FrameRecord&)>& value) {
    ordered_json out = ordered_json::array();
    for (const FrameRecord& record : records) {
      out.push_back(value(record));
    }
    return out;
  };
  const auto optional_mm = [](double metres) {
    return metres < 0 ? ordered_json() : ordered_json(kMillimetres * metres);
  };
  return {
      {"frame", column([](const FrameRecord& r) { return r.frame; })},
      {"offset", column([](const FrameRecord& r) { return r.offset; })},
      {"counted", column([](const FrameRecord& r) { return r.counted; })},
      {"held", column([](const FrameRecord& r) { return r.result.status == Status::held; })},
      {"texture_holds", column([](const FrameRecord& r) { return r.result.texture.holds; })},
      {"contour_holds", column([](const FrameRecord& r) { return r.result.contour.holds; })},
      {"snapshot_holds", column([](const FrameRecord& r) { return r.result.snapshot.holds; })},
      {"visible", column([](const FrameRecord& r) { return r.visible; })},
      {"x_mm", column([](const FrameRecord& r) { return kMillimetres * r.error.translation.x(); })},
      {"y_mm", column([](const FrameRecord& r) { return kMillimetres * r.error.translation.y(); })},
      {"z_mm", column([](const FrameRecord& r) { return kMillimetres * r.error.translation.z(); })},
      {"rotation_deg", column([](const FrameRecord& r) { return to_degrees(r.error.rotation); })},
      {"add_mm", column([&](const FrameRecord& r) { return optional_mm(r.add); })},
      {"add_s_mm", column([&](const FrameRecord& r) { return optional_mm(r.add_s); })},
      {"ms", column([](const FrameRecord& r) {
         return r.result.ms.total > 0 ? ordered_json(r.result.ms.total) : ordered_json();
       })},
  };
}

}  // namespace

void write_json(const std::filesystem::path& path, const Provenance& provenance,
                const std::vector<Evaluation>& evaluations) {
  ordered_json root;
  root["protocol"] = provenance.protocol;
  root["failure"] = {{"mm", kMillimetres * provenance.failure.translation},
                     {"deg", to_degrees(provenance.failure.rotation)}};
  root["minimum_visible"] = provenance.minimum_visible;
  root["show_start_frame"] = provenance.show_start_frame;
  root["tracker"] = provenance.tracker;
  root["complete"] = provenance.complete;
  root["evaluations"] = ordered_json::array();
  for (const Evaluation& evaluation : evaluations) {
    ordered_json entry;
    entry["sequence"] = evaluation.sequence;
    entry["model"] = evaluation.model.empty() ? ordered_json() : ordered_json(evaluation.model);
    entry["diameter_mm"] = evaluation.diameter > 0 ? ordered_json(kMillimetres * evaluation.diameter) : ordered_json();
    entry["step"] = evaluation.step;
    entry["summary"] = json_of(evaluation.summary);
    if (provenance.protocol == "rbot") {
      entry["summary"]["losses"] = nullptr;  // its resets end them, not the tracker
    }
    entry["per_frame"] = json_of(evaluation.records);
    root["evaluations"].push_back(entry);
  }
  app::write_whole(path, root.dump(1) + "\n");
}

}  // namespace holdfast::evaluation
