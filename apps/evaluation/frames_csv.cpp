#include <fmt/core.h>

#include <algorithm>
#include <sstream>

#include "evaluation/report.hpp"
#include "track/output_file.hpp"

namespace holdfast::evaluation {
namespace {

constexpr double kMillimetres = 1e3;

/// Empty where the distance was not computed.
std::string optional_mm(double metres) { return metres < 0 ? "" : fmt::format("{:.4f}", kMillimetres * metres); }

}  // namespace

void write_frames_csv(const std::filesystem::path& path, const std::vector<Evaluation>& evaluations) {
  std::ostringstream out;
  out << "sequence,step,offset,frame,visible,counted,failed,status,reason,texture_holds,contour_holds,"
         "snapshot_holds,error_mm,error_x_mm,error_y_mm,"
         "error_z_mm,error_deg,add_mm,add_s_mm,correlation,residual,visible_pixels,usable_pixels,gradient_pixels,"
         "passed_pixels,used_pixels,rows,contour_lines,contour_near_lines,contour_score,contour_residual,edge_lines,"
         "edge_near_lines,edge_score,edge_residual,snapshot_gradient_pixels,snapshot_used_pixels,snapshot_correlation,"
         "iterations,"
         "mask_used,mask_used_on_occluder,ms,ms_upload,ms_render,ms_filter,"
         "ms_search,ms_solve,ms_contour";
  // Upper triangle of FrameResult::information, row by row, and the squared error of the pose that it makes.
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) out << fmt::format(",information_{}{}", row, column);
  }
  out << ",normalized_error_squared";
  for (const char* whose : {"true", "estimated"}) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        out << fmt::format(",{}_{}{}", whose, row, column);
      }
    }
  }
  out << '\n';
  for (const Evaluation& evaluation : evaluations) {
    for (const FrameRecord& record : evaluation.records) {
      const FrameResult& result = record.result;
      std::string reason = result.message;
      std::replace(reason.begin(), reason.end(), ',', ';');
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      out << fmt::format("{},{},{},{},{:.4f},{:d},{:d},{},{},{:d},{:d},{:d}", evaluation.sequence, record.step,
                         record.offset, record.frame, record.visible, record.counted, record.failed,
                         result.status == Status::held ? "held" : "lost", reason, result.texture.holds,
                         result.contour.holds, result.snapshot.holds);
      out << fmt::format(",{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{}", kMillimetres * record.error.distance(),
                         kMillimetres * record.error.translation.x(), kMillimetres * record.error.translation.y(),
                         kMillimetres * record.error.translation.z(), to_degrees(record.error.rotation),
                         optional_mm(record.add), optional_mm(record.add_s));
      const TextureEvidence& texture = result.texture;
      out << fmt::format(",{:.5f},{:.6f},{},{},{},{},{},{}", texture.correlation, texture.residual,
                         result.visible_pixels(), texture.usable_pixels, texture.gradient_pixels, texture.passed_pixels,
                         texture.used_pixels, texture.rows);
      const ContourEvidence& contour = result.contour;
      const EdgeEvidence& edges = result.edges;
      out << fmt::format(",{},{},{:.5f},{:.4f},{},{},{:.5f},{:.4f},{},{},{:.5f},{}", contour.lines, contour.near_lines,
                         contour.score(), contour.residual, edges.lines, edges.near_lines, edges.score, edges.residual,
                         result.snapshot.gradient_pixels, result.snapshot.used_pixels, result.snapshot.correlation,
                         result.iterations);
      out << (record.occluder ? fmt::format(",{},{}", record.occluder->used, record.occluder->on_occluder) : ",,");
      out << fmt::format(",{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f}", result.ms.total, result.ms.upload,
                         result.ms.render, result.ms.filter, result.ms.search, result.ms.solve, result.ms.contour);
      const Matrix6& information = result.information;
      for (int row = 0; row < 6; ++row) {
        for (int column = row; column < 6; ++column) out << fmt::format(",{:.15g}", information(row, column));
      }
      out << fmt::format(",{:.6g}",
                         normalized_error_squared(record.T_camera_object_true, result.T_camera_object, information));
      for (const Pose* pose : {&record.T_camera_object_true, &result.T_camera_object}) {
        for (int row = 0; row < 3; ++row) {
          for (int column = 0; column < 4; ++column) {
            out << fmt::format(",{:.9g}", pose->matrix()(row, column));
          }
        }
      }
      out << '\n';
    }
  }
  app::write_whole(path, out.str());
}

}  // namespace holdfast::evaluation
