#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "support/files.hpp"
#include "video/camera_reader.hpp"
#include "video/frame_source.hpp"
#include "video/image_list.hpp"
#include "video/media_check.hpp"

namespace fs = std::filesystem;
using holdfast::ErrorCode;
using holdfast::app::CameraReader;
using holdfast::app::Frame;
using holdfast::app::FrameSource;
using holdfast::app::FrameSourceOptions;
using holdfast::app::image_damage;
using holdfast::app::list_images;
using holdfast::app::natural_less;
using holdfast::app::video_damage;
using holdfast::test::error_of;
using holdfast::test::read_file;
using holdfast::test::TemporaryFolder;

namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr int kLevelStep = 12;  // grey levels between successive frames: far above what compression changes

/// A picture that tells its number.
cv::Mat numbered_picture(int number, cv::Size size = {kWidth, kHeight}) {
  return cv::Mat(size, CV_8UC3, cv::Scalar::all(10 + kLevelStep * number));
}

int number_of(const cv::Mat& picture) {
  return static_cast<int>((cv::mean(picture)[0] - 10 + kLevelStep / 2.0) / kLevelStep);
}

void write_picture(const fs::path& path, int number, cv::Size size = {kWidth, kHeight}) {
  REQUIRE(cv::imwrite(path.string(), numbered_picture(number, size)));
}

void write_pictures(const TemporaryFolder& folder, const std::string& extension, int first, int last) {
  for (int i = first; i <= last; ++i) {
    write_picture(folder / (std::to_string(i) + extension), i);
  }
}

/// Noise about a mean that tells the frame's number.
void write_video(const fs::path& path, int fourcc, int frames, double rate) {
  cv::VideoWriter writer(path.string(), cv::CAP_FFMPEG, fourcc, rate, {kWidth, kHeight});
  REQUIRE(writer.isOpened());
  for (int i = 0; i < frames; ++i) {
    cv::Mat noise(kHeight, kWidth, CV_8UC3);
    cv::randu(noise, 0, 17);
    writer.write(numbered_picture(i) + noise - cv::Scalar::all(8));
  }
}

const int kMotionJpeg = cv::VideoWriter::fourcc('M', 'J', 'P', 'G');
const int kMpeg4 = cv::VideoWriter::fourcc('m', 'p', '4', 'v');

struct Delivered {
  std::vector<int> numbers;
  std::vector<std::int64_t> indices;
  std::vector<double> times_s;
};

Delivered deliver_all(FrameSource& source) {
  Delivered all;
  Frame frame;
  while (source.next(frame)) {
    REQUIRE(frame.image.type() == CV_8UC3);
    REQUIRE(frame.image.size() == source.size());
    if (!all.times_s.empty()) CHECK(frame.time_s > all.times_s.back());  // trackers refuse others
    all.numbers.push_back(number_of(frame.image));
    all.indices.push_back(frame.index);
    all.times_s.push_back(frame.time_s);
  }
  return all;
}

FrameSourceOptions range(std::int64_t start, std::int64_t stop, std::int64_t stride) {
  FrameSourceOptions options;
  options.start = start;
  options.stop = stop;
  options.stride = stride;
  return options;
}

/// FFmpeg speaks on stderr of files spoiled on purpose.
const int ffmpeg_is_silent = setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);

}  // namespace

TEST_CASE("natural order compares runs of digits as numbers") {
  const std::vector<std::string> ordered = {"a",       "a1.png", "a2.png",  "a10.png",  "a10b.png",
                                            "a11.png", "b",      "b1x2.jp", "b1x10.jp", "b2x1.jp"};
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    for (std::size_t j = 0; j < ordered.size(); ++j) {
      CAPTURE(ordered[i]);
      CAPTURE(ordered[j]);
      CHECK(natural_less(ordered[i], ordered[j]) == (i < j));
    }
  }
  CHECK(natural_less("a01", "a1"));  // a strict order even between names that read the same
  CHECK_FALSE(natural_less("a1", "a01"));
}

