#include "track/object_search.hpp"

#include <fmt/format.h>

#include <chrono>
#include <system_error>

#include "holdfast/error.hpp"
#include "slow_notice.hpp"
#include "track/output_file.hpp"

namespace holdfast::app {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSeenByGuide = 3;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace

using detection::ModelFeatures;

ModelFeatures Recognition::drawn_features(const Mesh& mesh) const {
  if (!mesh.has_appearance()) return ModelFeatures::none(mesh);
  const SlowNotice notice(quiet ? nullptr : terminal(), "drawing the model from all sides, to recognize it by");
  if (!views.empty()) return ModelFeatures::kept_in(views, mesh);
  const fs::path folder = options.cache_folder.empty() ? default_cache_folder() : options.cache_folder;
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

ModelFeatures Recognition::seen_features(const Mesh& mesh) const {
  std::error_code unknown;
  if (remembered.empty() || !fs::exists(remembered, unknown)) return ModelFeatures::none(mesh);
  return ModelFeatures::load(remembered, mesh);
}

ModelFeatures Recognition::features(const Mesh& mesh) const {
  const ModelFeatures both = drawn_features(mesh).with(seen_features(mesh));
  if (both.count() > 0) return both;
  std::error_code unknown;
  if (!remembered.empty() && !fs::exists(remembered, unknown)) {
    throw Error(ErrorCode::model,
                fmt::format("the model has neither texture nor vertex colours to recognize it by, and '{}' does not "
                            "exist: give a first pose or a guide",
                            remembered.string()));
  }
  return ModelFeatures(mesh);  // which says what is missing
}

ProposePoses Recognition::proposer(std::shared_ptr<const Mesh> mesh, const Camera& camera, bool at_once) const {
  const auto detector = std::make_shared<std::optional<detection::Detector>>();
  if (at_once) detector->emplace(features(*mesh), camera);
  return [=, how = *this](const ImageView& frame) mutable -> std::vector<detection::PoseCandidate> {
    if (mesh && !*detector) {
      try {
        detector->emplace(how.features(*mesh), camera);
      } catch (const Error& error) {
        if (error.code() != ErrorCode::model) throw;
      }
      mesh.reset();
    }
    return *detector ? (*detector)->detect(frame) : std::vector<detection::PoseCandidate>();
  };
}

std::optional<FrameResult> StartSearch::find(Tracker& tracker, const ImageView& frame, std::optional<double> time_s) {
  if (by_ == By::texture) return detection::start_at(tracker, propose_(frame), frame, time_s);
  if (by_ == By::sight) return detection::start_seen(tracker, propose_(frame), frame, time_s);
  if (seen_ > 0) {
    const FrameResult result = tracker.track(frame, time_s);
    if (detection::is_still_seen(result)) return result;
  }
  seen_ = 0;
  return detection::start_near(tracker, propose_(frame), frame, time_s);
}

FrameResult StartSearch::look(Tracker& tracker, const ImageView& frame, std::optional<double> time_s) {
  const auto begin = Clock::now();
  FrameResult result;
  result.reason = Reason::out_of_view;
  result.message = "not found yet";
  result.T_camera_object = T_guide_;
  if (const auto found = find(tracker, frame, time_s)) {
    result = *found;
    found_ = by_ != By::guide || ++seen_ == kSeenByGuide;
    if (!found_) {
      result.status = Status::lost;
      result.reason = Reason::not_surely_found;
      result.message = "seen; the next frames have to confirm it";
    }
  }
  result.ms.total = milliseconds_since(begin);
  return result;
}

void LossSearch::look(Tracker& tracker, const ImageView& frame, double time_s, FrameResult& result) {
  lost_ = result.status == Status::lost ? lost_ + 1 : 0;
  if (lost_ == 0 || lost_ % 2 != 0) return;
  const auto begin = Clock::now();
  const double tracked_ms = result.ms.total;
  if (const auto found = detection::start_at(tracker, propose_(frame), frame, time_s)) {
    result = *found;
    lost_ = 0;
  }
  result.ms.total = tracked_ms + milliseconds_since(begin);
}

Memory::Memory(const Mesh& mesh, const Camera& camera, const Recognition& how)
    : path_(how.remembered),
      learner_(mesh, camera, how.drawn_features(mesh), how.seen_features(mesh)),
      textured_(mesh.has_appearance()) {
  require_writable(path_);
}

bool Memory::look(const ImageView& frame, const FrameResult& result) {
  sure_ = textured_ || (sure_ && result.status == Status::held);
  const bool learned = sure_ && learner_.look(frame, result);
  changed_ = changed_ || learned;
  return learned;
}

bool Memory::save() {
  if (!changed_) return false;
  learner_.seen().save(path_);
  changed_ = false;
  return true;
}

std::optional<std::string> Memory::doubt() const {
  std::error_code unknown;
  if (changed_ || fs::exists(path_, unknown)) return {};
  return fmt::format("nothing is learned of the object and '{}' is not written: {}", path_.string(),
                     textured_ ? "the model's texture tells every side that was seen"
                               : "no frame shows it held, with its outline clear all round and enough marks on it");
}

}  // namespace holdfast::app
