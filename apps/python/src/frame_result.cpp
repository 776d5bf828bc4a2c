#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <limits>
#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "holdfast/tracker.hpp"
#include "values.hpp"

namespace holdfast {

inline bool is_sound(const RenderedView& view) {
  const std::size_t pixels = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  return view.width >= 0 && view.height >= 0 && view.rgba.size() == 4 * pixels && view.depth.size() == pixels;
}

}  // namespace holdfast

namespace holdfast::python {
namespace {

std::string text_of(const FrameResult& result) {
  const Eigen::Vector3d t = result.T_camera_object.translation();
  std::string text = result.status == Status::held ? "<FrameResult held" : "<FrameResult lost";
  text += " at [" + std::to_string(t.x()) + ", " + std::to_string(t.y()) + ", " + std::to_string(t.z()) + "] m";
  return text + (result.message.empty() ? ">" : ": " + result.message + ">");
}

/// The library's is zero where nothing tells the pose, which looks like certainty where deviations are taken of it.
Matrix6 covariance_of(const FrameResult& result) {
  Matrix6 covariance = result.covariance;
  if (covariance.isZero(0)) covariance.diagonal().setConstant(std::numeric_limits<double>::infinity());
  return covariance;
}

/// The text that a kind of evidence prints as.
template <class Evidence>
std::string evidence_text(const char* kind, const Evidence& evidence, const std::string& figures) {
  if (!evidence.asked) return fmt::format("<{} not asked>", kind);
  return fmt::format("<{} {}>", kind, figures);
}

const char* held_by(bool holds) { return holds ? "enough alone" : "not enough alone"; }

void bind_enums(nb::module_& module) {
  nb::enum_<PixelFormat>(module, "PixelFormat", "Byte layouts of frames.")
      .value("bgr8", PixelFormat::bgr8, "HxWx3, as OpenCV reads pictures.")
      .value("rgb8", PixelFormat::rgb8, "HxWx3.")
      .value("rgba8", PixelFormat::rgba8, "HxWx4, alpha ignored.")
      .value("grey8", PixelFormat::grey8, "HxW.")
      .value("nv12", PixelFormat::nv12, "(3/2 H)xW: Y, then U and V interleaved at half the size.")
      .value("yuyv", PixelFormat::yuyv, "HxWx2.")
      .value("bgra8", PixelFormat::bgra8, "HxWx4, alpha ignored: OpenCV's order, and that of most screen grabbers.");
  nb::enum_<Status>(module, "Status", "Whether the object is followed.")
      .value("held", Status::held, "The pose is found in this frame.")
      .value("lost", Status::lost, "The pose is a guess; the next frames look for the object.");
  nb::enum_<Reason>(module, "Reason", "Why an object is lost, or hard to hold.")
      .value("none", Reason::none, "All is well.")
      .value("out_of_view", Reason::out_of_view, "It is not in the picture, or not found in it.")
      .value("occluded", Reason::occluded, "Something hides most of it.")
      .value("too_fast", Reason::too_fast, "It moves faster than can be followed, or is blurred by it.")
      .value("no_evidence", Reason::no_evidence, "Neither texture nor a contour that stands out.")
      .value("low_evidence", Reason::low_evidence, "Less agrees than should, and nothing seen in front explains it.")
      .value("ambiguous", Reason::ambiguous, "Another pose fits as well, or a turn does not show.")
      .value("not_surely_found", Reason::not_surely_found, "Lost before, and not surely found again.")
      .value("light_changed", Reason::light_changed, "The light has changed.")
      .def(
          "__bool__", [](Reason reason) { return reason != Reason::none; }, "False for Reason.none only.");
  nb::enum_<PixelClass>(module, "PixelClass", nb::is_arithmetic(), "What became of a pixel: values of Tracker.mask().")
      .value("not_visible", PixelClass::not_visible, "The object does not cover it.")
      .value("unusable", PixelClass::unusable,
             "Covered, but of unknown texture, at the silhouette or outside the frame.")
      .value("no_gradient", PixelClass::no_gradient, "Too little gradient in the rendered view or the frame.")
      .value("rejected_angle", PixelClass::rejected_angle, "Gradients point apart.")
      .value("rejected_magnitude", PixelClass::rejected_magnitude, "Gradients differ too much.")
      .value("rejected_vote", PixelClass::rejected_vote, "Passed, but most of its neighbourhood did not.")
      .value("used", PixelClass::used, "Decided the pose.");
}

void bind_evidence(nb::module_& module) {
  nb::class_<TextureEvidence> texture_class(module, "TextureEvidence", "What the texture said of the pose.");
  make_value(texture_class, &TextureEvidence::asked, &TextureEvidence::holds, &TextureEvidence::visible_pixels,
             &TextureEvidence::usable_pixels, &TextureEvidence::gradient_pixels, &TextureEvidence::passed_pixels,
             &TextureEvidence::used_pixels, &TextureEvidence::rows, &TextureEvidence::residual,
             &TextureEvidence::correlation);
  texture_class.def_ro("asked", &TextureEvidence::asked, "It was compared on the finest level.")
      .def_ro("holds", &TextureEvidence::holds, "It would be enough alone to hold the object.")
      .def_ro("visible_pixels", &TextureEvidence::visible_pixels, "Of the rendered object inside the frame.")
      .def_ro("usable_pixels", &TextureEvidence::usable_pixels,
              "Of those looked at: known texture, off the silhouette.")
      .def_ro("gradient_pixels", &TextureEvidence::gradient_pixels, "Of these, with a gradient.")
      .def_ro("passed_pixels", &TextureEvidence::passed_pixels, "Of these, passing the occlusion tests.")
      .def_ro("used_pixels", &TextureEvidence::used_pixels, "Of these, those that decided the pose.")
      .def_ro("rows", &TextureEvidence::rows, "Constraints.")
      .def_ro("residual", &TextureEvidence::residual,
              "Root of the weighted mean squared residual, intensity in [0, 1].")
      .def_ro("correlation", &TextureEvidence::correlation, "Of the rendered view and the frame, [-1, 1].")
      .def_prop_ro("inlier_ratio", &TextureEvidence::inlier_ratio, "Share of the gradient pixels that agree.")
      .def("__repr__", [](const TextureEvidence& e) {
        return evidence_text(
            "TextureEvidence", e,
            fmt::format("{}: {} of {} gradient pixels used, residual {:.3f}, correlation {:.3f}", held_by(e.holds),
                        e.used_pixels, e.gradient_pixels, e.residual, e.correlation));
      });
  nb::class_<ContourEvidence> contour_class(module, "ContourEvidence", "What the contour said of the pose.");
  make_value(contour_class, &ContourEvidence::asked, &ContourEvidence::holds, &ContourEvidence::visible_pixels,
             &ContourEvidence::lines, &ContourEvidence::telling_lines, &ContourEvidence::near_lines,
             &ContourEvidence::agreement, &ContourEvidence::residual);
  contour_class.def_ro("asked", &ContourEvidence::asked, "It was compared on the finest level.")
      .def_ro("holds", &ContourEvidence::holds, "It would be enough alone to hold the object.")
      .def_ro("visible_pixels", &ContourEvidence::visible_pixels, "Of the frame, inside the silhouette.")
      .def_ro("lines", &ContourEvidence::lines, "Across the contour, inside the frame.")
      .def_ro("telling_lines", &ContourEvidence::telling_lines, "Of these, where the colours of both sides differ.")
      .def_ro("near_lines", &ContourEvidence::near_lines, "Of these, with the edge next to the contour.")
      .def_ro("agreement", &ContourEvidence::agreement, "Of colours with the contour over the near lines, [-1, 1].")
      .def_ro("residual", &ContourEvidence::residual, "Root of the weighted mean squared distance of edges, pixels.")
      .def_prop_ro("score", &ContourEvidence::score, "Agreement times the share of lines whose edge is there.")
      .def("__repr__", [](const ContourEvidence& e) {
        return evidence_text("ContourEvidence", e,
                             fmt::format("{}: {} of {} lines near, agreement {:.2f}, residual {:.2f} px",
                                         held_by(e.holds), e.near_lines, e.lines, e.agreement, e.residual));
      });
  nb::class_<EdgeEvidence> edges_class(module, "EdgeEvidence", "What the model's edges said of the pose.");
  make_value(edges_class, &EdgeEvidence::asked, &EdgeEvidence::lines, &EdgeEvidence::near_lines, &EdgeEvidence::score,
             &EdgeEvidence::residual);
  edges_class.def_ro("asked", &EdgeEvidence::asked, "They were compared on the finest level.")
      .def_ro("lines", &EdgeEvidence::lines, "Across edges of the model, inside the frame.")
      .def_ro("near_lines", &EdgeEvidence::near_lines, "Of these, with the frame's edge next to the model's.")
      .def_ro("score", &EdgeEvidence::score, "Share of near lines beyond what chance makes, at most 1.")
      .def_ro("residual", &EdgeEvidence::residual, "Root of the weighted mean squared distance of edges, pixels.")
      .def("__repr__", [](const EdgeEvidence& e) {
        return evidence_text("EdgeEvidence", e,
                             fmt::format("{} of {} lines near, score {:.2f}, residual {:.2f} px", e.near_lines, e.lines,
                                         e.score, e.residual));
      });
  nb::class_<SnapshotEvidence> snapshot_class(
      module, "SnapshotEvidence", "What the pixels of a model without appearance said, beside an earlier frame's.");
  make_value(snapshot_class, &SnapshotEvidence::asked, &SnapshotEvidence::holds, &SnapshotEvidence::gradient_pixels,
             &SnapshotEvidence::used_pixels, &SnapshotEvidence::correlation);
  snapshot_class.def_ro("asked", &SnapshotEvidence::asked, "They were compared on the finest level.")
      .def_ro("holds", &SnapshotEvidence::holds, "They would be enough to hold the object.")
      .def_ro("gradient_pixels", &SnapshotEvidence::gradient_pixels, "Looked at, with a gradient in the earlier frame.")
      .def_ro("used_pixels", &SnapshotEvidence::used_pixels, "Of these, those that agree.")
      .def_ro("correlation", &SnapshotEvidence::correlation, "Of both frames over these, [-1, 1].")
      .def("__repr__", [](const SnapshotEvidence& e) {
        return evidence_text("SnapshotEvidence", e,
                             fmt::format("{}: {} of {} gradient pixels used, correlation {:.3f}", held_by(e.holds),
                                         e.used_pixels, e.gradient_pixels, e.correlation));
      });
}

}  // namespace

void bind_frame_result(nb::module_& module) {
  bind_enums(module);
  bind_evidence(module);
  nb::class_<StageTimes> times_class(module, "StageTimes", "Milliseconds of one frame, by stage.");
  make_value(times_class, &StageTimes::upload, &StageTimes::render, &StageTimes::filter, &StageTimes::search,
             &StageTimes::solve, &StageTimes::contour, &StageTimes::total);
  times_class.def_ro("upload", &StageTimes::upload, "The frame to the device.")
      .def_ro("render", &StageTimes::render, "Drawing the model.")
      .def_ro("filter", &StageTimes::filter, "Blurring both images.")
      .def_ro("search", &StageTimes::search, "The coarse search for a shift.")
      .def_ro("solve", &StageTimes::solve, "Occlusion tests, constraints and solutions.")
      .def_ro("contour", &StageTimes::contour, "Of solve, contour and edges.")
      .def_ro("total", &StageTimes::total, "The whole frame.");

  nb::class_<FrameResult> result_class(module, "FrameResult", "Where the object is in a frame, and how sure that is.");
  make_value(result_class, &FrameResult::T_camera_object, &FrameResult::status, &FrameResult::reason,
             &FrameResult::message, &FrameResult::texture, &FrameResult::contour, &FrameResult::edges,
             &FrameResult::snapshot, &FrameResult::iterations, &FrameResult::covariance, &FrameResult::information,
             &FrameResult::ms);
  result_class
      .def_prop_ro(
          "T_camera_object", [](const FrameResult& result) { return pose_array(result.T_camera_object); },
          "Pose, 4x4: maps points of the object's frame to the camera's (x right, y down, z forward), metres. A guess "
          "where the object is lost.",
          kNewArray)
      .def_ro("status", &FrameResult::status, "Status.held or Status.lost.")
      .def_prop_ro(
          "held", [](const FrameResult& result) { return result.status == Status::held; },
          "Whether status is Status.held.")
      .def_ro("reason", &FrameResult::reason, "Why the object is lost or hard to hold; Reason.none: all is well.")
      .def_ro("message", &FrameResult::message, "The same in words; '' when all is well.")
      .def_ro("texture", &FrameResult::texture, nb::rv_policy::reference_internal, "What the texture said.")
      .def_ro("contour", &FrameResult::contour, nb::rv_policy::reference_internal, "What the contour said.")
      .def_ro("edges", &FrameResult::edges, nb::rv_policy::reference_internal, "What the model's edges said.")
      .def_ro("snapshot", &FrameResult::snapshot, nb::rv_policy::reference_internal,
              "What an earlier frame said, where the model has no appearance.")
      .def_prop_ro("visible_pixels", &FrameResult::visible_pixels, "Of the frame that the object covers.")
      .def_ro("iterations", &FrameResult::iterations, "Solved systems, all levels.")
      .def_prop_ro(
          "covariance", [](const FrameResult& result) { return matrix_array<Numpy6x6>(covariance_of(result)); },
          "6x6, of the twist (v, w), metres and radians, in T_true = T_camera_object exp((v, w)): object axes, "
          "rotation "
          "about the object's origin. Where nothing tells the pose, the diagonal is infinite and the rest zero.",
          kNewArray)
      .def_prop_ro(
          "information", [](const FrameResult& result) { return matrix_array<Numpy6x6>(result.information); },
          "Inverse of covariance, 6x6. Zero where nothing tells the pose.", kNewArray)
      .def_ro("ms", &FrameResult::ms, "Milliseconds, by stage.")
      .def("__repr__", &text_of);

  nb::class_<RenderedView> view_class(module, "RenderedView", "The model drawn as a frame was compared with it.");
  make_value(view_class, &RenderedView::width, &RenderedView::height, &RenderedView::rgba, &RenderedView::depth,
             &RenderedView::T_camera_object);
  view_class
      .def_prop_ro(
          "rgba",
          [](const RenderedView& view) {
            return owned_array<Numpy<std::uint8_t, nb::shape<-1, -1, 4>>>(
                view.rgba, {static_cast<std::size_t>(view.height), static_cast<std::size_t>(view.width), 4});
          },
          "HxWx4 uint8; alpha 0 where nothing or nothing known is drawn.", kNewArray)
      .def_prop_ro(
          "depth",
          [](const RenderedView& view) {
            return owned_array<Numpy<float, nb::shape<-1, -1>>>(
                view.depth, {static_cast<std::size_t>(view.height), static_cast<std::size_t>(view.width)});
          },
          "HxW float32, metres along the optical axis; 0 where nothing is drawn.", kNewArray)
      .def_prop_ro(
          "T_camera_object", [](const RenderedView& view) { return pose_array(view.T_camera_object); },
          "Pose that it is drawn at, 4x4.", kNewArray)
      .def("__repr__", [](const RenderedView& view) {
        return fmt::format("<RenderedView of {}x{} pixels>", view.width, view.height);
      });
}

}  // namespace holdfast::python