TEST_CASE("a folder's images come in natural order, numbered from 0, other files ignored") {
  const TemporaryFolder folder;
  write_pictures(folder, ".png", 0, 11);
  folder.write("notes.txt", "not an image");
  FrameSource source(folder.path().string());
  CHECK(source.frame_count() == 12);
  CHECK(source.size() == cv::Size(kWidth, kHeight));
  const Delivered all = deliver_all(source);
  REQUIRE(all.numbers.size() == 12);
  for (int i = 0; i < 12; ++i) {
    CHECK(all.numbers[i] == i);
    CHECK(all.indices[i] == i);
    CHECK(all.times_s[i] == doctest::Approx(i / 30.0));
  }
  CHECK_FALSE(source.ended_early());
}

TEST_CASE("a printf pattern numbers frames as the files say, a glob from 0") {
  const TemporaryFolder folder;
  for (int i = 3; i <= 7; ++i) {
    write_picture(folder / ("view_00" + std::to_string(i) + ".png"), i);
  }
  write_picture(folder / "view_9.png", 9);  // not of three digits
  FrameSourceOptions options;
  options.frame_rate = 10;
  FrameSource numbered((folder / "view_%03d.png").string(), options);
  const Delivered by_number = deliver_all(numbered);
  CHECK(by_number.indices == std::vector<std::int64_t>{3, 4, 5, 6, 7});
  CHECK(by_number.numbers == std::vector<int>{3, 4, 5, 6, 7});
  CHECK(by_number.times_s.back() == doctest::Approx(0.4));

  FrameSource from_five((folder / "view_%03d.png").string(), range(5, 100, 1));
  CHECK(deliver_all(from_five).indices == std::vector<std::int64_t>{5, 6, 7});

  FrameSource globbed((folder / "view_00*.png").string());
  const Delivered by_glob = deliver_all(globbed);
  CHECK(by_glob.indices == std::vector<std::int64_t>{0, 1, 2, 3, 4});
  CHECK(by_glob.numbers == std::vector<int>{3, 4, 5, 6, 7});
}

TEST_CASE("an existing file is not taken for a pattern") {
  const TemporaryFolder folder;
  write_picture(folder / "a[1]%02d.png", 5);
  FrameSource source((folder / "a[1]%02d.png").string());
  CHECK(deliver_all(source).numbers == std::vector<int>{5});
}

TEST_CASE("frames delivered and frame_count() agree with counting by hand for every range") {
  const TemporaryFolder folder;
  write_pictures(folder, ".png", 0, 6);
  write_video(folder / "v.avi", kMotionJpeg, 7, 25);
  for (const std::string& input : {folder.path().string(), (folder / "v.avi").string()}) {
    if (input == folder.path().string()) {
      fs::rename(folder / "v.avi", folder / "v.kept");
    } else {
      fs::rename(folder / "v.kept", folder / "v.avi");
    }
    for (int start = 0; start < 7; ++start) {
      for (int stop = start + 1; stop <= 9; ++stop) {
        for (int stride = 1; stride <= 4; ++stride) {
          std::vector<int> wanted;
          for (int i = start; i < std::min(stop, 7); i += stride) {
            wanted.push_back(i);
          }
          CAPTURE(input);
          CAPTURE(start);
          CAPTURE(stop);
          CAPTURE(stride);
          FrameSource source(input, range(start, stop, stride));
          CHECK(source.frame_count() == static_cast<std::int64_t>(wanted.size()));
          const Delivered all = deliver_all(source);
          CHECK(all.numbers == wanted);
          CHECK(std::equal(wanted.begin(), wanted.end(), all.indices.begin(), all.indices.end()));
        }
      }
    }
  }
}

TEST_CASE("grey, 16 bit and alpha images become BGR8") {
  const TemporaryFolder folder;
  cv::imwrite((folder / "0.png").string(), cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(22)));
  cv::imwrite((folder / "1.png").string(), cv::Mat(kHeight, kWidth, CV_16UC3, cv::Scalar::all(34 * 256)));
  cv::imwrite((folder / "2.png").string(), cv::Mat(kHeight, kWidth, CV_8UC4, cv::Scalar(46, 46, 46, 0)));
  FrameSource source(folder.path().string());
  CHECK(deliver_all(source).numbers == std::vector<int>{1, 2, 3});
}

