#include "edges/edge_modality.hpp"

#include <algorithm>
#include <cmath>

#include "edges/edge_sums.hpp"

namespace holdfast {
namespace {

constexpr std::size_t kMostSamples = 800, kLeastLines = 12;
/// Lines are laid anew when the pose has moved by so many pixels of the level since.
constexpr double kRelaid = 2;
/// Neighbours on either side along a chain that an edge should go on at, within so many pixels.
constexpr int kNeighbours = 4;
constexpr double kGoesOn = 1;
/// Weight of an edge with which none of its neighbours goes on, and that one with all of them has.
constexpr double kAlone = 0.1;
/// Weight of an edge that goes on along the model's.
constexpr float kCoherent = 0.4F;
/// Weight of what is no edge of the model on a line.
constexpr double kOther = 0.2;
/// Pixels of the level within which a line's most telling edge is next to the model's.
constexpr double kNear = 1.5;
/// Least weight of all edges of a line that make a row, and depth of a point in front of the camera, metres.
constexpr double kLeastWeight = 1e-6, kLeastDepth = 1e-6;
/// Pixels of the level beside an edge within which another line that goes along with it stands for it.
constexpr double kBeside = 6;
/// Score from which on edges are what their residuals say, and reliability that is always left.
constexpr double kReliableScore = 0.8, kLeastReliability = 0.01;
/// Weight of a new frame in what edges look like.
constexpr float kMemory = 0.25F;

}  // namespace

double EdgeTerms::score() const {
  constexpr double kChance = 2 * kNear / (2 * HF_EDGE_REACH + 1);
  return lines > 0 ? (near / lines - kChance) / (1 - kChance) : 0;
}

EdgeModality::EdgeModality(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                           const Mesh& mesh, DepthView& shape, DeviceImage& image)
    : levels_(levels),
      extent_(extent),
      samples_(model_edges(mesh, kMostSamples)),
      shape_(shape),
      image_(image),
      candidates_(device, levels) {
  edges_.reserve(samples_.size());
  support_.reserve(EdgeCandidates::kMostLines * HF_EDGE_CANDIDATES);
}

EdgeMemory EdgeModality::no_memory() const {
  EdgeMemory memory;
  memory.looks.resize(samples_.size());
  return memory;
}

bool EdgeModality::look(const Pose& T_camera_object, int level, const EdgeMemory& memory) {
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  if (level == level_ && corner_motion(extent_, camera, T_lines_, T_camera_object) <= kRelaid) return true;
  level_ = -1;
  if (!shape_.draw(T_camera_object, level, 0.5 * kRelaid)) return false;
  T_lines_ = shape_.T_drawn();
  visible_edges(samples_, T_lines_, camera, shape_.drawn(), kBehind * extent_.radius, EdgeCandidates::kMostLines,
                edges_);
  candidates_.find(image_, level, edges_, memory);
  support();
  level_ = level;
  return true;
}

/// Weighs candidates by how they go on along the model's edge.
void EdgeModality::support() {
  support_.assign(edges_.size() * HF_EDGE_CANDIDATES, 0.0F);
  const auto chain = [&](std::size_t line) { return samples_[static_cast<std::size_t>(edges_[line].sample)].chain; };
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    for (std::size_t j = 0; j < HF_EDGE_CANDIDATES; ++j) {
      const EdgeCandidate& candidate = candidates_.of(i)[j];
      if (candidate.weight <= 0) break;
      double sum = 0, count = 0;
      for (int n = -kNeighbours; n <= kNeighbours; ++n) {
        const auto other = static_cast<std::ptrdiff_t>(i) + n;
        if (n == 0 || other < 0 || other >= static_cast<std::ptrdiff_t>(edges_.size())) continue;
        if (chain(static_cast<std::size_t>(other)) != chain(i)) continue;
        double best = 0;
        for (const EdgeCandidate& next : candidates_.of(static_cast<std::size_t>(other))) {
          const double apart = static_cast<double>(next.offset - candidate.offset) / kGoesOn;
          best = std::max(best, static_cast<double>(next.weight) * std::exp(-0.5 * apart * apart));
        }
        sum += best;
        count += 1;
      }
      const double goes_on = count > 0 ? sum / count : 0;
      support_[i * HF_EDGE_CANDIDATES + j] =
          static_cast<float>(static_cast<double>(candidate.weight) * (kAlone + (1 - kAlone) * goes_on));
    }
  }
}

double EdgeModality::displacement(const VisibleEdge& edge, const Pose& D, const Camera& camera) const {
  return edge.normal.dot(camera.project(D * edge.p_camera) - edge.pixel);
}

double EdgeModality::usual_offset(const VisibleEdge& edge, int level, const EdgeMemory& memory) const {
  if (memory.looks.empty()) return 0;
  const EdgeMemory::Look& look = memory.looks[static_cast<std::size_t>(edge.sample)];
  return look.faces == edge.faces ? static_cast<double>(look.offset) / (1 << level) : 0;
}

