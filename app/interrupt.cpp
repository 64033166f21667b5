#include "app/interrupt.hpp"

#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <thread>

namespace modsearch::app {

std::stop_token stop_on_interrupt() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // inherited by every thread, so only sigwait sees them

  std::stop_source source;
  std::stop_token token = source.get_token();
  std::thread{[signals, source]() mutable {
    int signal = 0;
    sigwait(&signals, &signal);
    source.request_stop();
    sigwait(&signals, &signal);
    constexpr int kInterrupted = 130;
    _exit(kInterrupted);
  }}.detach();
  return token;
}

}  // namespace modsearch::app
