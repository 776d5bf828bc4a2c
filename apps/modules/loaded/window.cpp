#include "holdfast/export.hpp"
#include "modules/window_module.hpp"

extern "C" {
HOLDFAST_EXPORT extern const holdfast::app::WindowModule holdfast_window;
const holdfast::app::WindowModule holdfast_window{cv::namedWindow,      cv::resizeWindow, cv::setMouseCallback,
                                                  cv::imshow,           cv::waitKey,      cv::getWindowProperty,
                                                  cv::destroyAllWindows};
}
