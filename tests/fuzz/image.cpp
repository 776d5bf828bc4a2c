#include "fuzz_file.hpp"
#include "holdfast/io.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace holdfast;
  return fuzz::read_as_file(data, size, [](const std::filesystem::path& path) { (void)io::load_texture(path); });
}
