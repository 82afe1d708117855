#include "server/net/liveness.h"

#include <utility>

#include "server/base/status.h"
#include "server/net/service_manager.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kFailuresThatCount = 2;

}  // namespace

Liveness::Liveness(std::function<absl::Status()> probe, std::function<void(bool ok)> report)
    : probe_(std::move(probe)), report_(std::move(report)) {}

void Liveness::Check() {
  const absl::Status status = probe_();
  if (status.ok()) {
    failure_count_ = 0;
    NotifyServiceManager("WATCHDOG=1");
    if (ok_.exchange(true)) return;
    spdlog::info("own connections are answered again");
    report_(true);
  } else if (++failure_count_ == kFailuresThatCount) {
    ok_ = false;
    spdlog::error("own connections are not answered reason={}", Quoted(status.message()));
    report_(false);
  }
}

}  // namespace dcloc::server
