#include "live/thread_stacks.hpp"

#include <cstring>
#include <pthread.h>
#include <string>
#include <sys/resource.h>

namespace kinetrace::app {

Status limit_thread_stacks() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return {};
#else
  rlimit first_thread{};
  if (::getrlimit(RLIMIT_STACK, &first_thread) == 0 && first_thread.rlim_cur < kThreadStackBytes) {
    return fail(ErrorCode::kIo, "the stack is limited to " + std::to_string(first_thread.rlim_cur / 1024) +
                                    " KiB, and " + std::to_string(kThreadStackBytes / 1024) +
                                    " are needed; raise the limit (ulimit -s)");
  }
  pthread_attr_t attributes;
  int error = pthread_attr_init(&attributes);
  if (error == 0) {
    error = pthread_attr_setstacksize(&attributes, kThreadStackBytes);
    if (error == 0) {
      error = pthread_setattr_default_np(&attributes);
    }
    pthread_attr_destroy(&attributes);
  }
  return error == 0 ? Status{}
                    : fail(ErrorCode::kIo, std::string("stacks of threads cannot be limited: ") + std::strerror(error));
#endif
}

}  // namespace kinetrace::app