TEST_CASE("orientation marks are not applied: calibrations belong to the recorded frame") {
  const TemporaryFolder folder;
  SUBCASE("EXIF of an image") {
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", numbered_picture(4), jpeg);
    // APP1 with one TIFF entry: orientation (0x0112) 6, a quarter turn.
    const std::string exif(
        "\xff\xe1\x00\x22"
        "Exif\0\0"
        "MM\0\x2a\0\0\0\x08"
        "\0\x01"
        "\x01\x12\0\x03\0\0\0\x01\0\x06\0\0"
        "\0\0\0\0",
        36);
    std::string file(jpeg.begin(), jpeg.end());
    file.insert(2, exif);
    const fs::path path = folder.write("turned.jpg", file);
    REQUIRE(cv::imread(path.string()).size() == cv::Size(kHeight, kWidth));  // the mark is valid
    FrameSource source(path.string());
    CHECK(source.size() == cv::Size(kWidth, kHeight));
    REQUIRE(source.doubt());  // but they are told
    CHECK(source.doubt()->find("turned by 90 degrees") != std::string::npos);
  }
  SUBCASE("rotation of a video") {
    write_video(folder / "v.mp4", kMpeg4, 3, 30);
    std::string file = read_file(folder / "v.mp4");
    const std::size_t matrix = file.find("tkhd") + 4 + 40;  // after version, times, id, duration, layer and volume
    REQUIRE(file.substr(matrix, 4) == std::string("\0\1\0\0", 4));
    const std::string one("\0\1\0\0", 4);
    const std::string minus_one("\xff\xff\0\0", 4);
    const std::string zero(4, '\0');
    file.replace(matrix, 20, zero + one + zero + minus_one + zero);
    const fs::path path = folder.write("turned.mp4", file);
    REQUIRE(cv::VideoCapture(path.string(), cv::CAP_FFMPEG).get(cv::CAP_PROP_ORIENTATION_META) != 0);
    FrameSource source(path.string());
    CHECK(source.size() == cv::Size(kWidth, kHeight));
    CHECK(deliver_all(source).numbers == std::vector<int>{0, 1, 2});
    REQUIRE(source.doubt());
    CHECK(source.doubt()->find("is stored turned by") != std::string::npos);
  }
}

TEST_CASE("a video's frames carry its own times; a frame rate given overrides them") {
  const TemporaryFolder folder;
  write_video(folder / "v.mp4", kMpeg4, 8, 12.5);
  FrameSource source((folder / "v.mp4").string());
  CHECK(source.frame_rate() == doctest::Approx(12.5));
  CHECK_FALSE(source.live());
  const Delivered own = deliver_all(source);
  REQUIRE(own.times_s.size() == 8);
  for (int i = 0; i < 8; ++i) {
    CHECK(own.times_s[i] == doctest::Approx(i / 12.5));
  }
  FrameSourceOptions options;
  options.frame_rate = 100;
  FrameSource faster((folder / "v.mp4").string(), options);
  CHECK(deliver_all(faster).times_s.back() == doctest::Approx(0.07));
}

TEST_CASE("the memory of a video's frame handed back is used again") {
  const TemporaryFolder folder;
  write_video(folder / "v.avi", kMotionJpeg, 4, 25);
  FrameSource source((folder / "v.avi").string());
  Frame frame;
  REQUIRE(source.next(frame));
  const std::uint8_t* memory = frame.image.data;
  while (source.next(frame)) {
    CHECK(frame.image.data == memory);
  }
}

TEST_CASE("a stream of JPEGs is a video, though it begins as a picture does") {
  const TemporaryFolder folder;
  write_video(folder / "v.mjpeg", cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 5, 25);
  FrameSource source((folder / "v.mjpeg").string(), {});
  const Delivered all = deliver_all(source);
  CHECK(all.numbers == std::vector<int>{0, 1, 2, 3, 4});
  CHECK(all.times_s.front() == 0);  // its frames have no time stamps
  CHECK(all.times_s.back() < 1);
}

