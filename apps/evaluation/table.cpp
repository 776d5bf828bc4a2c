#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "evaluation/report.hpp"

namespace holdfast::evaluation {
namespace {

using Cells = std::vector<std::string>;

constexpr double kMillimetres = 1e3;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

enum class Kind {
  share,   ///< 0 to 1, shown in per cent
  number,  ///< any
  whole,   ///< a count
  frame,   ///< a frame number: has no mean
};

struct Column {
  std::string title;
  Kind kind;
  std::function<double(const Summary&)> value;  ///< NaN: nothing to show
};

std::string text(Kind kind, double value) {
  if (std::isnan(value)) {
    return "-";
  }
  if (std::isinf(value)) {
    return "inf";
  }
  switch (kind) {
    case Kind::share:
      return fmt::format("{:.1f}", 100 * value);
    case Kind::whole:
    case Kind::frame:
      return fmt::format("{:.0f}", value);
    case Kind::number:
      break;
  }
  // At least three digits, no more decimals than that needs: columns stay narrow.
  const double magnitude = std::abs(value);
  return fmt::format("{:.{}f}", value, magnitude < 9.995 ? 2 : magnitude < 99.95 ? 1 : 0);
}

Column share(std::string title, std::function<double(const Summary&)> value) {
  return {std::move(title), Kind::share, std::move(value)};
}

Column number(std::string title, std::function<double(const Summary&)> value) {
  return {std::move(title), Kind::number, std::move(value)};
}

Column count(std::string title, std::function<double(const Summary&)> value) {
  return {std::move(title), Kind::whole, std::move(value)};
}

Column first(Within Summary::*within) {
  return {"1st", Kind::frame,
          [within](const Summary& s) { return (s.*within).first_beyond ? *(s.*within).first_beyond : kNone; }};
}

Column share(std::string title, Within Summary::*within) {
  return share(std::move(title), [within](const Summary& s) { return (s.*within).share; });
}

Column part(std::string title, Spread Summary::*column, double Spread::*what, double unit) {
  return number(std::move(title), [=](const Summary& s) { return unit * (s.*column.*what); });
}

Column part(std::string title, std::optional<DistanceScores> Summary::*scores, double DistanceScores::*what,
            Kind kind) {
  return {std::move(title), kind, [=](const Summary& s) { return s.*scores ? (*(s.*scores)).*what : kNone; }};
}

const double kDegrees = to_degrees(1.0);

/// Columns that both protocols end with.
void append_common(std::vector<Column>& columns) {
  columns.push_back(count("lost", [](const Summary& s) { return s.lost_frames; }));
  columns.push_back(count("wrong", [](const Summary& s) { return s.confidently_wrong; }));
  columns.push_back(number("ms", [](const Summary& s) { return s.ms_median; }));
}

std::vector<Column> columns_of_rbot() {
  std::vector<Column> columns = {
      count("frames", [](const Summary& s) { return s.frames; }),
      share("success%", &Summary::failure),
      first(&Summary::failure),
      share("2cm2deg%", &Summary::within_20mm_2deg),
      part("mm:med", &Summary::distance_ok, &Spread::median, kMillimetres),
      part("95%", &Summary::distance_ok, &Spread::p95, kMillimetres),
      part("deg:med", &Summary::rotation_ok, &Spread::median, kDegrees),
      part("95%", &Summary::rotation_ok, &Spread::p95, kDegrees),
  };
  append_common(columns);
  return columns;
}

std::vector<Column> columns_of_never_reset() {
  std::vector<Column> columns = {
      count("frames", [](const Summary& s) { return s.frames; }),
      share("10mm2deg%", &Summary::within_10mm_2deg),
      first(&Summary::within_10mm_2deg),
      share("5cm5deg%", &Summary::within_50mm_5deg),
      first(&Summary::within_50mm_5deg),
      part("mm:med", &Summary::distance, &Spread::median, kMillimetres),
      part("95%", &Summary::distance, &Spread::p95, kMillimetres),
      part("max", &Summary::distance, &Spread::maximum, kMillimetres),
      part("deg:med", &Summary::rotation, &Spread::median, kDegrees),
      part("95%", &Summary::rotation, &Spread::p95, kDegrees),
      part("max", &Summary::rotation, &Spread::maximum, kDegrees),
  };
  append_common(columns);
  return columns;
}

/// Longest of the losses that ended, counted since the object could be seen again.
double slowest_reacquisition(const Summary& summary) {
  double slowest = kNone;
  for (const Loss& loss : summary.losses) {
    if (loss.reacquired_frame) {
      slowest = std::fmax(slowest, loss.frames_since_visible);
    }
  }
  return slowest;
}

double never_reacquired(const Summary& summary) {
  return static_cast<double>(std::count_if(summary.losses.begin(), summary.losses.end(),
                                           [](const Loss& loss) { return !loss.reacquired_frame; }));
}

std::vector<Column> columns_of_details(bool rbot) {
  std::vector<Column> columns = {
      part("ADD2%", &Summary::add, &DistanceScores::below_2_percent, Kind::share),
      part("5%", &Summary::add, &DistanceScores::below_5_percent, Kind::share),
      part("10%", &Summary::add, &DistanceScores::below_10_percent, Kind::share),
      part("AUC", &Summary::add, &DistanceScores::auc_100mm, Kind::number),
      part("OPT", &Summary::add, &DistanceScores::auc_opt, Kind::number),
      part("ADDS2%", &Summary::add_s, &DistanceScores::below_2_percent, Kind::share),
      part("5%", &Summary::add_s, &DistanceScores::below_5_percent, Kind::share),
      part("10%", &Summary::add_s, &DistanceScores::below_10_percent, Kind::share),
      part("AUC", &Summary::add_s, &DistanceScores::auc_100mm, Kind::number),
      part("OPT", &Summary::add_s, &DistanceScores::auc_opt, Kind::number),
      part("depth:med", &Summary::depth, &Spread::median, kMillimetres),
      part("95%", &Summary::depth, &Spread::p95, kMillimetres),
      part("max", &Summary::depth, &Spread::maximum, kMillimetres),
      part("lateral:med", &Summary::lateral, &Spread::median, kMillimetres),
      part("95%", &Summary::lateral, &Spread::p95, kMillimetres),
      part("max", &Summary::lateral, &Spread::maximum, kMillimetres),
      share("cover%", [](const Summary& s) { return s.coverage.inside_95; }),
      share("occluder%", [](const Summary& s) { return s.occluder ? s.occluder->share : kNone; }),
      number("chi2", [](const Summary& s) { return s.coverage.median_squared; }),
  };
  if (!rbot) {
    columns.insert(columns.begin(), share("2cm2deg%", &Summary::within_20mm_2deg));
    columns.push_back(count("losses", [](const Summary& s) { return static_cast<double>(s.losses.size()); }));
    columns.push_back(count("never back", never_reacquired));
    columns.push_back(count("slowest back", slowest_reacquisition));
  }
  return columns;
}

double mean(const Column& column, const std::vector<Evaluation>& evaluations, int step) {
  if (column.kind == Kind::frame) {
    return kNone;
  }
  double sum = 0;
  int values = 0;
  for (const Evaluation& evaluation : evaluations) {
    if (evaluation.step == step) {
      sum += column.value(evaluation.summary);
      ++values;
    }
  }
  return values > 0 ? sum / values : kNone;
}

std::string aligned(const std::vector<Cells>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const Cells& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], row[i].size());
    }
  }
  std::string out;
  for (const Cells& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      out += i == 0 ? fmt::format("{:<{}}", row[i], widths[i]) : fmt::format("  {:>{}}", row[i], widths[i]);
    }
    out += '\n';
  }
  return out;
}

