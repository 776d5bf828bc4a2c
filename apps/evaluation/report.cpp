#include "evaluation/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <set>

#include "holdfast/error.hpp"

namespace holdfast::evaluation {
namespace {

using Cells = std::vector<std::string>;

/// At least three digits, few enough to keep columns narrow.
std::string number(double value) {
  if (std::isnan(value)) {
    return "-";
  }
  if (std::isinf(value)) {
    return "inf";
  }
  const double magnitude = std::abs(value);
  return fmt::format("{:.{}f}", value, magnitude < 9.995 ? 2 : magnitude < 99.95 ? 1 : 0);
}

std::string percent(double share) { return std::isnan(share) ? "-" : fmt::format("{:.1f}", 100 * share); }

std::string first(const Within& within) { return within.first_beyond ? std::to_string(*within.first_beyond) : "-"; }

std::string aligned(const std::vector<Cells>& rows) {
  std::vector<std::size_t> widths;
  for (const Cells& row : rows) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], row[i].size());
    }
  }
  std::string out;
  for (const Cells& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += i == 0 ? fmt::format("{:<{}}", row[i], widths[i]) : fmt::format("  {:>{}}", row[i], widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  return out;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
}

enum class Kind { share, number, whole, first };

struct Column {
  const char* title;
  Kind kind;
  double (*value)(const Summary&);
  const Within& (*within)(const Summary&);
};

constexpr double kMillimetres = 1e3;

std::vector<Column> columns(Protocol protocol) {
  static const auto none = static_cast<const Within& (*)(const Summary&)>(nullptr);
  const Column frames{"frames", Kind::whole, [](const Summary& s) { return static_cast<double>(s.frames); }, none};
  const Column lost{"lost", Kind::whole, [](const Summary& s) { return static_cast<double>(s.lost_frames); }, none};
  const Column wrong{"wrong", Kind::whole, [](const Summary& s) { return static_cast<double>(s.confidently_wrong); },
                     none};
  const Column ms{"ms", Kind::number, [](const Summary& s) { return s.ms_median; }, none};
  const Column tight{"2cm2deg%", Kind::share, [](const Summary& s) { return s.within_20mm_2deg.share; }, none};
  if (protocol == Protocol::rbot) {
    return {
        frames,
        {"success%", Kind::share, [](const Summary& s) { return s.failure.share; }, none},
        {"1st", Kind::first, nullptr, [](const Summary& s) -> const Within& { return s.failure; }},
        tight,
        {"mm:med", Kind::number, [](const Summary& s) { return kMillimetres * s.distance_ok.median; }, none},
        {"95%", Kind::number, [](const Summary& s) { return kMillimetres * s.distance_ok.p95; }, none},
        {"deg:med", Kind::number, [](const Summary& s) { return to_degrees(s.rotation_ok.median); }, none},
        {"95%", Kind::number, [](const Summary& s) { return to_degrees(s.rotation_ok.p95); }, none},
        lost,
        wrong,
        ms,
    };
  }
  return {
      frames,
      {"10mm2deg%", Kind::share, [](const Summary& s) { return s.within_10mm_2deg.share; }, none},
      {"1st", Kind::first, nullptr, [](const Summary& s) -> const Within& { return s.within_10mm_2deg; }},
      {"5cm5deg%", Kind::share, [](const Summary& s) { return s.within_50mm_5deg.share; }, none},
      {"1st", Kind::first, nullptr, [](const Summary& s) -> const Within& { return s.within_50mm_5deg; }},
      {"mm:med", Kind::number, [](const Summary& s) { return kMillimetres * s.distance.median; }, none},
      {"95%", Kind::number, [](const Summary& s) { return kMillimetres * s.distance.p95; }, none},
      {"max", Kind::number, [](const Summary& s) { return kMillimetres * s.distance.maximum; }, none},
      {"deg:med", Kind::number, [](const Summary& s) { return to_degrees(s.rotation.median); }, none},
      {"95%", Kind::number, [](const Summary& s) { return to_degrees(s.rotation.p95); }, none},
      {"max", Kind::number, [](const Summary& s) { return to_degrees(s.rotation.maximum); }, none},
      lost,
      wrong,
      ms,
  };
}

std::string cell(const Column& column, const Summary& summary) {
  switch (column.kind) {
    case Kind::share:
      return percent(column.value(summary));
    case Kind::number:
      return number(column.value(summary));
    case Kind::whole:
      return fmt::format("{:.0f}", column.value(summary));
    case Kind::first:
      return first(column.within(summary));
  }
  return {};
}

std::string mean_cell(const Column& column, const std::vector<Evaluation>& evaluations, int step) {
  if (column.kind == Kind::first) {
    return "";
  }
  std::vector<double> values;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.step == step) {
      values.push_back(column.value(evaluation.summary));
    }
  }
  const double value = mean(values);
  return column.kind == Kind::share ? percent(value) : number(value);
}

}  // namespace

