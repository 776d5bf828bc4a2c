#include <algorithm>
#include <string>

#include "holdfast/error.hpp"
#include "init/click_session.hpp"
#include "modules/window_module.hpp"
#include "window/display.hpp"

namespace holdfast::app {
namespace {

constexpr const char* kTitle = "holdfast init";
constexpr double kTurn = 0.25;  // radians a key press
/// The largest first size of the window: small screens show all of it, and it can be made larger.
constexpr double kFirstWidth = 1200, kFirstHeight = 660;

constexpr const char* kOption = "--click";
constexpr const char* kInstead = "run it where there is one, or give the point pairs by --points";

struct Mouse {
  ClickSession& session;
  bool changed = false;
};

void on_mouse(int event, int x, int y, int, void* data) {
  auto& mouse = *static_cast<Mouse*>(data);
  if (event == cv::EVENT_LBUTTONDOWN) {
    mouse.session.click({x, y});
    mouse.changed = true;
  }
}

/// Closes the window whatever ends the session.
struct WindowCloser {
  const WindowModule& window;
  ~WindowCloser() { window.destroy_all_windows(); }
};

void run(ClickSession& session) {
  const WindowModule& window = window_module();
  window.named_window(kTitle, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO | cv::WINDOW_GUI_NORMAL);
  const WindowCloser closer{window};
  Mouse mouse{session};
  window.set_mouse_callback(kTitle, on_mouse, &mouse);
  const cv::Mat first = session.picture();
  const double scale = std::min({1.0, kFirstWidth / first.cols, kFirstHeight / first.rows});
  window.resize_window(kTitle, static_cast<int>(first.cols * scale), static_cast<int>(first.rows * scale));
  window.show(kTitle, first);
  while (true) {
    const int key = window.wait_key(20) & 0xff;
    switch (key) {
      case '\r':
      case '\n':
        return;
      case 27:  // Esc
        throw Error(ErrorCode::invalid_argument, "--click was given up: no pose was written");
      case 'n':
        session.skip();
        break;
      case 'b':
        session.back();
        break;
      case 'a':
      case 'd':
        session.turn_model(key == 'a' ? -kTurn : kTurn, 0);
        break;
      case 'w':
      case 's':
        session.turn_model(0, key == 'w' ? kTurn : -kTurn);
        break;
      default:
        if (window.window_property(kTitle, cv::WND_PROP_VISIBLE) < 1) {
          throw Error(ErrorCode::invalid_argument, "--click was given up: the window was closed");
        }
        if (!mouse.changed) {
          continue;
        }
    }
    mouse.changed = false;
    window.show(kTitle, session.picture());
  }
}

}  // namespace

void require_display() { require_display(kOption, kInstead); }

std::vector<PointPair> click_points(const cv::Mat& frame, const Mesh& mesh, const std::optional<Camera>& camera) {
  ClickSession session(frame, mesh, camera);
  try {
    run(session);
  } catch (const cv::Exception& error) {
    refuse_without_display(kOption, "a window cannot be opened: " + error.err, kInstead);
  }
  return session.pairs();
}

}  // namespace holdfast::app
