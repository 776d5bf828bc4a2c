#include "allocation_counter.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

// In a file of their own: where the compiler can inline only one of new and delete it warns of a mismatch.
namespace {

std::atomic<long> g_count{0};

void* allocated(std::size_t size) {
  ++g_count;
  return std::malloc(std::max<std::size_t>(size, 1));
}

void* allocated(std::size_t size, std::align_val_t alignment) {
  ++g_count;
  const auto step = static_cast<std::size_t>(alignment);
  return std::aligned_alloc(step, (std::max<std::size_t>(size, 1) + step - 1) / step * step);
}

void* or_throw(void* memory) {
  if (memory == nullptr) {
    throw std::bad_alloc();
  }
  return memory;
}

}  // namespace

// Those that do not throw too: AddressSanitizer's own, which it would take otherwise, are not for std::free.
void* operator new(std::size_t size) { return or_throw(allocated(size)); }
void* operator new(std::size_t size, std::align_val_t alignment) { return or_throw(allocated(size, alignment)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocated(size); }
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocated(size, alignment);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace holdfast::test {

long operator_new_count() { return g_count; }

}  // namespace holdfast::test