std::string table_of(const std::vector<Evaluation>& evaluations, const std::vector<Column>& columns) {
  std::vector<Cells> rows = {{"sequence", "step"}};
  for (const Column& column : columns) {
    rows.front().push_back(column.title);
  }
  std::set<int> steps;
  std::set<std::string> sequences;
  for (const Evaluation& evaluation : evaluations) {
    steps.insert(evaluation.step);
    sequences.insert(evaluation.sequence);
    rows.push_back({evaluation.sequence, std::to_string(evaluation.step)});
    for (const Column& column : columns) {
      rows.back().push_back(text(column.kind, column.value(evaluation.summary)));
    }
  }
  if (sequences.size() > 1) {
    for (const int step : steps) {
      rows.push_back({"mean", std::to_string(step)});
      for (const Column& column : columns) {
        const Kind kind = column.kind == Kind::whole ? Kind::number : column.kind;
        rows.back().push_back(text(kind, mean(column, evaluations, step)));
      }
    }
  }
  return aligned(rows);
}

}  // namespace

std::string table(const std::vector<Evaluation>& evaluations, bool rbot) {
  return table_of(evaluations, rbot ? columns_of_rbot() : columns_of_never_reset());
}

std::string detail_table(const std::vector<Evaluation>& evaluations, bool rbot) {
  return table_of(evaluations, columns_of_details(rbot));
}

}  // namespace holdfast::evaluation