TEST_CASE("inputs that cannot be opened say why") {
  const TemporaryFolder folder;
  const auto error = [](const fs::path& input, const FrameSourceOptions& options = {}) {
    return error_of([&] { FrameSource source(input.string(), options); });
  };
  CHECK(error(folder / "none.mp4").says(ErrorCode::file, {"none.mp4", "there is no", "image folder"}));
  CHECK(error(folder.path()).says(ErrorCode::file, {folder.path().c_str(), "no image files"}));
  CHECK(error(folder / "x%04d.png").says(ErrorCode::file, {"x%04d.png", "no file matches"}));
  CHECK(error(folder / "*.png").says(ErrorCode::file, {"*.png", "no file matches"}));
  CHECK(error(folder / "none%d/x.png").says(ErrorCode::file, {"none%d", "in a folder's name"}));
  CHECK(error(folder.write("text.mp4", "no video")).says(ErrorCode::file, {"text.mp4", "as a video"}));
  CHECK(error(folder.write("empty.mp4", "")).says(ErrorCode::file, {"empty.mp4", "it is empty"}));
  const std::string sound =
      std::string("RIFF\x25\0\0\0WAVEfmt \x10\0\0\0\1\0\1\0\x40\x1f\0\0\x40\x1f\0\0\1\0\x08\0", 36) +
      std::string("data\1\0\0\0\x80", 9);
  CHECK(error(folder.write("sound.wav", sound)).says(ErrorCode::file, {"sound.wav", "it holds no video"}));
  CHECK(error(folder.write("empty.jpg", "")).says(ErrorCode::file, {"empty.jpg", "it is empty"}));
  CHECK(error(folder.write("text.jpg", "no image")).says(ErrorCode::file, {"text.jpg", "cannot be decoded"}));
  CHECK(error("987").says(ErrorCode::file, {"camera 987", "/dev/video987"}));
}

TEST_CASE("copies and masks among the frames are doubted") {
  using holdfast::app::other_images;
  const auto doubt = [](const std::vector<std::string>& names) {
    std::vector<holdfast::app::ListedImage> images;
    for (const std::string& name : names) images.push_back({"f/" + name, static_cast<std::int64_t>(images.size())});
    return other_images(images).value_or("");
  };
  CHECK(doubt({"0.jpg", "0.png", "1.jpg", "1.png"}).find("'f/0.jpg' and 'f/0.png'") != std::string::npos);
  CHECK(doubt({"0.png", "1.png", "2.png", "preview.jpg"}).find("preview.jpg") != std::string::npos);
  CHECK(doubt({"0.png", "0_mask.png", "1.png", "1_mask.png"}).find("masks") != std::string::npos);
  for (const auto& names : std::vector<std::vector<std::string>>{{"0.png", "1.png", "2.PNG"},
                                                                 {"cam1_20260102_1.jpg", "cam1_20260103_22.jpg"},
                                                                 {"first.png", "second.png"},
                                                                 {"a3f.png", "b22.png", "0cc.png", "9ab.png"},
                                                                 {"IMG_1.jpg", "IMG_2.jpg", "DSC_1.jpg"},
                                                                 {}}) {
    CHECK(doubt(names).empty());
  }
  const TemporaryFolder folder;
  write_pictures(folder, ".png", 3, 4);
  write_pictures(folder, ".jpg", 3, 4);
  CHECK(FrameSource(folder.path().string()).doubt().value_or("").find("several kinds") != std::string::npos);
  CHECK_FALSE(FrameSource((folder / "*.png").string()).doubt());
}

TEST_CASE("images may be numbered by nanoseconds") {
  const TemporaryFolder folder;
  for (const char* name :
       {"1700000000000000001.png", "1700000000000000000.png", "9223372036854775807.png", "9999999999999999999.png"}) {
    write_picture(folder / name, 1);
  }
  const auto images = list_images((folder / "%d.png").string());
  REQUIRE(images);
  REQUIRE(images->size() == 2);  // the others' numbers are no frame's
  CHECK(images->front().index == 1700000000000000000);
  CHECK(images->back().index == 1700000000000000001);
}

