#include "simulation/textured_box.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "holdfast/error.hpp"
#include "simulation/background.hpp"
#include "simulation/random.hpp"

namespace holdfast::simulation {
namespace {

// Each face seen from outside: its top left corner and the directions of its picture, in units of half the size.
struct Face {
  Eigen::Vector3d top_left;
  Eigen::Vector3d right;
  Eigen::Vector3d down;
  double width(const Eigen::Vector3d& size) const { return right.cwiseAbs().dot(size); }
  double height(const Eigen::Vector3d& size) const { return down.cwiseAbs().dot(size); }
};

std::array<Face, 6> box_faces() {
  return {{{{-1, 1, 1}, {1, 0, 0}, {0, -1, 0}},     // front
           {{1, 1, -1}, {-1, 0, 0}, {0, -1, 0}},    // back
           {{1, 1, 1}, {0, 0, -1}, {0, -1, 0}},     // right
           {{-1, 1, -1}, {0, 0, 1}, {0, -1, 0}},    // left
           {{-1, 1, -1}, {1, 0, 0}, {0, 0, 1}},     // top
           {{-1, -1, 1}, {1, 0, 0}, {0, 0, -1}}}};  // bottom
}

void add_faces(Mesh& mesh, const Eigen::Vector3d& size) {
  for (const Face& face : box_faces()) {
    const std::uint32_t first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [right, down] : {std::pair(0, 0), std::pair(0, 1), std::pair(1, 1), std::pair(1, 0)}) {
      const Eigen::Vector3d corner = face.top_left + 2.0 * (right * face.right + down * face.down);
      mesh.positions.push_back((0.5 * corner.cwiseProduct(size)).cast<float>());
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
}

using Painter = std::function<cv::Mat(int face, cv::Size size)>;

// Paints each face and puts the pictures into one texture, each with a frame of its own edge colours round it, so that
// filtering does not mix faces.
Mesh painted_box(const Eigen::Vector3d& size, double texels_per_metre, const std::string& name, const Painter& paint) {
  constexpr int gutter = 16;
  Mesh mesh;
  add_faces(mesh, size);
  const std::array<Face, 6> faces = box_faces();
  std::array<cv::Rect, 6> places;
  int width = 0;
  int top = 0;
  for (std::size_t row = 0; row < 3; ++row) {  // opposite faces are of one size: two in a row
    const Face& face = faces[2 * row];
    const cv::Size picture(std::max(8, cvRound(face.width(size) * texels_per_metre)),
                           std::max(8, cvRound(face.height(size) * texels_per_metre)));
    places[2 * row] = cv::Rect({gutter, top + gutter}, picture);
    places[2 * row + 1] = cv::Rect({3 * gutter + picture.width, top + gutter}, picture);
    width = std::max(width, 2 * picture.width + 4 * gutter);
    top += picture.height + 2 * gutter;
  }
  cv::Mat atlas(top, width, CV_8UC3, cv::Scalar(128, 128, 128));
  for (int i = 0; i < 6; ++i) {
    const cv::Rect& place = places[static_cast<std::size_t>(i)];
    cv::Mat framed;
    cv::copyMakeBorder(paint(i, place.size()), framed, gutter, gutter, gutter, gutter, cv::BORDER_REPLICATE);
    framed.copyTo(atlas(cv::Rect(place.x - gutter, place.y - gutter, framed.cols, framed.rows)));
    const float left = static_cast<float>(place.x) / static_cast<float>(width);
    const float right = static_cast<float>(place.x + place.width) / static_cast<float>(width);
    const float upper = 1.0f - static_cast<float>(place.y) / static_cast<float>(top);
    const float lower = 1.0f - static_cast<float>(place.y + place.height) / static_cast<float>(top);
    for (const Eigen::Vector2f& corner : {Eigen::Vector2f(left, upper), Eigen::Vector2f(left, lower),
                                          Eigen::Vector2f(right, lower), Eigen::Vector2f(right, upper)}) {
      mesh.texture_coordinates.push_back(corner);
    }
  }
  Material material{name, {width, top, {}}};
  cv::Mat rgba;
  cv::cvtColor(atlas, rgba, cv::COLOR_BGR2RGBA);
  material.texture.rgba.assign(rgba.datastart, rgba.dataend);
  mesh.materials.push_back(std::move(material));
  return mesh;
}

cv::Scalar print_color(Random& random) {
  cv::Mat hsv(1, 1, CV_8UC3, cv::Scalar(random.below(180), 120 + random.below(120), 90 + random.below(150)));
  cv::cvtColor(hsv, hsv, cv::COLOR_HSV2BGR);
  const cv::Vec3b bgr = hsv.at<cv::Vec3b>(0);
  return cv::Scalar(bgr[0], bgr[1], bgr[2]);
}

std::string word(Random& random, int letters) {
  static constexpr const char* syllables[] = {"ba", "ko", "ri", "ten", "sol", "mar",
                                              "lu", "pe", "no", "vi",  "gra", "do"};
  std::string result;
  while (static_cast<int>(result.size()) < letters) result += syllables[random.below(12)];
  result[0] = static_cast<char>(result[0] - 'a' + 'A');
  return result;
}

// Text as wide as the area allows, standing on its lower edge.
void put_text(cv::Mat& picture, const std::string& text, const cv::Rect& area, const cv::Scalar& color, double weight) {
  constexpr int font = cv::FONT_HERSHEY_DUPLEX;
  int baseline = 0;
  const cv::Size unit = cv::getTextSize(text, font, 1.0, 1, &baseline);
  const double scale =
      std::min(static_cast<double>(area.width) / unit.width, static_cast<double>(area.height) / unit.height);
  const int thickness = std::max(1, cvRound(weight * scale));
  cv::putText(picture, text, {area.x, area.y + area.height}, font, scale, color, thickness, cv::LINE_AA);
}

void add_small_print(cv::Mat& picture, const cv::Rect& area, Random& random, const cv::Scalar& color) {
  const int line = std::max(9, picture.rows / 28);
  for (int y = area.y; y + line <= area.y + area.height; y += line + line / 2) {
    std::string text;
    while (text.size() < 34) text += word(random, 2 + random.below(7)) + " ";
    put_text(picture, text, {area.x, y, static_cast<int>(area.width * random.uniform(0.75, 1.0)), line}, color, 1.2);
  }
}

void add_bar_code(cv::Mat& picture, const cv::Rect& area, Random& random) {
  cv::rectangle(picture, area, cv::Scalar(245, 245, 245), cv::FILLED);
  const int unit = std::max(2, area.width / 70);
  for (int x = area.x + 3 * unit; x + 4 * unit < area.x + area.width;) {
    const int bar = unit * (1 + random.below(3));
    cv::rectangle(picture, {x, area.y + 2 * unit, bar, area.height - 4 * unit}, cv::Scalar(20, 20, 20), cv::FILLED);
    x += bar + unit * (1 + random.below(3));
  }
}

void add_stripes(cv::Mat& picture, const cv::Rect& area, Random& random) {
  cv::Mat part = picture(area);
  const int pitch = std::max(6, picture.rows / (6 + random.below(8)));
  const cv::Scalar color = print_color(random);
  for (int x = -area.height; x < area.width; x += 2 * pitch) {
    const std::vector<cv::Point> stripe{
        {x, area.height}, {x + area.height, 0}, {x + area.height + pitch, 0}, {x + pitch, area.height}};
    cv::fillPoly(part, std::vector<std::vector<cv::Point>>{stripe}, color, cv::LINE_AA);
  }
}

void add_star(cv::Mat& picture, cv::Point center, int radius, const cv::Scalar& color) {
  std::vector<cv::Point> points;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2.0 * CV_PI * i / 24;
    const double reach = radius * (i % 2 == 0 ? 1.0 : 0.78);
    points.emplace_back(center.x + cvRound(reach * std::cos(angle)), center.y + cvRound(reach * std::sin(angle)));
  }
  cv::fillPoly(picture, std::vector<std::vector<cv::Point>>{points}, color, cv::LINE_AA);
}

// Cardboard's fibres: faint streaks that keep plain areas from being perfectly even.
void add_fibres(cv::Mat& picture, Random& random) {
  cv::Mat grain(picture.size(), CV_32F);
  for (int y = 0; y < grain.rows; ++y) {
    for (int x = 0; x < grain.cols; ++x) grain.at<float>(y, x) = static_cast<float>(random.uniform(-1.0, 1.0));
  }
  cv::GaussianBlur(grain, grain, {}, 4.0, 1.0);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      cv::Vec3b& pixel = picture.at<cv::Vec3b>(y, x);
      for (int k = 0; k < 3; ++k) pixel[k] = cv::saturate_cast<std::uint8_t>(pixel[k] + 14.0f * grain.at<float>(y, x));
    }
  }
}

