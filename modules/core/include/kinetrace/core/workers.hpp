// Work in parts, possibly in parallel. Modules own no threads; the application lends them.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <type_traits>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// Reference to a callable that takes the number of a worker; allocates nothing.
class Job {
 public:
  template <typename Callable>
  requires(!std::is_same_v<std::remove_cvref_t<Callable>, Job>) explicit Job(Callable& callable) noexcept
      : callable_(&callable),
        call_([](void* target, std::size_t worker) { (*static_cast<Callable*>(target))(worker); }) {}

  void operator()(std::size_t worker) const { call_(callable_, worker); }

 private:
  void* callable_;
  void (*call_)(void*, std::size_t);
};

/// A set of workers. Results must not depend on their number.
class KINETRACE_API Workers {
 public:
  Workers() = default;
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  Workers(Workers&&) = delete;
  Workers& operator=(Workers&&) = delete;
  virtual ~Workers() = default;

  /// Calls the job once for each worker, the caller being one of them, and returns when all have returned. Not to be
  /// called concurrently.
  virtual void run(Job job) noexcept = 0;
};

/// Calls `work(begin, end)` for pieces of [0, count) of at most `piece`, each once, in no order; a null `workers` or a
/// single piece: once for all, by the caller alone.
template <typename Work>
void in_pieces(Workers* workers, std::size_t count, std::size_t piece, Work&& work) {
  if (workers == nullptr || count <= piece) {
    work(std::size_t{0}, count);
    return;
  }
  std::atomic<std::size_t> next{0};
  auto take_pieces = [&](std::size_t /*worker*/) {
    for (;;) {
      const std::size_t begin = next.fetch_add(piece, std::memory_order_relaxed);
      if (begin >= count) {
        return;
      }
      work(begin, std::min(count, begin + piece));
    }
  };
  workers->run(Job(take_pieces));
}

}  // namespace kinetrace
