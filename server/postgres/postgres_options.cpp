#include "server/postgres/postgres_options.h"

#include <libpq-fe.h>

#include <map>
#include <memory>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

using Parameters = std::map<std::string, std::string>;

struct FreeOptions {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};

/// Those that the address itself gives; none when it is malformed.
Parameters ParametersOf(const std::string& address) {
  char* error = nullptr;
  const std::unique_ptr<PQconninfoOption, FreeOptions> options(
      PQconninfoParse(address.c_str(), &error));
  PQfreemem(error);
  Parameters parameters;
  if (options == nullptr) return parameters;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val != nullptr) parameters[option->keyword] = option->val;
  }
  return parameters;
}

std::string ValueOf(const Parameters& parameters, const std::string& key) {
  const auto entry = parameters.find(key);
  return entry == parameters.end() ? "" : entry->second;
}

/// Of a list of hosts, one that another machine may listen between us and.
std::string RemoteHostOf(const Parameters& parameters) {
  for (const char* key : {"host", "hostaddr"}) {
    for (const auto host : absl::StrSplit(ValueOf(parameters, key), ',', absl::SkipEmpty())) {
      const bool socket = absl::StartsWith(host, "/") || absl::StartsWith(host, "@");
      const bool loopback = host == "localhost" || host == "::1" || absl::StartsWith(host, "127.");
      if (!socket && !loopback) return std::string(host);
    }
  }
  return "";
}

}  // namespace

bool IsPostgresAddress(absl::string_view location) {
  return absl::StartsWith(location, "postgresql://") || absl::StartsWith(location, "postgres://");
}

absl::Status Validate(const PostgresOptions& options) {
  const Parameters parameters = ParametersOf(options.address);
  if (!IsPostgresAddress(options.address) || parameters.empty()) {
    return absl::InvalidArgumentError(
        "catalogue is no address of a database; it must be of the form "
        "postgresql://USER@HOST/DATABASE?sslmode=verify-full");
  }
  if (parameters.contains("password") || parameters.contains("sslpassword")) {
    return absl::InvalidArgumentError(
        "catalogue has a password, which others on the machine can read; name a file with "
        "\"passfile=FILE\" in the address or in PGPASSFILE, or set PGPASSWORD");
  }
  const std::string remote = RemoteHostOf(parameters);
  if (!remote.empty() && !parameters.contains("sslmode")) {
    return absl::InvalidArgumentError(absl::StrCat(
        "catalogue is on another machine, ", Quoted(remote),
        ", and has no sslmode; it must say one: verify-full, or another one knowingly"));
  }
  if (options.max_connection_count < 1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "max_connection_count is %d; it must be at least 1", options.max_connection_count));
  }
  return absl::OkStatus();
}

std::string ShownAddress(const std::string& address) {
  const Parameters parameters = ParametersOf(address);
  const std::string port = ValueOf(parameters, "port");
  return absl::StrCat(ValueOf(parameters, "user"), "@", ValueOf(parameters, "host"),
                      port.empty() ? "" : ":", port, "/", ValueOf(parameters, "dbname"));
}

}  // namespace dcloc::server