TEST_CASE("ranges that hold no frame are refused") {
  const TemporaryFolder folder;
  write_pictures(folder, ".png", 2, 5);
  const std::string input = (folder / "%d.png").string();
  const auto error = [&](std::int64_t start, std::int64_t stop, std::int64_t stride) {
    return error_of([&] { FrameSource source(input, range(start, stop, stride)); });
  };
  CHECK(error(-1, 3, 1).says(ErrorCode::invalid_argument, {"--start -1"}));
  CHECK(error(3, 3, 1).says(ErrorCode::invalid_argument, {"--stop 3", "--start 3"}));
  CHECK(error(0, 9, 0).says(ErrorCode::invalid_argument, {"--stride 0"}));
  CHECK(error(6, 9, 1).says(ErrorCode::invalid_argument, {"--start 6", "last frame is 5"}));
  CHECK(error(0, 2, 1).says(ErrorCode::invalid_argument, {"--stop 2", "whose first is 2"}));
  CHECK_FALSE(error(5, 6, 1).thrown);
}

TEST_CASE("a frame of another size ends the input with both sizes") {
  const TemporaryFolder folder;
  write_pictures(folder, ".png", 0, 3);
  write_picture(folder / "2.png", 2, {32, 24});
  FrameSource source(folder.path().string());
  Frame frame;
  CHECK(source.next(frame));
  CHECK(source.next(frame));
  CHECK(error_of([&] { source.next(frame); }).says(ErrorCode::image, {"frame 2", "2.png", "32x24", "64x48"}));
}

TEST_CASE("an image that is missing or spoiled within a sequence is named") {
  const TemporaryFolder folder;
  write_pictures(folder, ".jpg", 0, 4);
  const auto third_frame_error = [&](const std::string& input) {
    FrameSource source(input);
    Frame frame;
    REQUIRE(source.next(frame));
    REQUIRE(source.next(frame));
    return error_of([&] { source.next(frame); });
  };
  const std::string pattern = (folder / "%d.jpg").string();
  SUBCASE("cut short: decoders would show a grey rest") {
    const std::string whole = read_file(folder / "2.jpg");
    folder.write("2.jpg", whole.substr(0, whole.size() - 10));
    REQUIRE_FALSE(cv::imread((folder / "2.jpg").string()).empty());
    CHECK(third_frame_error(pattern).says(ErrorCode::file, {"frame 2", "2.jpg", "cut short", "--stop 2"}));
  }
  SUBCASE("no image") {
    folder.write("2.jpg", "text");
    CHECK(third_frame_error(pattern).says(ErrorCode::file, {"frame 2", "2.jpg", "decoded"}));
  }
  SUBCASE("a PNG cut short") {
    for (int i = 0; i < 4; ++i) {
      cv::Mat noise(kHeight, kWidth, CV_8UC3);
      cv::randu(noise, 0, 255);
      cv::imwrite((folder / (std::to_string(i) + ".png")).string(), noise);
    }
    const std::string whole = read_file(folder / "2.png");
    folder.write("2.png", whole.substr(0, whole.size() / 2));
    CHECK(third_frame_error((folder / "%d.png").string()).says(ErrorCode::file, {"frame 2", "2.png", "cut short"}));
  }
  SUBCASE("spoiled within: the picture before must not be handed out again") {
    for (int i = 0; i < 4; ++i) {
      cv::imwrite((folder / (std::to_string(i) + ".png")).string(), numbered_picture(i));
    }
    std::string spoiled = read_file(folder / "2.png");
    spoiled[20] = '\xff';  // the header's height
    folder.write("2.png", spoiled);
    CHECK(third_frame_error((folder / "%d.png").string()).says(ErrorCode::file, {"frame 2", "2.png", "damaged"}));
  }
  SUBCASE("missing") {
    fs::remove(folder / "2.jpg");
    CHECK(third_frame_error(pattern).says(ErrorCode::file, {"frame 2 is missing", "1.jpg", "3.jpg"}));
    FrameSource after_the_gap(pattern, range(3, 9, 1));
    CHECK(deliver_all(after_the_gap).indices == std::vector<std::int64_t>{3, 4});
  }
  SUBCASE("a folder of that name") {
    fs::remove(folder / "2.jpg");
    fs::create_directory(folder / "2.jpg");
    CHECK(third_frame_error(pattern).says(ErrorCode::file, {"frame 2", "2.jpg"}));
  }
}