EdgeModality::Found EdgeModality::found_on(std::size_t line, double expected, double window) const {
  double weight = 0, offset = 0, most = 0, best = 1e9;
  for (std::size_t j = 0; j < HF_EDGE_CANDIDATES; ++j) {
    const EdgeCandidate& candidate = candidates_.of(line)[j];
    if (candidate.weight <= 0) break;
    const double supported = static_cast<double>(support_[line * HF_EDGE_CANDIDATES + j]);
    const double off = static_cast<double>(candidate.offset) - expected;
    if (supported > most) {
      most = supported;
      best = off;
    }
    const double w = supported * std::exp(-0.5 * off * off / (window * window));
    weight += w;
    offset += w * off;
  }
  if (weight < kLeastWeight) return {0, 0, std::abs(best) < kNear};
  // A row that may be of another edge loses information twice: by its weight and by what that weight is not sure of.
  const double chance = weight / (weight + kOther);
  return {chance * chance, offset / weight, std::abs(best) < kNear};
}

EdgeTerms EdgeModality::linearize(const Pose& T_camera_object, int level, double window, const EdgeMemory& memory) {
  EdgeTerms terms;
  if (!look(T_camera_object, level, memory) || edges_.size() < kLeastLines) return terms;
  terms.found = true;
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  const Pose D = renormalized(T_camera_object * T_lines_.inverse());
  EdgeSums sums({T_lines_ * extent_.p_object_center, extent_.radius});
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    if ((D * edge.p_camera).z() < kLeastDepth) continue;
    const Found found = found_on(i, displacement(edge, D, camera) + usual_offset(edge, level, memory), window);
    terms.lines += 1;
    terms.near += found.near ? 1 : 0;
    if (found.weight <= 0) continue;
    sums.add(edge, D, camera, samples_[static_cast<std::size_t>(edge.sample)].chain, found.weight, found.offset);
  }
  if (sums.rows() < 6) return terms;
  terms.variance = sums.variance();
  terms.equations = sums.equations(T_lines_);
  // Print beside an edge and clutter behind it put edges where there are none.
  const double reliability = std::clamp(terms.score() / kReliableScore, kLeastReliability, 1.0);
  terms.equations *= reliability * reliability;
  return terms;
}

double EdgeModality::coherence(const Pose& T_camera_object, int level) {
  if (!look(T_camera_object, level, {}) || edges_.size() < kLeastLines) return 0;
  double coherent = 0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const auto line = support_.begin() + static_cast<std::ptrdiff_t>(i * HF_EDGE_CANDIDATES);
    if (*std::max_element(line, line + HF_EDGE_CANDIDATES) > kCoherent) coherent += 1;
  }
  return coherent / static_cast<double>(edges_.size());
}

void EdgeModality::learn(const Pose& T_camera_object, int finest, EdgeMemory& memory) {
  if (!look(T_camera_object, finest, memory)) return;
  const Camera& camera = levels_[static_cast<std::size_t>(finest)].camera;
  const Pose D = renormalized(T_camera_object * T_lines_.inverse());
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    EdgeMemory::Look& look = memory.looks[static_cast<std::size_t>(edge.sample)];
    const bool known = look.faces == edge.faces;
    const double expected = displacement(edge, D, camera) + usual_offset(edge, finest, memory);
    const EdgeCandidate *nearest = nullptr, *beside = nullptr;
    double distance = kNear, support = 0;
    for (std::size_t j = 0; j < HF_EDGE_CANDIDATES; ++j) {
      const EdgeCandidate& candidate = candidates_.of(i)[j];
      if (candidate.weight <= 0) break;
      const double off = static_cast<double>(candidate.offset) - expected;
      if (std::abs(off) < distance) {
        distance = std::abs(off);
        nearest = &candidate;
      }
      const double supported = static_cast<double>(support_[i * HF_EDGE_CANDIDATES + j]);
      if (std::abs(off) < kBeside && off * edge.outward <= 0 && supported > support) {
        support = supported;
        beside = &candidate;
      }
    }
    const auto off_model = [&](const EdgeCandidate& candidate) {
      return (candidate.offset - static_cast<float>(expected)) * static_cast<float>(1 << finest);
    };
    if (nearest != nullptr) {
      look.step += (known ? kMemory : 1.0F) * (nearest->step - look.step);
      if (!known) look.offset = memory.off_model ? off_model(*nearest) : 0;
    } else if (!known && memory.off_model && beside != nullptr) {
      look.step = beside->step;
      look.offset = off_model(*beside);
    } else {
      continue;
    }
    look.faces = static_cast<std::uint8_t>(edge.faces);
  }
}

}  // namespace holdfast
