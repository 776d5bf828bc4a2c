#include "simulation/sequence_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"

namespace holdfast::simulation {
namespace {

namespace fs = std::filesystem;

// A text file that says so when it cannot be written.
class Lines {
 public:
  explicit Lines(const fs::path& path) : path_(path), stream_(path) { check(); }
  void add(const std::string& line) {
    stream_ << line << '\n' << std::flush;
    check();
  }

 private:
  void check() const {
    if (!stream_) {
      throw Error(ErrorCode::output,
                  path_.string() + ": cannot be written; check the folder's permissions and free space");
    }
  }
  fs::path path_;
  std::ofstream stream_;
};

void write_bytes(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  stream.flush();
  if (!stream) {
    throw Error(ErrorCode::output,
                path.string() + ": cannot be written; check the folder's permissions and free space");
  }
}

std::vector<std::uint8_t> png(const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", image, bytes);
  return bytes;
}

std::string pose_line(const Pose& pose) {
  std::string line;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      line += fmt::format("{}{:.9g}", line.empty() ? "" : " ", pose.matrix()(row, column));
    }
  }
  return line;
}

// Makes a folder that holds nothing of an earlier, perhaps longer, sequence.
void prepare(const fs::path& folder, bool overwrite) {
  std::error_code error;
  if (fs::exists(folder / "poses_gt.txt", error) || fs::exists(folder / "frames", error)) {
    if (!overwrite) {
      throw Error(ErrorCode::output,
                  folder.string() + ": holds a sequence already; name another folder or add --overwrite");
    }
    for (const char* name : {"frames", "masks", "poses_gt.txt", "visible.txt", "K.txt", "camera.yml"}) {
      fs::remove_all(folder / name, error);
    }
  }
  fs::create_directories(folder / "frames", error);
  if (error) {
    throw Error(ErrorCode::output,
                folder.string() + ": the folder cannot be made (" + error.message() + "); name another");
  }
}

}  // namespace

int write_sequence(const Sequence& sequence, const fs::path& folder, const SequenceFileOptions& options,
                   const std::function<void(int, const SimulatedFrame&)>& after_frame) {
  prepare(folder, options.overwrite);
  if (options.masks) fs::create_directories(folder / "masks");
  const Camera& camera = sequence.camera();
  Lines(folder / "K.txt").add(fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}", camera.fx, camera.fy, camera.cx, camera.cy));
  if (camera.has_distortion()) io::save_camera(folder / "camera.yml", camera);
  Lines poses(folder / "poses_gt.txt");
  Lines visible(folder / "visible.txt");

  struct Drawn {
    SimulatedFrame frame;
    std::vector<std::uint8_t> image, mask;
  };
  const auto draw = [&](int i) {
    Drawn drawn{sequence.make(i), {}, {}};
    drawn.image = drawn.frame.jpeg.empty() ? png(drawn.frame.image) : drawn.frame.jpeg;
    if (options.masks) drawn.mask = png(drawn.frame.occluder_mask);
    return drawn;
  };
  const std::string extension = sequence.options().sensor.jpeg_quality > 0 ? ".jpg" : ".png";
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const int threads = options.threads > 0 ? options.threads : static_cast<int>(cores);
  for (int first = 0; first < sequence.size(); first += threads) {
    if (options.is_interrupted && options.is_interrupted()) return first;
    std::vector<std::future<Drawn>> batch;
    for (int i = first; i < std::min(first + threads, sequence.size()); ++i) {
      batch.push_back(std::async(threads > 1 ? std::launch::async : std::launch::deferred, draw, i));
    }
    for (std::size_t k = 0; k < batch.size(); ++k) {
      const int i = first + static_cast<int>(k);
      const Drawn drawn = batch[k].get();
      write_bytes(folder / "frames" / fmt::format("{:06d}{}", i, extension), drawn.image);
      if (options.masks) write_bytes(folder / "masks" / fmt::format("{:06d}.png", i), drawn.mask);
      poses.add(pose_line(drawn.frame.T_camera_object));
      visible.add(fmt::format("{:.4f}", drawn.frame.visible_share));
      if (after_frame) after_frame(i, drawn.frame);
    }
  }
  return sequence.size();
}

}  // namespace holdfast::simulation