TEST_CASE("a video cut short delivers what is there and says so") {
  const TemporaryFolder folder;
  write_video(folder / "v.avi", kMotionJpeg, 10, 25);
  const std::string whole = read_file(folder / "v.avi");
  const fs::path cut = folder.write("cut.avi", whole.substr(0, whole.size() * 8 / 10));
  FrameSource source(cut.string());
  const Delivered all = deliver_all(source);
  CHECK(all.numbers.size() >= 2);
  CHECK(all.numbers.size() < 10);
  REQUIRE(source.ended_early());
  CHECK(source.ended_early()->find("cut.avi") != std::string::npos);
  CHECK(source.ended_early()->find("cut short") != std::string::npos);

  FrameSource stopped_before(cut.string(), range(0, 2, 1));
  CHECK(deliver_all(stopped_before).numbers == std::vector<int>{0, 1});
  CHECK_FALSE(stopped_before.ended_early());  // what was asked for was there

  FrameSource untouched((folder / "v.avi").string());
  CHECK(deliver_all(untouched).numbers.size() == 10);
  CHECK_FALSE(untouched.ended_early());
}

TEST_CASE("a Matroska file cut short delivers what is there and says so") {
  const TemporaryFolder folder;
  write_video(folder / "v.mkv", kMotionJpeg, 10, 25);
  const std::string whole = read_file(folder / "v.mkv");
  CHECK_FALSE(video_damage(folder / "v.mkv"));
  FrameSource source(folder.write("cut.mkv", whole.substr(0, whole.size() * 6 / 10)).string());
  const std::size_t delivered = deliver_all(source).numbers.size();
  CHECK(delivered >= 2);
  CHECK(delivered < 10);
  REQUIRE(source.ended_early());
  CHECK(source.ended_early()->find("of " + std::to_string(whole.size()) + " bytes") != std::string::npos);
  // A recording that was not finished knows no size.
  std::string open = whole.substr(0, whole.size() * 6 / 10);
  const std::size_t segment = open.find("\x18\x53\x80\x67");
  REQUIRE(segment != std::string::npos);
  open.replace(segment + 4, 8, "\x01\xff\xff\xff\xff\xff\xff\xff");
  FrameSource unfinished(folder.write("open.mkv", open).string());
  CHECK(deliver_all(unfinished).numbers.size() == delivered);
  CHECK_FALSE(unfinished.ended_early());
}

TEST_CASE("an MP4 cut short has lost its index and says so") {
  const TemporaryFolder folder;
  write_video(folder / "v.mp4", kMpeg4, 5, 25);
  const std::string whole = read_file(folder / "v.mp4");
  CHECK_FALSE(video_damage(folder / "v.mp4"));
  for (std::size_t size = 12; size < whole.size(); size += 97) {
    CAPTURE(size);
    const fs::path cut = folder.write("cut.mp4", whole.substr(0, size));
    CHECK(video_damage(cut));
  }
  const fs::path half = folder.write("half.mp4", whole.substr(0, whole.size() / 2));
  CHECK(error_of([&] { FrameSource source(half.string()); }).says(ErrorCode::file, {"half.mp4", "cut short"}));

  const fs::path last_byte_missing = folder.write("cut.mp4", whole.substr(0, whole.size() - 1));
  CHECK(video_damage(last_byte_missing)->find("of " + std::to_string(whole.size()) + " bytes") != std::string::npos);
  FrameSource source(last_byte_missing.string());
  deliver_all(source);
  CHECK(source.ended_early());
}