cv::Mat paint_carton(cv::Size size, std::uint64_t seed, int face) {
  Random random(seed, 0xb0c5 + static_cast<std::uint64_t>(face));
  const cv::Scalar cardboard(112, 152, 186);
  const cv::Scalar ink(38, 30, 28);
  cv::Mat picture(size, CV_8UC3, cardboard);
  const int w = size.width, h = size.height;
  const auto part = [&](double x, double y, double width, double height) {
    return cv::Rect(cvRound(x * w), cvRound(y * h), cvRound(width * w), cvRound(height * h));
  };
  const auto paste_photo = [&](const cv::Rect& area) {
    cv::Mat photo;  // coarser than the texture, as photographs are printed
    cv::resize(procedural_picture((area.size() + cv::Size(2, 2)) / 3, random.bits()), photo, area.size(), 0, 0,
               cv::INTER_CUBIC);
    photo.copyTo(picture(area));
    cv::rectangle(picture, area, cv::Scalar(250, 250, 250), std::max(2, h / 120), cv::LINE_AA);
  };

  const cv::Scalar band = print_color(random);
  cv::rectangle(picture, part(0, 0.06, 1, 0.24), band, cv::FILLED);
  cv::rectangle(picture, part(0, 0.30, 1, 0.02), cv::Scalar(240, 240, 240), cv::FILLED);
  put_text(picture, word(random, 6), part(0.05, 0.11, 0.55, 0.13), cv::Scalar(250, 250, 250), 3.0);
  const bool mirrored = random.uniform() < 0.5;
  const double photo_left = mirrored ? 0.04 : 0.46;
  const double text_left = mirrored ? 0.57 : 0.05;
  add_stripes(picture, part(text_left, 0.36, 0.37, 0.14), random);
  paste_photo(part(photo_left, 0.36, 0.50, 0.40));
  add_small_print(picture, part(text_left, 0.55, 0.37, 0.22), random, ink);
  for (int i = 0; i < 4; ++i) {
    cv::rectangle(picture, part(0.04 + 0.11 * i, 0.82, 0.08, 0.12), print_color(random), cv::FILLED);
  }
  add_bar_code(picture, part(0.50, 0.81, 0.24, 0.14), random);
  put_text(picture, std::to_string(100 + random.below(900)) + " g", part(0.78, 0.84, 0.18, 0.08), ink, 2.0);
  const int radius = std::min(w, h) / 7;
  const cv::Point center(cvRound(0.84 * w), cvRound(0.2 * h));
  add_star(picture, center, radius, print_color(random));
  put_text(picture, "NEW", {center.x - radius / 2, center.y - radius / 2, radius, radius * 2 / 3},
           cv::Scalar(255, 255, 255), 2.5);
  add_fibres(picture, random);
  return picture;
}

