#include "render/mesh_levels.hpp"

#include "render/simplification.hpp"

namespace holdfast {
namespace {

/// Fewer cost little as they are.
constexpr std::size_t kFewTriangles = 1000, kFewestTriangles = 100;
/// More are thinned out to so many first.
constexpr std::size_t kManyTriangles = 50000;
/// Triangles of a level, of those of the one before, per cent.
constexpr std::size_t kLevelShare = 71;
/// Of the mesh's radius.
constexpr double kMostDeviation = 0.02;

}  // namespace

std::vector<MeshLevel> mesh_levels(const Mesh& mesh, MeshAspect aspect) {
  std::vector<MeshLevel> levels;
  const bool looks = aspect == MeshAspect::appearance;
  if (mesh.triangles.size() < kFewTriangles || (looks && !mesh.colors.empty())) return levels;
  Simplification simplification(mesh, looks);
  const double most = kMostDeviation * mesh.radius();
  if (simplification.alive() > kManyTriangles) {
    simplification.thin_out_to(kManyTriangles, most);
    levels.push_back(simplification.level());
  }
  simplification.push_all();
  while (simplification.alive() >= 2 * kFewestTriangles) {
    const std::size_t before = simplification.alive();
    const bool reached = simplification.reduce_to(before * kLevelShare / 100, most);
    // What is left at the end of the way may still be worth a level.
    if (reached || simplification.alive() < before * 9 / 10) levels.push_back(simplification.level());
    if (!reached) break;
  }
  return levels;
}

}  // namespace holdfast
