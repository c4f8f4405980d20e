// The one block of working memory, taken at start and divided among the modules.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// A bump allocator over one block. It never grows and never frees single pieces.
///
/// A *measuring* arena holds no memory: it returns empty spans and only counts. Each module declares its storage once,
/// as a function that carves from an Arena, and runs it on a measuring arena for `required_bytes` and on the real one
/// in `create`; so plan and use cannot differ.
class KINETRACE_API Arena {
 public:
  static constexpr std::size_t kAlignment = 64;  ///< A cache line, and enough for every vector type in use.

  /// An arena that counts and holds nothing.
  Arena() = default;

  /// Takes `capacity_bytes` from the system at once and touches every page, so that later use cannot fail for lack of
  /// memory. Throws std::bad_alloc if the system refuses; only an application calls this, at start.
  explicit Arena(std::size_t capacity_bytes);

  [[nodiscard]] bool measuring() const noexcept { return block_ == nullptr; }
  [[nodiscard]] std::size_t capacity_bytes() const noexcept { return capacity_bytes_; }
  [[nodiscard]] std::size_t used_bytes() const noexcept { return used_bytes_; }
  /// True once a request did not fit. `create` functions check it after carving and report ErrorCode::kCapacity.
  [[nodiscard]] bool exhausted() const noexcept { return exhausted_; }

  /// `count` value-initialised objects of a trivially destructible type. Empty when measuring or exhausted.
  template <typename T>
  [[nodiscard]] std::span<T> take(std::size_t count) noexcept(std::is_nothrow_default_constructible_v<T>) {
    static_assert(std::is_trivially_destructible_v<T>, "an arena never runs destructors");
    static_assert(alignof(T) <= kAlignment);
    std::byte* memory = reserve(count, sizeof(T));
    if (memory == nullptr) {
      return {};
    }
    T* first = reinterpret_cast<T*>(memory);
    std::uninitialized_value_construct_n(first, count);
    return {first, count};
  }

 private:
  std::byte* reserve(std::size_t count, std::size_t element_bytes) noexcept;

  struct Free {
    void operator()(std::byte* block) const noexcept { ::operator delete (block, std::align_val_t{kAlignment}); }
  };
  std::unique_ptr<std::byte, Free> block_;
  std::size_t capacity_bytes_ = 0;
  std::size_t used_bytes_ = 0;
  bool exhausted_ = false;
};

/// Bytes that `carve(arena)` takes: runs it on a measuring arena.
template <typename Carve>
[[nodiscard]] std::size_t measure_bytes(Carve&& carve) {
  Arena arena;
  std::forward<Carve>(carve)(arena);
  return arena.used_bytes();
}

}  // namespace kinetrace
