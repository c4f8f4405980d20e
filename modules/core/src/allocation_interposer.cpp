// Replaces the C allocation functions in programs that link it; glibc's own do the work. operator new ends in malloc,
// so this counts everything: malloc, calloc, realloc, the aligned family, and C++. Replaces pthread_create too, so that
// threads started by a library count as foreign.
#include <cerrno>
#include <cstddef>
#include <dlfcn.h>
#include <memory>
#include <pthread.h>

#include "kinetrace/core/allocation_counter.hpp"

namespace {

struct ThreadStart {
  void* (*routine)(void*);
  void* argument;
};

void* run_as_foreign(void* given) {
  const kinetrace::ForeignCall foreign;
  const ThreadStart start = *std::unique_ptr<ThreadStart>(static_cast<ThreadStart*>(given));
  return start.routine(start.argument);
}

}  // namespace

// Libraries must find these functions, too: without it posix_memalign and memalign would be hidden, as all that the
// compiler does not know as built-in. libstdc++ 14 gets aligned memory by posix_memalign.
#pragma GCC visibility push(default)
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): glibc's names.
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* block, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

void* malloc(std::size_t bytes) {
  kinetrace::detail::count_allocation();
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
  kinetrace::detail::count_allocation();
  return __libc_calloc(count, bytes);
}
void* realloc(void* block, std::size_t bytes) {
  kinetrace::detail::count_allocation();
  return __libc_realloc(block, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) {
  kinetrace::detail::count_allocation();
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  return memalign(alignment, bytes);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
  void* memory = memalign(alignment, bytes);
  if (memory == nullptr) {
    return ENOMEM;
  }
  *block = memory;
  return 0;
}

// NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name): glibc's own are reserved.
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*routine)(void*), void* argument) {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  if (!kinetrace::detail::in_foreign_call()) {
    return create(thread, attributes, routine, argument);
  }
  auto start = std::make_unique<ThreadStart>(ThreadStart{routine, argument});
  const int error = create(thread, attributes, run_as_foreign, start.get());
  if (error == 0) {
    static_cast<void>(start.release());  // Owned by the thread.
  }
  return error;
}
}
#pragma GCC visibility pop

namespace {
const bool announced = (kinetrace::detail::announce_interposer(), true);
}
