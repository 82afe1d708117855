#pragma once

#include <mutex>

#include "server/net/health_service.h"

namespace dcloc::server {

/// The status that `grpc.health.v1` reports for the server (the empty name) and for each service.
/// While draining, the server and localization are NOT_SERVING; the map and admin services go on.
/// Thread-safe.
class Health {
 public:
  /// `service` outlives this; the server is well.
  explicit Health(HealthService& service);

  /// Whether it answers new connections.
  void SetAnswering(bool answering);

  /// Whether clients can trust its certificate, which may have expired.
  void SetTrustworthy(bool trustworthy);

  /// For good.
  void SetDraining();

 private:
  void Tell();

  HealthService& service_;
  std::mutex mutex_;
  bool answering_ = true;
  bool trustworthy_ = true;
  bool draining_ = false;
};

}  // namespace dcloc::server