TEST_CASE("a count that is more than is shown is no damage: edit lists and estimates") {
  const TemporaryFolder folder;
  SUBCASE("an MP4 trimmed by its edit list") {
    write_video(folder / "v.mp4", kMpeg4, 20, 20);
    std::string file = read_file(folder / "v.mp4");
    const auto halve = [&file](const std::string& box, std::size_t offset) {
      const std::size_t at = file.find(box);
      REQUIRE(at != std::string::npos);
      std::uint32_t value = 0;
      for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(file[at + offset + i]);
      value /= 2;
      for (std::size_t i = 0; i < 4; ++i) file[at + offset + i] = static_cast<char>(value >> (24 - 8 * i) & 0xff);
    };
    halve("mvhd", 4 + 4 + 12);  // version, times and scale before the duration
    halve("tkhd", 4 + 4 + 16);
    halve("elst", 4 + 8);
    FrameSource source(folder.write("trimmed.mp4", file).string());
    const Delivered all = deliver_all(source);
    CHECK(all.numbers.size() >= 9);
    CHECK(all.numbers.size() <= 12);
    CHECK_FALSE(source.ended_early());
  }
  SUBCASE("a Matroska file, whose frames nobody has counted") {
    write_video(folder / "v.mkv", kMpeg4, 20, 20);
    // Its duration, a double after the element's name and length, is made four times as long.
    std::string file = read_file(folder / "v.mkv");
    const std::size_t at = file.find("\x44\x89\x88");
    REQUIRE(at != std::string::npos);
    file[at + 4] = static_cast<char>(file[at + 4] + 0x20);  // two more in the exponent
    FrameSource source(folder.write("longer.mkv", file).string());
    REQUIRE(source.frame_count().value_or(0) > 30);
    CHECK(deliver_all(source).numbers.size() == 20);
    CHECK_FALSE(source.ended_early());
    FrameSourceOptions behind;
    behind.start = 25;  // by the estimate there is such a frame
    CHECK(error_of([&] {
            FrameSource none((folder / "longer.mkv").string(), behind);
          }).says(ErrorCode::invalid_argument, {"--start 25", "behind the end"}));
  }
}

TEST_CASE("what macOS leaves beside pictures is none") {
  const TemporaryFolder folder;
  write_pictures(folder, ".jpg", 0, 2);
  folder.write("._0.jpg", "resource fork");
  FrameSource source(folder.path().string());
  CHECK(deliver_all(source).numbers == std::vector<int>{0, 1, 2});
}

TEST_CASE("an image's end mark is looked for behind its thumbnail") {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", numbered_picture(3), jpeg);
  CHECK_FALSE(image_damage(jpeg));
  const std::vector<std::uint8_t> thumbnail = {0xff, 0xe1, 0x00, 0x06, 0xff, 0xd8, 0xff, 0xd9};
  jpeg.insert(jpeg.begin() + 2, thumbnail.begin(), thumbnail.end());
  CHECK_FALSE(image_damage(jpeg));
  jpeg.resize(jpeg.size() - 2);
  CHECK(image_damage(jpeg));
  CHECK_FALSE(image_damage(std::vector<std::uint8_t>{1, 2, 3, 4, 5}));  // no JPEG: the decoder's matter
}

namespace {

/// A camera that delivers so many frames each time it is opened.
class FakeCamera : public cv::VideoCapture {
 public:
  explicit FakeCamera(int frames) : left_(frames) {}
  bool grab() override { return left_-- > 0; }
  bool read(cv::OutputArray image) override {
    if (!grab()) return false;
    cv::Mat(4, 6, CV_8UC3, cv::Scalar(90, 90, 90)).copyTo(image);
    return true;
  }
  double get(int) const override { return 0; }
  bool set(int, double) override { return true; }

 private:
  int left_;
};

}  // namespace

TEST_CASE("a camera that is unplugged and comes back goes on") {
  int opened = 0, asked = 0;
  const auto open = [&]() -> std::unique_ptr<cv::VideoCapture> {
    ++opened;
    if (opened == 2 || opened == 3) return nullptr;  // still unplugged
    return std::make_unique<FakeCamera>(2);
  };
  FrameSourceOptions options;
  options.gives_up = [&] { return ++asked > 5; };
  CameraReader reader(0, open, options, std::chrono::milliseconds(0));
  Frame frame;
  double last = -1;
  for (int i = 0; i < 4; ++i) {
    CAPTURE(i);
    REQUIRE(reader.read(frame));
    CHECK(frame.index == i);
    CHECK(frame.time_s > last);
    CHECK(frame.image.size() == cv::Size(6, 4));
    last = frame.time_s;
  }
  CHECK(opened == 4);
  CHECK(reader.skip());
  // Nobody waits any longer; and where nobody does from the beginning, it ends at once.
  asked = 5;
  REQUIRE(reader.read(frame));
  CHECK_FALSE(reader.read(frame));
  CHECK(reader.ended_early(0)->find("disconnected") != std::string::npos);
  CameraReader impatient(
      0, [] { return std::make_unique<FakeCamera>(1); }, {}, std::chrono::milliseconds(0));
  CHECK(impatient.read(frame));
  CHECK_FALSE(impatient.read(frame));
  CHECK_FALSE(impatient.skip());
}
