// What is said when something takes long that is usually quick.
#include <doctest/doctest.h>

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>

#include "slow_notice.hpp"
#include "support/files.hpp"

using namespace holdfast::app;
using namespace holdfast::test;

namespace {

using Milliseconds = std::chrono::milliseconds;

struct Stream {
  TemporaryFolder folder;
  std::FILE* file = std::fopen((folder / "stream").c_str(), "w");

  ~Stream() { std::fclose(file); }
  std::string text() const {
    std::fflush(file);
    return read_file(folder / "stream");
  }
};

}  // namespace

TEST_CASE("Said once where it outlasts the patience, not at all where it ends before, and nowhere without a stream") {
  const Stream stream;
  {
    const SlowNotice quick(stream.file, "quick", std::chrono::hours(1));  // and its end does not wait for that
    const SlowNotice nowhere(nullptr, "nowhere", Milliseconds(0));
  }
  CHECK(stream.text().empty());
  std::optional<SlowNotice> slow(std::in_place, stream.file, "slow", Milliseconds(1));
  while (stream.text().empty()) std::this_thread::sleep_for(Milliseconds(1));
  slow.reset();
  CHECK(stream.text() == "holdfast: slow\n");
}

TEST_CASE("Preparing is said to whoever reads standard error as long as no kernels are kept") {
  const TemporaryFolder folder;
  CHECK(preparing_stream(folder / "nowhere") == stderr);
  CHECK(preparing_stream(folder / ".") == stderr);
  folder.write("model.views", "");
  CHECK(preparing_stream(folder / ".") == stderr);
  folder.write("kernels.clbin", "");
  CHECK(preparing_stream(folder / ".") == terminal());
}

TEST_CASE("A camera that pauses is said to, and to deliver again; one that does not is not spoken of") {
  const Stream stream;
  CHECK(read_watched([] { return true; }, stream.file, std::chrono::hours(1)));
  CHECK(stream.text().empty());
  const auto slowly = [&](bool there) {
    return [&stream, there] {
      while (stream.text().empty()) std::this_thread::sleep_for(Milliseconds(1));
      return there;
    };
  };
  CHECK(read_watched(slowly(true), stream.file, Milliseconds(1)));
  CHECK(stream.text() ==
        "holdfast: the camera has delivered nothing for 1 ms\nholdfast: the camera delivers frames again\n");
  const Stream unplugged;
  CHECK_FALSE(read_watched(
      [&] {
        while (unplugged.text().empty()) std::this_thread::sleep_for(Milliseconds(1));
        return false;
      },
      unplugged.file, Milliseconds(1)));
  CHECK(unplugged.text() == "holdfast: the camera has delivered nothing for 1 ms\n");
}