std::string table(const std::vector<Evaluation>& evaluations, Protocol protocol) {
  const std::vector<Column> all = columns(protocol);
  std::vector<Cells> rows;
  Cells heading = {"sequence", "step"};
  for (const Column& column : all) {
    heading.emplace_back(column.title);
  }
  rows.push_back(heading);
  std::set<int> steps;
  std::set<std::string> sequences;
  for (const Evaluation& evaluation : evaluations) {
    steps.insert(evaluation.step);
    sequences.insert(evaluation.sequence);
    Cells row = {evaluation.sequence, std::to_string(evaluation.step)};
    for (const Column& column : all) {
      row.push_back(cell(column, evaluation.summary));
    }
    rows.push_back(row);
  }
  if (sequences.size() > 1) {
    for (const int step : steps) {
      Cells row = {"mean", std::to_string(step)};
      for (const Column& column : all) {
        row.push_back(mean_cell(column, evaluations, step));
      }
      rows.push_back(row);
    }
  }
  return aligned(rows);
}

void write_frames_csv(const std::filesystem::path& path, const std::vector<Evaluation>& evaluations) {
  std::ofstream out(path);
  out << "sequence,step,offset,frame,visible,counted,failed,status,reason,error_mm,error_x_mm,error_y_mm,error_z_mm,"
         "error_deg,add_mm,add_s_mm,correlation,residual,visible_pixels,usable_pixels,gradient_pixels,passed_pixels,"
         "used_pixels,rows,iterations,ms,ms_upload,ms_render,ms_filter,ms_search,ms_solve";
  for (const char* whose : {"true", "estimated"}) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        out << fmt::format(",{}_{}{}", whose, row, column);
      }
    }
  }
  out << '\n';
  for (const Evaluation& evaluation : evaluations) {
    for (const FrameRecord& record : evaluation.records) {
      const FrameResult& result = record.result;
      std::string reason = result.reason;
      std::replace(reason.begin(), reason.end(), ',', ';');
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      const auto optional_mm = [](double metres) {
        return metres < 0 ? std::string() : fmt::format("{:.4f}", 1e3 * metres);
      };
      out << fmt::format("{},{},{},{},{:.4f},{:d},{:d},{},{}", evaluation.sequence, record.step, record.offset,
                         record.frame, record.visible, record.counted, record.failed,
                         result.status == Status::held ? "held" : "lost", reason);
      out << fmt::format(",{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{}", kMillimetres * record.error.distance(),
                         kMillimetres * record.error.translation.x(), kMillimetres * record.error.translation.y(),
                         kMillimetres * record.error.translation.z(), to_degrees(record.error.rotation),
                         optional_mm(record.add), optional_mm(record.add_s));
      out << fmt::format(",{:.5f},{:.6f},{},{},{},{},{},{},{}", result.correlation, result.residual,
                         result.visible_pixels, result.usable_pixels, result.gradient_pixels, result.passed_pixels,
                         result.used_pixels, result.rows, result.iterations);
      out << fmt::format(",{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f}", result.ms.total, result.ms.upload,
                         result.ms.render, result.ms.filter, result.ms.search, result.ms.solve);
      for (const Pose* pose : {&record.T_camera_object_true, &result.T_camera_object}) {
        for (int row = 0; row < 3; ++row) {
          for (int column = 0; column < 4; ++column) {
            out << fmt::format(",{:.9g}", pose->matrix()(row, column));
          }
        }
      }
      out << '\n';
    }
  }
  out.flush();
  if (!out) {
    throw Error(ErrorCode::file, fmt::format("{}: cannot be written", path.string()));
  }
}

}  // namespace holdfast::evaluation
