#include "server/telemetry/metrics_endpoint.h"

#include <prometheus/text_serializer.h>

#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

HttpAnswer MetricsText(const std::vector<std::shared_ptr<prometheus::Collectable>>& collectables) {
  std::vector<prometheus::MetricFamily> families;
  for (const auto& collectable : collectables) {
    for (prometheus::MetricFamily& family : collectable->Collect()) {
      families.push_back(std::move(family));
    }
  }
  return {"200 OK", prometheus::TextSerializer().Serialize(families)};
}

HttpAnswer ReadyText(const absl::StatusOr<std::string>& ready) {
  if (ready.ok()) return {"200 OK", absl::StrCat(*ready, "\n")};
  return {"503 Service Unavailable", absl::StrCat(ready.status().message(), "\n")};
}

}  // namespace

absl::StatusOr<ListenAddress> ParseMetricsAddress(absl::string_view text) {
  const bool is_port = !absl::StrContains(text, ":");
  absl::StatusOr<ListenAddress> address =
      ParseListenAddress(is_port ? absl::StrCat("127.0.0.1:", text) : std::string(text));
  if (address.ok()) return address;
  return absl::InvalidArgumentError(
      absl::StrCat("metrics_listen is ", Quoted(text),
                   "; it must be HOST:PORT, or a PORT of 127.0.0.1, in [0, 65535]"));
}

absl::StatusOr<std::unique_ptr<HttpPages>> ServeMetrics(
    const ListenAddress& address,
    std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
    std::function<absl::StatusOr<std::string>()> ready) {
  return HttpPages::Serve(
      address, "metrics_listen",
      {{.path = "/metrics",
        .make = [collectables = std::move(collectables)] { return MetricsText(collectables); }},
       {.path = "/ready",
        .make = [ready = std::move(ready)] { return ReadyText(ready()); },
        .is_urgent = true}});
}

}  // namespace dcloc::server
