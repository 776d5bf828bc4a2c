// make_video PATTERN VIDEO: pictures as a video.
#include <opencv2/videoio.hpp>

int main(int count, char** arguments) {
  if (count != 3) return 2;
  cv::VideoCapture pictures(arguments[1], cv::CAP_IMAGES);
  cv::VideoWriter video;
  for (cv::Mat frame; pictures.read(frame); video.write(frame)) {
    if (!video.isOpened()) video.open(arguments[2], cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 30, frame.size());
  }
  return video.isOpened() ? 0 : 1;
}
