#include "track/pose_writers.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "holdfast/error.hpp"

namespace holdfast::app {
namespace {

using nlohmann::ordered_json;

constexpr const char* kCsvHeader =
    "frame,time_s,status,tx,ty,tz,qx,qy,qz,qw,visible,usable,gradient,passed,used,residual,correlation,iterations,ms,"
    "reason,texture_holds,contour_holds,snapshot_holds\n";

const char* status_word(Status status) { return status == Status::held ? "held" : "lost"; }

Eigen::Quaterniond quaternion_of(const Pose& pose) {
  Eigen::Quaterniond q(pose.rotation());
  if (q.w() < 0) {
    q.coeffs() = -q.coeffs();
  }
  return q;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c;
    if (c == '"') {
      quoted += '"';
    }
  }
  return quoted + "\"";
}

/// The seven numbers of a pose, `separator` between them.
std::string pose_text(const Pose& pose, char separator) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q = quaternion_of(pose);
  return fmt::format("{1:.9g}{0}{2:.9g}{0}{3:.9g}{0}{4:.9f}{0}{5:.9f}{0}{6:.9f}{0}{7:.9f}", separator, t.x(), t.y(),
                     t.z(), q.x(), q.y(), q.z(), q.w());
}

ordered_json frame_json(const TrackedFrame& tracked) {
  const FrameResult& result = tracked.result;
  const Eigen::Vector3d t = result.T_camera_object.translation();
  const Eigen::Quaterniond q = quaternion_of(result.T_camera_object);
  ordered_json information = ordered_json::array();
  for (int row = 0; row < 6; ++row) {
    ordered_json values = ordered_json::array();
    for (int column = 0; column < 6; ++column) {
      values.push_back(result.information(row, column));
    }
    information.push_back(std::move(values));
  }
  return {{"frame", tracked.frame.index},
          {"time_s", tracked.frame.time_s},
          {"status", status_word(result.status)},
          {"reason", result.message},
          {"texture_holds", result.texture.holds},
          {"contour_holds", result.contour.holds},
          {"snapshot_holds", result.snapshot.holds},
          {"translation", {t.x(), t.y(), t.z()}},
          {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}},
          {"pixels",
           {{"visible", result.visible_pixels()},
            {"usable", result.texture.usable_pixels},
            {"gradient", result.texture.gradient_pixels},
            {"passed", result.texture.passed_pixels},
            {"used", result.texture.used_pixels}}},
          {"rows", result.texture.rows},
          {"residual", result.texture.residual},
          {"correlation", result.texture.correlation},
          {"contour",
           {{"lines", result.contour.lines},
            {"telling", result.contour.telling_lines},
            {"near", result.contour.near_lines},
            {"agreement", result.contour.agreement},
            {"residual", result.contour.residual}}},
          {"edges",
           {{"lines", result.edges.lines},
            {"near", result.edges.near_lines},
            {"score", result.edges.score},
            {"residual", result.edges.residual}}},
          {"snapshot",
           {{"gradient", result.snapshot.gradient_pixels},
            {"used", result.snapshot.used_pixels},
            {"correlation", result.snapshot.correlation}}},
          {"iterations", result.iterations},
          {"ms",
           {{"upload", result.ms.upload},
            {"render", result.ms.render},
            {"filter", result.ms.filter},
            {"search", result.ms.search},
            {"solve", result.ms.solve},
            {"total", result.ms.total},
            {"contour", result.ms.contour}}},
          {"information", std::move(information)}};
}

ordered_json summary_json(const RunSummary& summary) {
  ordered_json lost_ranges = ordered_json::array();
  for (const FrameRange& range : summary.lost_ranges) {
    lost_ranges.push_back({range.first, range.last});
  }
  return {{"frames", summary.frames},
          {"held", summary.held},
          {"lost", summary.lost},
          {"held_by_contour", summary.held_by_contour},
          {"texture_left", summary.texture_left ? ordered_json(*summary.texture_left) : ordered_json()},
          {"lost_ranges", std::move(lost_ranges)},
          {"complete", summary.complete},
          {"median_ms", summary.median_ms},
          {"median_lost_ms", summary.median_lost_ms},
          {"by_texture", summary.by_texture},
          {"median_residual", summary.median_residual},
          {"median_used_pixels", summary.median_used_pixels},
          {"frames_per_second", summary.frames_per_second},
          {"mean_ms",
           {{"read", summary.read_ms},
            {"track", summary.track_ms},
            {"write", summary.write_ms},
            {"upload", summary.mean_ms.upload},
            {"render", summary.mean_ms.render},
            {"filter", summary.mean_ms.filter},
            {"search", summary.mean_ms.search},
            {"solve", summary.mean_ms.solve},
            {"contour", summary.mean_ms.contour}}}};
}

}  // namespace

CsvWriter::CsvWriter(const std::filesystem::path& path) : file_(path) { file_.write(kCsvHeader); }

void CsvWriter::write(const TrackedFrame& tracked) {
  const FrameResult& result = tracked.result;
  file_.write(fmt::format(
      "{},{:.6f},{},{},{},{},{},{},{},{:.6g},{:.6g},{},{:.3f},{},{:d},{:d},{:d}\n", tracked.frame.index,
      tracked.frame.time_s, status_word(result.status), pose_text(result.T_camera_object, ','), result.visible_pixels(),
      result.texture.usable_pixels, result.texture.gradient_pixels, result.texture.passed_pixels,
      result.texture.used_pixels, result.texture.residual, result.texture.correlation, result.iterations,
      result.ms.total, csv_field(result.message), result.texture.holds, result.contour.holds, result.snapshot.holds));
}

TumWriter::TumWriter(const std::filesystem::path& path) : file_(path) {}

void TumWriter::write(const TrackedFrame& tracked) {
  if (tracked.result.status == Status::held) {
    file_.write(fmt::format("{:.6f} {}\n", tracked.frame.time_s, pose_text(tracked.result.T_camera_object, ' ')));
  }
}

JsonWriter::JsonWriter(const std::filesystem::path& path, const std::string& run) : file_(path) {
  append("{\"run\": " + run + ",\n\"frames\": [", "\n]}\n");
}

void JsonWriter::append(const std::string& text, const std::string& closing) {
  if (file_.can_rewind()) {
    file_.rewind_to(end_);
    try {
      file_.write(text + closing);
    } catch (const Error&) {
      file_.write(closing_);  // there was room for these
      throw;
    }
    end_ += static_cast<long>(text.size());
    closing_ = closing;
  } else {
    file_.write(text);
  }
}

void JsonWriter::write(const TrackedFrame& tracked) {
  append((first_ ? "\n" : ",\n") + frame_json(tracked).dump(-1, ' ', false, ordered_json::error_handler_t::replace),
         "\n]}\n");
  first_ = false;
}

void JsonWriter::finish(const RunSummary& summary) {
  append("\n],\n\"summary\": " + summary_json(summary).dump() + "}\n", "");
}

}  // namespace holdfast::app