cv::Mat paint_letter(cv::Size size, std::uint64_t seed, int face) {
  Random random(seed, 0x1e77e5 + static_cast<std::uint64_t>(face));
  cv::Mat picture(size, CV_8UC3, print_color(random));
  const int w = size.width, h = size.height;
  cv::rectangle(picture, {w / 12, h / 12, w - w / 6, h - h / 6}, cv::Scalar(235, 240, 242), cv::FILLED, cv::LINE_AA);
  cv::rectangle(picture, {w / 8, h / 8, w - w / 4, h - h / 4}, print_color(random), std::max(2, w / 40), cv::LINE_AA);
  const std::string letter(1, static_cast<char>('A' + random.below(26)));
  int baseline = 0;
  const double scale = 0.5 * h / cv::getTextSize(letter, cv::FONT_HERSHEY_DUPLEX, 1.0, 1, &baseline).height;
  const int thickness = std::max(2, cvRound(h / 11.0));
  const cv::Size extent = cv::getTextSize(letter, cv::FONT_HERSHEY_DUPLEX, scale, thickness, &baseline);
  cv::putText(picture, letter, {(w - extent.width) / 2, (h + extent.height) / 2}, cv::FONT_HERSHEY_DUPLEX, scale,
              print_color(random), thickness, cv::LINE_AA);
  add_fibres(picture, random);
  return picture;
}

void check_size(const Eigen::Vector3d& size) {
  if (!size.allFinite() || size.minCoeff() <= 0) {
    throw Error(ErrorCode::invalid_argument, "box: its sides must be positive lengths in metres");
  }
}

}  // namespace

Mesh textured_box(const BoxOptions& options) {
  check_size(options.size);
  if (!(options.texels_per_metre * options.size.maxCoeff() >= 8 &&
        options.texels_per_metre * options.size.maxCoeff() <= 8192)) {
    throw Error(ErrorCode::invalid_argument, "box: texels a metre must give its longest side 8 to 8192 texels");
  }
  return painted_box(options.size, options.texels_per_metre, "carton", [&](int face, cv::Size size) {
    cv::Mat picture = paint_carton(size, options.seed, face);
    const cv::Scalar plain = cv::Scalar(112, 152, 186) * (1.0 - options.contrast);
    cv::Mat faded;
    picture.convertTo(faded, CV_32F, options.contrast);
    cv::add(faded, plain, faded);
    faded.convertTo(picture, CV_8U);
    return picture;
  });
}

Mesh lettered_cube(double edge, std::uint64_t seed) {
  check_size(Eigen::Vector3d::Constant(edge));
  return painted_box(Eigen::Vector3d::Constant(edge), 320.0 / edge, "letters",
                     [&](int face, cv::Size size) { return paint_letter(size, seed, face); });
}

Mesh plain_box(const Eigen::Vector3d& size, const Eigen::Vector3i& rgb) {
  check_size(size);
  Mesh mesh;
  add_faces(mesh, size);
  const auto byte = [](int value) { return static_cast<std::uint8_t>(std::clamp(value, 0, 255)); };
  mesh.colors.assign(mesh.positions.size(), {byte(rgb.x()), byte(rgb.y()), byte(rgb.z()), 255});
  return mesh;
}

}  // namespace holdfast::simulation
