#pragma once

#include <cstddef>

namespace holdfast {

/// Memory full of zeros that takes room only where it is touched, from the start of a page on.
class ZeroedMemory {
 public:
  /// Throws std::bad_alloc.
  explicit ZeroedMemory(std::size_t bytes);
  ~ZeroedMemory();
  ZeroedMemory(const ZeroedMemory&) = delete;
  ZeroedMemory& operator=(const ZeroedMemory&) = delete;

  void* data() const { return data_; }

 private:
  void* mapped_;  ///< as the system or the heap gave it
  std::size_t mapped_bytes_;
  void* data_;
};

}  // namespace holdfast
