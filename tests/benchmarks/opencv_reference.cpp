#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "benchmarks.hpp"
#include "median.hpp"

namespace holdfast::bench {
namespace {

/// A frame and a rendered view, as floats, and where their filtered versions go: allocated once.
struct Images {
  explicit Images(cv::Size size) {
    for (Filtered& image : filtered) {
      image.input.create(size, CV_32FC3);
      cv::randu(image.input, 0.0, 1.0);
    }
  }
  struct Filtered {
    cv::Mat input, blurred, dx, dy;
  };
  std::array<Filtered, 2> filtered;
};

void blur_and_differentiate(benchmark::State& state, Images& images) {
  std::vector<double> milliseconds;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    for (Images::Filtered& image : images.filtered) {
      cv::GaussianBlur(image.input, image.blurred, cv::Size(5, 5), 1.0);
      cv::Scharr(image.blurred, image.dx, CV_32F, 1, 0, 1.0 / 32);
      cv::Scharr(image.blurred, image.dy, CV_32F, 0, 1, 1.0 / 32);
    }
    benchmark::DoNotOptimize(images.filtered[1].dy.data);
    benchmark::ClobberMemory();
    milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  state.counters["frame_ms"] = median(milliseconds);
}

}  // namespace

void register_opencv_reference() {
  for (const FrameSize& size : kFrameSizes) {
    const auto images = std::make_shared<Images>(cv::Size(size.width, size.height));
    benchmark::RegisterBenchmark(("opencv/" + size.name()).c_str(),
                                 [images](benchmark::State& state) { blur_and_differentiate(state, *images); })
        ->UseRealTime()
        ->MeasureProcessCPUTime()
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace holdfast::bench
