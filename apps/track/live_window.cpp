#include "track/live_window.hpp"

#include <fmt/format.h>

#include "init/check_picture.hpp"
#include "messages.hpp"
#include "modules/window_module.hpp"
#include "window/display.hpp"

namespace holdfast::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kTitle = "holdfast track";
constexpr const char* kKeys = "space pause  . step  c pixels  l look again  s save  q quit";
constexpr int kPoll = 10;  // milliseconds
constexpr double kRateMemory = 0.1;

}  // namespace

LiveWindow::LiveWindow(const Mesh& mesh, const Camera& camera, double frame_rate)
    : overlay_(mesh, camera),
      least_time_(frame_rate > 0 ? 1 / frame_rate : 0),
      last_(Clock::now()),
      last_drawn_(last_) {
  const WindowModule& window = window_module();
  try {
    window.named_window(kTitle, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO | cv::WINDOW_GUI_NORMAL);
    const cv::Size size = overlay_.window_size();
    window.resize_window(kTitle, size.width, size.height);
  } catch (const cv::Exception& error) {
    refuse_without_display("--show", "a window cannot be opened: " + error.err, "run it where there is one");
  }
}

LiveWindow::~LiveWindow() { window_module().destroy_all_windows(); }

void LiveWindow::draw(const TrackedFrame& tracked) {
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - last_drawn_).count();
  last_drawn_ = now;
  if (seconds > 0) rate_ += (rate_ > 0 ? kRateMemory : 1) * (1 / seconds - rate_);
  const cv::Mat& picture =
      overlay_.window_picture(tracked, decisions_, fmt::format("{:.0f} frames a second   {}", rate_, kKeys));
  const std::lock_guard lock(mutex_);
  picture.copyTo(drawn_);
  drawn_frame_ = tracked.frame.index;
  fresh_ = true;
}

void LiveWindow::show() {
  {
    const std::lock_guard lock(mutex_);
    if (!fresh_) return;
    std::swap(drawn_, shown_);
    shown_frame_ = drawn_frame_;
    fresh_ = false;
  }
  window_module().show(kTitle, shown_);
}

void LiveWindow::save() {
  if (shown_.empty()) return;
  const std::string path = fmt::format("holdfast-{:06}.png", shown_frame_);
  save_picture(path, shown_);
  print_note("the picture is saved to " + path);
}

void LiveWindow::obey(int key) {
  switch (key & 0xff) {
    case ' ':
      paused_ = !paused_;
      break;
    case '.':
      paused_ = step_ = true;
      break;
    case 'c':
      decisions_ = !decisions_;
      break;
    case 'l':
      look_again_ = true;
      break;
    case 's':
      save();
      break;
    case 'q':
    case 27:  // Esc
      quits_ = true;
      break;
    default:
      break;
  }
}

void LiveWindow::update(const std::function<bool()>& interrupted) {
  const WindowModule& window = window_module();
  while (true) {
    show();
    const double left = std::chrono::duration<double>(last_ + least_time_ - Clock::now()).count();
    const int wait = left > 0 || paused_ ? kPoll : 1;
    if (const int key = window.wait_key(wait); key >= 0) obey(key);
    if (!shown_.empty() && window.window_property(kTitle, cv::WND_PROP_VISIBLE) < 1) quits_ = true;
    if (quits_ || interrupted() || std::exchange(step_, false)) break;
    if (!paused_ && left <= 0) break;
  }
  last_ = Clock::now();
}

}  // namespace holdfast::app
