#include "track/object_search.hpp"

#include <chrono>
#include <cstdlib>
#include <system_error>

#include "holdfast/error.hpp"

namespace holdfast::app {

namespace fs = std::filesystem;

namespace {
fs::path cache_folder(const DeviceOptions& options) {
  const auto variable = [](const char* name) -> fs::path {
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
  };
  if (!options.cache_folder.empty()) return options.cache_folder;
  if (const auto folder = variable("HOLDFAST_CACHE_DIR"); !folder.empty()) return folder;
  if (const auto folder = variable("XDG_CACHE_HOME"); !folder.empty()) return folder / "holdfast";
  if (const auto folder = variable("HOME"); !folder.empty()) return folder / ".cache" / "holdfast";
  return {};
}
}  // namespace

detection::ModelFeatures kept_features(const Mesh& mesh, const fs::path& views, const DeviceOptions& options) {
  using detection::ModelFeatures;
  if (!views.empty()) return ModelFeatures::kept_in(views, mesh);
  const fs::path folder = cache_folder(options);
  if (folder.empty()) return ModelFeatures(mesh);
  const fs::path path = folder / (detection::model_hash(mesh) + ".views");
  try {
    return ModelFeatures::load(path, mesh);
  } catch (const Error&) {  // there is none yet, or it is damaged
  }
  ModelFeatures made(mesh);
  try {
    std::error_code failed;
    fs::create_directories(folder, failed);
    made.save(path);
  } catch (const Error&) {  // no cache then
  }
  return made;
}

std::optional<FrameResult> ObjectSearch::look(Tracker& tracker, const ImageView& frame, double time_s) {
  const auto begin = std::chrono::steady_clock::now();
  std::optional<FrameResult> found = detection::start_at(tracker, propose_(frame), frame, time_s);
  ms_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return found;
}

FrameResult ObjectSearch::start(Tracker& tracker, const ImageView& frame, double time_s) {
  FrameResult result;
  result.reason = Reason::out_of_view;
  result.message = "not found yet";
  if (const auto found = look(tracker, frame, time_s)) result = *found;
  result.ms.total = ms_;
  return result;
}

void ObjectSearch::follow(Tracker& tracker, const ImageView& frame, double time_s, FrameResult& result) {
  lost_ = result.status == Status::lost ? lost_ + 1 : 0;
  if (lost_ == 0 || lost_ % 2 != 0) return;
  const double tracked_ms = result.ms.total;
  if (const auto found = look(tracker, frame, time_s)) {
    result = *found;
    lost_ = 0;
  }
  result.ms.total = tracked_ms + ms_;
}

}  // namespace holdfast::app
