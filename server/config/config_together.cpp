#include "server/config/config_together.h"

#include "absl/strings/str_format.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

absl::Status ValidateTls(const ServerConfig& config) {
  if (config.tls_cert.empty() != config.tls_key.empty()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("tls_cert is %s and tls_key is %s; one needs the other",
                        Quoted(config.tls_cert), Quoted(config.tls_key)));
  }
  if (config.tls_cert.empty() && !config.tls_client_ca.empty()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "tls_client_ca is %s; it needs tls_cert and tls_key", Quoted(config.tls_client_ca)));
  }
  return absl::OkStatus();
}

absl::Status ValidateReplicas(const ServerConfig& config) {
  if (config.replica_address.empty()) return absl::OkStatus();
  if (config.catalogue.empty()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("replica_address is %s and catalogue is empty; others know a server by a "
                        "catalogue that they share",
                        Quoted(config.replica_address)));
  }
  if (!config.tls_cert.empty() && config.replica_ca.empty()) {
    return absl::InvalidArgumentError(
        "replica_ca is empty; with tls_cert it must name the authority of the other servers' "
        "certificates");
  }
  if (config.replica_cert.empty() != config.replica_key.empty()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("replica_cert is %s and replica_key is %s; one needs the other",
                        Quoted(config.replica_cert), Quoted(config.replica_key)));
  }
  return absl::OkStatus();
}

absl::Status ValidateMapFiles(const ServerConfig& config) {
  if (config.map_files.empty() && config.object_endpoint.empty()) return absl::OkStatus();
  if (config.map_files.empty()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("object_endpoint is %s and map_files is empty; one needs the other",
                        Quoted(config.object_endpoint)));
  }
  if (absl::Status status = Validate(ObjectOptionsOf(config)); !status.ok()) return status;
  constexpr int kMaxMap_mib = static_cast<int>(kMaxObject_bytes >> 20);
  if (config.max_map_mib <= kMaxMap_mib) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("max_map_mib is %d; with map_files in an object store it must be at most %d",
                      config.max_map_mib, kMaxMap_mib));
}

absl::Status ValidateCatalogue(const ServerConfig& config) {
  if (!config.map_folder.empty() && !config.map_files.empty()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("map_folder is %s and map_files is %s; only one can be there",
                        Quoted(config.map_folder), Quoted(config.map_files)));
  }
  if (config.catalogue.empty() != (config.map_folder.empty() && config.map_files.empty())) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "catalogue is %s, map_folder is %s and map_files is %s; one needs one of the others",
        config.catalogue.empty() ? "empty" : "there", Quoted(config.map_folder),
        Quoted(config.map_files)));
  }
  if (absl::Status status = ValidateMapFiles(config); !status.ok()) return status;
  return config.catalogue.empty() ? absl::OkStatus() : Validate(DatabaseOptionsOf(config));
}

}  // namespace

absl::Status ValidateTogether(const ServerConfig& config) {
  if (absl::Status status = ValidateCatalogue(config); !status.ok()) return status;
  if (absl::Status status = ValidateReplicas(config); !status.ok()) return status;
  return ValidateTls(config);
}

PostgresOptions DatabaseOptionsOf(const ServerConfig& config) {
  return {.address = config.catalogue,
          .max_connection_count = config.database_connection_count,
          .statement_timeout = std::chrono::milliseconds(config.database_timeout_ms),
          .connect_timeout = std::chrono::milliseconds(config.database_timeout_ms)};
}

ObjectOptions ObjectOptionsOf(const ServerConfig& config) {
  return {.location = config.map_files,
          .endpoint = config.object_endpoint,
          .region = config.object_region,
          .credentials_file = config.object_credentials,
          .ca_file = config.object_ca,
          .timeout = std::chrono::milliseconds(config.object_timeout_ms)};
}

}  // namespace dcloc::server
