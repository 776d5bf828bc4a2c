#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/detection.hpp"
#include "holdfast/device.hpp"
#include "holdfast/tracker.hpp"

namespace holdfast::app {

/// Proposes poses from which the tracker may start.
using ProposePoses = std::function<std::vector<detection::PoseCandidate>(const ImageView& frame)>;

/// How a model is recognized by its texture.
struct Recognition {
  std::filesystem::path views;       ///< file of its features; empty: in the cache folder
  std::filesystem::path remembered;  ///< file of features that frames have shown; empty: none
  DeviceOptions options;             ///< with the cache folder
  bool quiet = false;                ///< says nothing while they are made

  /// The model's features, from the file `views`, where they are kept if one is given, else from the cache folder,
  /// where a file that cannot be used or written only costs making them again; none of a model without a look. Throws
  /// as detection::ModelFeatures.
  detection::ModelFeatures drawn_features(const Mesh& mesh) const;
  /// Those that are remembered; none where there is no such file yet. Throws as detection::ModelFeatures::load().
  detection::ModelFeatures seen_features(const Mesh& mesh) const;
  /// Both. Throws Error(model) where there are none.
  detection::ModelFeatures features(const Mesh& mesh) const;
  /// Finds it by them. They are made at once, or when they are first wanted: a model that has none is then looked for
  /// in vain.
  ProposePoses proposer(std::shared_ptr<const Mesh> mesh, const Camera& camera, bool at_once) const;
};

/// Looks for an object that was never seen yet, in every frame until it is found.
class StartSearch {
 public:
  /// Poses are proposed by the model's texture, by features that frames have shown of it, or by edges near a guide:
  /// about as the object will be held, and it must be seen in three frames in a row.
  enum class By { texture, sight, guide };
  /// `T_guide`: the guide, or any pose.
  StartSearch(ProposePoses propose, By by, const Pose& T_guide = Pose::Identity())
      : propose_(std::move(propose)), by_(by), T_guide_(T_guide) {}

  bool found() const { return found_; }
  /// Forgets that it was found.
  void begin() {
    found_ = false;
    seen_ = 0;
  }
  /// The frame's result: held, and the tracker goes on from there, or lost and not found yet.
  FrameResult look(Tracker& tracker, const ImageView& frame, std::optional<double> time_s);

 private:
  std::optional<FrameResult> find(Tracker& tracker, const ImageView& frame, std::optional<double> time_s);

  ProposePoses propose_;
  By by_;
  Pose T_guide_;
  int seen_ = 0;  ///< frames in a row
  bool found_ = false;
};

/// Looks for an object that the tracker has lost, in every second frame, from the second on. What is held never waits.
class LossSearch {
 public:
  explicit LossSearch(ProposePoses propose) : propose_(std::move(propose)) {}

  /// After the tracker has looked at a frame: where it has lost the object, `result` is what is found without it.
  void look(Tracker& tracker, const ImageView& frame, double time_s, FrameResult& result);

 private:
  ProposePoses propose_;
  std::int64_t lost_ = 0;  ///< frames in a row
};

/// Keeps in a file what frames show of the object, so that it is recognized next time.
class Memory {
 public:
  /// What `how.remembered` holds already is added to. Throws as Recognition::seen_features() and
  /// detection::SightLearner, Error(output) where the file cannot be written.
  Memory(const Mesh& mesh, const Camera& camera, const Recognition& how);

  /// After a frame since the object was first found: true where the frame has shown a side that was not known yet.
  /// Throws as detection::SightLearner::look().
  bool look(const ImageView& frame, const FrameResult& result);
  /// The next pose is known whatever was lost before.
  void begin() { sure_ = true; }
  /// Writes the file, where anything was learned since: true. Throws Error(output).
  bool save();
  /// Why there is no file after save(); nothing where there is one.
  std::optional<std::string> doubt() const;

 private:
  std::filesystem::path path_;
  detection::SightLearner learner_;
  bool textured_;
  bool sure_ = true;  ///< without texture one that was lost may be found turned into another of its symmetries
  bool changed_ = false;
};

}  // namespace holdfast::app
