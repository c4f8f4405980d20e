// Separate DDS domains for tests.
#pragma once

#include <atomic>
#include <unistd.h>

namespace kinetrace::test {

/// A new one each time, so that parallel tests do not receive each other's messages.
inline int test_domain() {
  constexpr int kFirst = 20;
  constexpr int kCount = 200;
  static std::atomic<int> made{0};
  return kFirst + (static_cast<int>(::getpid()) * 7 + made.fetch_add(1)) % kCount;
}

}  // namespace kinetrace::test
