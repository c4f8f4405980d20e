// Domains of DDS that tests have for themselves.
#pragma once

#include <atomic>
#include <unistd.h>

namespace kinetrace::test {

/// Another one each time, so that tests that run side by side do not hear each other.
inline int test_domain() {
  constexpr int kFirst = 20;
  constexpr int kCount = 200;
  static std::atomic<int> made{0};
  return kFirst + (static_cast<int>(::getpid()) * 7 + made.fetch_add(1)) % kCount;
}

}  // namespace kinetrace::test
