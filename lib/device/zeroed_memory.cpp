#include "device/zeroed_memory.hpp"

#include <cstdint>
#include <cstdlib>
#include <new>

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

namespace holdfast {
namespace {

constexpr std::size_t kPage = 4096, kLargePage = std::size_t{2} << 20;

/// The first address from `memory` on that is a multiple of `alignment`.
void* aligned(void* memory, std::size_t alignment) {
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  return static_cast<char*>(memory) + (alignment - address % alignment) % alignment;
}

}  // namespace

#ifdef MADV_HUGEPAGE
// Mapped, not from the heap, whose freed parts would have to be cleared and so touched. Large pages, where there are
// such, are touched less often: the first frame that covers them waits less.
ZeroedMemory::ZeroedMemory(std::size_t bytes) : mapped_bytes_(bytes + kLargePage) {
  mapped_ = mmap(nullptr, mapped_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped_ == MAP_FAILED) throw std::bad_alloc();
  data_ = aligned(mapped_, bytes >= kLargePage ? kLargePage : kPage);
  if (bytes >= kLargePage) madvise(data_, bytes, MADV_HUGEPAGE);  // a wish: that it fails changes nothing
}

ZeroedMemory::~ZeroedMemory() { munmap(mapped_, mapped_bytes_); }
#else
ZeroedMemory::ZeroedMemory(std::size_t bytes) : mapped_bytes_(bytes + kPage) {
  mapped_ = std::calloc(mapped_bytes_, 1);
  if (mapped_ == nullptr) throw std::bad_alloc();
  data_ = aligned(mapped_, kPage);
}

ZeroedMemory::~ZeroedMemory() { std::free(mapped_); }
#endif

}  // namespace holdfast
