#include "live/realtime.hpp"

#include <cerrno>
#include <cstring>
#include <sched.h>
#include <string>

namespace kinetrace::app {

Status request_realtime(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  if (::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted) == 0) {
    return {};
  }
  const std::string number = std::to_string(priority);
  return fail(ErrorCode::kIo, "live.realtime_priority = " + number + ": " + std::strerror(errno) +
                                  "; allow it with LimitRTPRIO=" + number + " (systemd), ulimit -r " + number +
                                  " or the capability CAP_SYS_NICE");
}

}  // namespace kinetrace::app
