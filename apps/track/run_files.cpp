#include "track/run_files.hpp"

#include <exception>
#include <functional>

namespace holdfast::app {

std::vector<std::filesystem::path> OutputPaths::given() const {
  std::vector<std::filesystem::path> paths;
  for (const std::filesystem::path& path : {poses, tum, json, overlay, contact_sheet}) {
    if (!path.empty()) {
      paths.push_back(path);
    }
  }
  return paths;
}

RunFiles::RunFiles(const OutputPaths& paths, const Mesh& mesh, const Camera& camera, double frame_rate,
                   std::optional<std::int64_t> expected_frames, const std::string& run)
    : paths_(paths) {
  // A path that cannot be written should not cost the others what they hold from an earlier run.
  for (const std::filesystem::path& path : paths.given()) {
    require_writable(path);
  }
  if (!paths.contact_sheet.empty()) {
    sheet_.emplace(paths.contact_sheet, paths.contact_frames, expected_frames);
  }
  if (!paths.overlay.empty() || sheet_) {
    overlay_.emplace(mesh, camera);
  }
  if (!paths.overlay.empty()) {
    video_.emplace(paths.overlay, overlay_->overlay_size(), frame_rate);
  }
  if (!paths.poses.empty()) {
    csv_.emplace(paths.poses);
  }
  if (!paths.tum.empty()) {
    tum_.emplace(paths.tum);
  }
  if (!paths.json.empty()) {
    json_.emplace(paths.json, run);
  }
}

bool RunFiles::is_pictured(std::int64_t ordinal) const { return video_ || (sheet_ && sheet_->wants(ordinal)); }

void RunFiles::write(const TrackedFrame& tracked) {
  if (csv_) {
    csv_->write(tracked);
  }
  if (tum_) {
    tum_->write(tracked);
  }
  if (json_) {
    json_->write(tracked);
  }
  if (video_) {
    video_->write(overlay_->overlay_picture(tracked));
  }
  if (sheet_ && sheet_->wants(tracked.ordinal)) {
    sheet_->add(tracked, overlay_->outline_picture(tracked));
  }
}

void RunFiles::finish(const RunSummary& summary) {
  std::exception_ptr failure;
  const auto complete = [&](const std::filesystem::path& path, const std::function<void()>& step) {
    try {
      step();
    } catch (...) {
      incomplete_.push_back(path);
      failure = failure ? failure : std::current_exception();
    }
  };
  if (json_) {
    complete(paths_.json, [&] { json_->finish(summary); });
  }
  if (video_) {
    complete(paths_.overlay, [&] { video_->finish(); });
  }
  if (sheet_) {
    complete(paths_.contact_sheet, [&] { sheet_->finish(); });
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
}

}  // namespace holdfast::app
