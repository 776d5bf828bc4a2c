#include "benchmarks.hpp"

namespace holdfast::bench {

const Scene& Scenes::get(const SceneOptions& options) {
  const std::string key = std::to_string(options.width) + " " + std::to_string(options.height) + " " +
                          std::to_string(options.object_pixels) + " " + std::to_string(options.frames);
  std::unique_ptr<Scene>& scene = scenes_[key];
  if (!scene) scene = std::make_unique<Scene>(make_scene(options));
  return *scene;
}

}  // namespace holdfast::bench
