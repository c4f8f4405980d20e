#include "cli/interrupt.hpp"

#include <csignal>
#include <initializer_list>

namespace kinetrace::app {
namespace {

volatile std::sig_atomic_t received = 0;

void remember(int signal) {
  received = signal;
}

}  // namespace

void catch_interrupts() noexcept {
  struct sigaction action {};
  action.sa_handler = remember;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGALRM, SIGUSR1, SIGUSR2, SIGXCPU}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    // Ctrl-C must work even if a shell started the program in the background with SIGINT ignored.
    if (signal == SIGINT || before.sa_handler != SIG_IGN) {
      sigaction(signal, &action, nullptr);
    }
  }
}

int interrupted_by() noexcept {
  return received;
}

}  // namespace kinetrace::app
