#include "server/net/health.h"

#include <utility>

#include "dcloc/v1/admin_service.grpc.pb.h"
#include "dcloc/v1/localization_service.grpc.pb.h"
#include "dcloc/v1/map_service.grpc.pb.h"

namespace dcloc::server {

Health::Health(HealthService& service) : service_(service) { Tell(); }

void Health::SetAnswering(bool answering) {
  const std::lock_guard lock(mutex_);
  answering_ = answering;
  Tell();
}

void Health::SetTrustworthy(bool trustworthy) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(trustworthy_, trustworthy) != trustworthy) Tell();
}

void Health::SetDraining() {
  const std::lock_guard lock(mutex_);
  draining_ = true;
  Tell();
}

void Health::Tell() {
  for (const char* service : {"", v1::LocalizationService::service_full_name()}) {
    service_.SetServing(service, answering_ && trustworthy_ && !draining_);
  }
  for (const char* service :
       {v1::MapService::service_full_name(), v1::AdminService::service_full_name()}) {
    service_.SetServing(service, answering_ && trustworthy_);
  }
}

}  // namespace dcloc::server
