#include "client/cli/common/stop_signals.h"

#include <ctime>
#include <utility>

namespace dcloc::cli {

StopSignals::StopSignals() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &previous_);
}

StopSignals::~StopSignals() { pthread_sigmask(SIG_SETMASK, &previous_, nullptr); }

std::jthread StopSignals::Watch(std::function<void(int)> on_signal) const {
  return std::jthread(
      [signals = signals_, on_signal = std::move(on_signal)](const std::stop_token& stop) {
        constexpr timespec kPoll{.tv_sec = 0, .tv_nsec = 50'000'000};
        for (int count = 0; !stop.stop_requested();) {
          if (sigtimedwait(&signals, nullptr, &kPoll) > 0) on_signal(++count);
        }
      });
}

}  // namespace dcloc::cli
