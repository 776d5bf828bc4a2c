#include "track/run_summary.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "evaluation/statistics.hpp"

namespace holdfast::app {
namespace {

constexpr std::size_t kMostRangesShown = 8;

void add_times(StageTimes& sum, const StageTimes& ms) {
  sum.upload += ms.upload;
  sum.render += ms.render;
  sum.filter += ms.filter;
  sum.search += ms.search;
  sum.solve += ms.solve;
  sum.total += ms.total;
  sum.contour += ms.contour;
}

StageTimes divided(const StageTimes& sum, double count) {
  return {sum.upload / count, sum.render / count,  sum.filter / count, sum.search / count,
          sum.solve / count,  sum.contour / count, sum.total / count};
}

std::string text_of(const std::vector<FrameRange>& ranges) {
  std::string text;
  for (std::size_t i = 0; i < ranges.size() && i < kMostRangesShown; ++i) {
    const FrameRange& range = ranges[i];
    text += text.empty() ? "" : ", ";
    text +=
        range.first == range.last ? fmt::format("{}", range.first) : fmt::format("{} to {}", range.first, range.last);
  }
  return ranges.size() > kMostRangesShown
             ? fmt::format("{} and {} stretches more", text, ranges.size() - kMostRangesShown)
             : text;
}

const char* slowest_part(const RunSummary& summary) {
  const double slowest = std::max({summary.read_ms, summary.track_ms, summary.write_ms});
  return slowest == summary.track_ms ? "tracking" : slowest == summary.read_ms ? "reading" : "writing";
}

}  // namespace

void RunningMedian::add(double value) {
  ++added_;
  if (sample_.size() < kMost) {
    sample_.push_back(value);
    return;
  }
  // Each value so far is as likely to be in the sample as any other.
  const std::uint64_t place = std::uniform_int_distribution<std::uint64_t>(0, added_ - 1)(random_);
  if (place < kMost) sample_[place] = value;
}

double RunningMedian::value() const { return sample_.empty() ? 0 : evaluation::quantile(sample_, 0.5); }

void SummaryBuilder::add(const TrackedFrame& tracked) {
  const FrameResult& result = tracked.result;
  ++counts_.frames;
  if (counts_.frames == 2) total_ms_ = {};  // the first frame makes what later ones use
  add_times(total_ms_, result.ms);
  counts_.texture_asked = counts_.texture_asked || result.texture.asked;
  if (counts_.texture_asked && result.snapshot.asked && !counts_.texture_left)
    counts_.texture_left = tracked.frame.index;
  const bool lost = result.status == Status::lost;
  (lost ? lost_ms_ : held_ms_).add(result.ms.total);
  if (lost) {
    ++counts_.lost;
    if (counts_.first_loss_reason.empty()) {
      counts_.first_loss_reason = result.message;
    }
    if (last_was_lost_) {
      counts_.lost_ranges.back().last = tracked.frame.index;
    } else {
      counts_.lost_ranges.push_back({tracked.frame.index, tracked.frame.index});
    }
  } else {
    ++counts_.held;
    counts_.held_by_contour += !result.texture.holds && result.contour.holds;
    Fit& fit = result.texture.holds ? by_texture_ : without_texture_;
    fit.residual.add(result.texture.holds ? result.texture.residual : result.contour.residual);
    fit.used.add(result.texture.holds ? result.texture.used_pixels : result.contour.near_lines);
  }
  last_was_lost_ = lost;
}

RunSummary SummaryBuilder::summary(const PipelineReport& report) const {
  RunSummary summary = counts_;
  const bool only_one = summary.frames <= 1;
  const double frames = only_one ? 1.0 : static_cast<double>(summary.frames - 1);
  const PartTimes first = only_one ? PartTimes() : report.first;
  const double wall_s = report.wall_s - first.wall_s;
  summary.complete = !report.interrupted && !report.failure;
  summary.median_ms = held_ms_.value();
  summary.median_lost_ms = lost_ms_.value();
  summary.by_texture = by_texture_.residual.kept() >= without_texture_.residual.kept();
  const Fit& fit = summary.by_texture ? by_texture_ : without_texture_;
  summary.median_residual = fit.residual.value();
  summary.median_used_pixels = fit.used.value();
  summary.frames_per_second = summary.frames > 0 && wall_s > 0 ? frames / wall_s : 0;
  summary.mean_ms = divided(total_ms_, frames);
  summary.read_ms = (report.read_s - first.read_s) * 1e3 / frames;
  summary.track_ms = (report.track_s - first.track_s) * 1e3 / frames;
  summary.write_ms = (report.write_s - first.write_s) * 1e3 / frames;
  return summary;
}

std::string summary_text(const RunSummary& summary) {
  std::string text = fmt::format("{} frame{}{}: {} held, {} lost\n", summary.frames, summary.frames == 1 ? "" : "s",
                                 summary.complete ? "" : " (ended early)", summary.held, summary.lost);
  if (summary.frames == 0) {
    return text;
  }
  if (summary.lost > 0) {
    text += fmt::format("  lost     frames {}", text_of(summary.lost_ranges));
    if (!summary.first_loss_reason.empty()) {
      text += fmt::format("; in frame {}: {}", summary.lost_ranges.front().first, summary.first_loss_reason);
    }
    text += '\n';
  }
  if (summary.held_by_contour > 0 && summary.texture_asked) {
    text += fmt::format("  contour  {} of the frames held are held by the contour alone\n", summary.held_by_contour);
  }
  if (summary.texture_left) {
    text += fmt::format(
        "  texture  left out from frame {} on, as the frames hardly show it: 'holdfast show' draws the model as it is "
        "read\n",
        *summary.texture_left);
  }
  if (summary.held > 0) {
    text +=
        fmt::format("  median   {:.2f} ms of tracking a held frame, {:.0f} {}, residual {:.4f}{}\n", summary.median_ms,
                    summary.median_used_pixels, summary.by_texture ? "pixels used" : "lines across the contour used",
                    summary.median_residual, summary.by_texture ? "" : " pixels");
  }
  if (summary.lost > 0) {
    text += fmt::format("  median   {:.2f} ms of looking for the object in a lost frame\n", summary.median_lost_ms);
  }
  const StageTimes& ms = summary.mean_ms;
  text += fmt::format(
      "  speed    {:.0f} frames a second{}; a frame takes {:.2f} ms to read, {:.2f} to track, {:.2f} to write, side by "
      "side: {} is the slowest\n",
      summary.frames_per_second, summary.frames > 1 ? " after the first" : "", summary.read_ms, summary.track_ms,
      summary.write_ms, slowest_part(summary));
  text += fmt::format(
      "  tracking upload {:.2f}, render {:.2f}, filter {:.2f}, search {:.2f}, solve {:.2f}, other {:.2f} ms{}\n",
      ms.upload, ms.render, ms.filter, ms.search, ms.solve,
      std::max(0.0, ms.total - ms.upload - ms.render - ms.filter - ms.search - ms.solve),
      ms.contour > 0 ? fmt::format("; contour {:.2f}", ms.contour) : "");
  return text;
}

}  // namespace holdfast::app
