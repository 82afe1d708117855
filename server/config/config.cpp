#include "server/config/config.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nlohmann/json.hpp"
#include "server/base/small_file.h"
#include "server/base/status.h"
#include "server/config/config_together.h"
#include "server/net/listen_address.h"
#include "server/telemetry/metrics_endpoint.h"

namespace dcloc::server {
namespace {

using Json = nlohmann::json;

constexpr std::array kFields = {
    ConfigField{"data", "DIR", "folder of the maps; made if it is not there", &ServerConfig::data},
    ConfigField{"catalogue", "URI",
                "PostgreSQL database with PostGIS that several servers share, "
                "postgresql://USER@HOST/DATABASE?sslmode=verify-full, for maps and identities; "
                "none if empty: they are in DIR",
                &ServerConfig::catalogue},
    ConfigField{"map_folder", "DIR",
                "folder of the map files that all servers with one catalogue share",
                &ServerConfig::map_folder},
    ConfigField{"map_files", "URI",
                "object store of the map files that all servers with one catalogue share, "
                "s3://BUCKET/PREFIX, in place of map_folder",
                &ServerConfig::map_files},
    ConfigField{"object_endpoint", "URL",
                "service that has the bucket of map_files, https://HOST:PORT",
                &ServerConfig::object_endpoint},
    ConfigField{"object_region", "NAME", "region of that service", &ServerConfig::object_region},
    ConfigField{"object_credentials", "FILE",
                "access key for that service: lines aws_access_key_id = KEY and "
                "aws_secret_access_key = SECRET, read anew for each request; the environment "
                "(AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY) if empty",
                &ServerConfig::object_credentials},
    ConfigField{"object_ca", "FILE",
                "authority (PEM) that must have signed that service's certificate; those that the "
                "system trusts if empty",
                &ServerConfig::object_ca},
    ConfigField{"object_timeout_ms", "N",
                "how long attempts at a request to that service, and a pause in its body, may take",
                &ServerConfig::object_timeout_ms, 100, 600'000},
    ConfigField{"map_cache", "DIR",
                "folder of copies of the map files that servers share; servers of one user on this "
                "host may have one; DIR/cache if empty",
                &ServerConfig::map_cache},
    ConfigField{"map_cache_mib", "N",
                "size of these copies at most [MiB], the least recently used ones go; 0 for none",
                &ServerConfig::map_cache_mib, 0, 100'000'000},
    ConfigField{"database_connection_count", "N",
                "connections to the database at most; one more waits for changes",
                &ServerConfig::database_connection_count, 1, 100},
    ConfigField{"database_timeout_ms", "N", "how long a statement to the database may take",
                &ServerConfig::database_timeout_ms, 100, 60'000},
    ConfigField{"identity_away_s", "N",
                "how long tokens and certificates that were known to be good hold while the "
                "database is away; 0 for not at all",
                &ServerConfig::identity_away_s, 0, 86'400},
    ConfigField{"listen", "HOST:PORT", "address to listen on; port 0 takes a free one",
                &ServerConfig::listen},
    ConfigField{"replica_address", "HOST[:PORT]",
                "by which other servers with the same catalogue reach this one, the port of listen "
                "without PORT; then each answers operators for all; by itself if empty",
                &ServerConfig::replica_address},
    ConfigField{"replica_ca", "FILE", "authority of the other servers' certificates (PEM)",
                &ServerConfig::replica_ca},
    ConfigField{"replica_cert", "FILE",
                "certificate that is shown to other servers, where they want one (PEM)",
                &ServerConfig::replica_cert},
    ConfigField{"replica_key", "FILE", "its key (PEM)", &ServerConfig::replica_key},
    ConfigField{"replica_timeout_ms", "N", "how long another server may take to answer",
                &ServerConfig::replica_timeout_ms, 100, 10'000},
    ConfigField{
        "metrics_listen", "[HOST:]PORT",
        "serve Prometheus metrics over HTTP there, on 127.0.0.1 without HOST; none if empty",
        &ServerConfig::metrics_listen},
    ConfigField{"tls_cert", "FILE", "the server's certificate chain (PEM)",
                &ServerConfig::tls_cert},
    ConfigField{"tls_key", "FILE", "the certificate's private key (PEM)", &ServerConfig::tls_key},
    ConfigField{"tls_client_ca", "FILE",
                "authority (PEM) that must have signed each client's certificate",
                &ServerConfig::tls_client_ca},
    ConfigField{"allow_plaintext_off_loopback", "",
                "serve without TLS on an address that other machines can reach",
                &ServerConfig::allow_plaintext_off_loopback},
    ConfigField{.key = "stub_localizer",
                .type_name = "",
                .help = "answer without matching, to measure the transport; the poses mean nothing",
                .member = &ServerConfig::stub_localizer,
                .former_key = "stub_matcher"},
    ConfigField{"worker_count", "N", "threads that localize; 0 for one per processor",
                &ServerConfig::worker_count, 0, 1024},
    ConfigField{"require_identity", "",
                "refuse callers without an identity even before the first one is made",
                &ServerConfig::require_identity},
    ConfigField{"keep_worse_canaries", "",
                "do not withdraw the canary of a map when its vehicles are TRACKING less than "
                "those in the active version",
                &ServerConfig::keep_worse_canaries},
    ConfigField{"max_session_count", "N", "open sessions at most", &ServerConfig::max_session_count,
                1, 1'000'000, true},
    ConfigField{
        "max_unopened_stream_count", "N",
        "streams whose first message has not come, at most; beyond it the oldest one of the "
        "peer that has the most is ended. As many other calls, and as many that watch health",
        &ServerConfig::max_unopened_stream_count, 1, 1'000'000, true},
    ConfigField{"max_unopened_stream_count_per_peer", "N",
                "of these, of one address, or of one principal once it is known, at most; 0 for no "
                "limit of its own",
                &ServerConfig::max_unopened_stream_count_per_peer, 0, 1'000'000, true},
    ConfigField{
        "max_connection_count_per_peer", "N",
        "connections of one address at most; 0 for half of those that the file limit allows",
        &ServerConfig::max_connection_count_per_peer, 0, 1'000'000},
    ConfigField{"max_call_rate_hz_per_connection", "N",
                "calls that one connection may begin per second; 0 for no limit",
                &ServerConfig::max_call_rate_hz_per_connection, 0, 1'000'000},
    ConfigField{"open_timeout_ms", "N", "how long a stream's first message may take to come",
                &ServerConfig::open_timeout_ms, 10, 600'000, true},
    ConfigField{
        "peer_timeout_ms", "N",
        "how long a caller may take to send the next message of an upload or a build, or to "
        "read an answer; then the call is ended",
        &ServerConfig::peer_timeout_ms, 100, 3'600'000, true},
    ConfigField{"max_session_count_per_principal", "N",
                "open sessions of one principal at most; 0 for no limit",
                &ServerConfig::max_session_count_per_principal, 0, 1'000'000, true},
    ConfigField{"max_scan_rate_hz_per_principal", "N",
                "scans, and position fixes, per second of one principal at most; 0 for no limit",
                &ServerConfig::max_scan_rate_hz_per_principal, 0, 1'000'000, true},
    ConfigField{"max_download_count", "N", "downloads of maps under way at most",
                &ServerConfig::max_download_count, 1, 100'000, true},
    ConfigField{"max_download_count_per_caller", "N",
                "of these, of one principal, or of one address where callers have none, at most",
                &ServerConfig::max_download_count_per_caller, 1, 100'000, true},
    ConfigField{"max_target_count", "N", "targets of one scan at most",
                &ServerConfig::max_target_count, 1, 20'000, true},
    ConfigField{"max_pending_scan_count", "N",
                "scans of one session that are read but not yet answered, at most",
                &ServerConfig::max_pending_scan_count, 1, 1000},
    ConfigField{"answer_history_count", "N",
                "answers of one session that are kept for scans that come again",
                &ServerConfig::answer_history_count, 1, 100'000},
    ConfigField{"session_detached_timeout_ms", "N",
                "how long a session whose stream has ended waits to be resumed",
                &ServerConfig::session_detached_timeout_ms, 0, 86'400'000},
    ConfigField{"session_idle_timeout_ms", "N",
                "a session that gets no scan for so long is ended; 0 for never",
                &ServerConfig::session_idle_timeout_ms, 0, 86'400'000},
    ConfigField{"ticket_keys", "FILE",
                "the fleet's keys, by which any of its servers goes on with the sessions of one "
                "that is gone: lines \"ID SECRET\", the secret as 64 hexadecimal digits; the first "
                "key seals, all open; read anew every second; no session tickets if empty",
                &ServerConfig::ticket_keys},
    ConfigField{"ticket_lifetime_s", "N", "how long a session ticket can be used",
                &ServerConfig::ticket_lifetime_s, 5, 3600},
    ConfigField{"ticket_interval_ms", "N",
                "time between two tickets of a session, and from which the client keeps scans",
                &ServerConfig::ticket_interval_ms, 200, 5'000},
    ConfigField{"max_message_kib", "N", "size of a message at most [KiB]",
                &ServerConfig::max_message_kib, 512, 65'536},
    ConfigField{"max_map_mib", "N", "size of an uploaded map file at most [MiB]",
                &ServerConfig::max_map_mib, 1, 1'000'000, true},
    ConfigField{
        "pass_key", "FILE",
        "File of the key of the pseudonyms of vehicles whose passes are kept: 64 hexadecimal "
        "digits. Servers that share a catalogue need the same one, and keep no passes without "
        "it; by itself a server makes its own, `pass.key` in its folder",
        &ServerConfig::pass_key},
    ConfigField{"pass_storage_mib", "N", "Of a tenant's passes together, which are then not kept",
                &ServerConfig::pass_storage_mib, 0, 1'000'000'000, true},
    ConfigField{"pass_vehicle_mib_per_day", "N", "Of a vehicle's passes of a day",
                &ServerConfig::pass_vehicle_mib_per_day, 0, 1'000'000, true},
    ConfigField{"pass_retention_days", "N", "How long a pass is kept",
                &ServerConfig::pass_retention_days, 1, 3650, true},
    ConfigField{"max_tenant_storage_mib", "N",
                "size of a tenant's map versions together at most [MiB]; 0 for no limit",
                &ServerConfig::max_tenant_storage_mib, 0, 1'000'000'000, true},
    ConfigField{"warm_map_mib", "N",
                "size of the maps at most that stay in memory for new sessions to get though none "
                "uses them [MiB]; 0 for none",
                &ServerConfig::warm_map_mib, 0, 1'000'000},
    ConfigField{
        "unfinished_upload_timeout_s", "N",
        "how long an unfinished upload is kept, in time that the server runs, so that it can be "
        "completed",
        &ServerConfig::unfinished_upload_timeout_s, 1, 31'536'000},
    ConfigField{
        "quarantine_days", "N",
        "how long map files that belong to no version are kept in DIR/quarantine, in time that the "
        "server runs; 0 for good",
        &ServerConfig::quarantine_days, 0, 36'500},
    ConfigField{"scrub_mb_per_s", "N",
                "how fast map files are read again and again against their hashes, to find damage "
                "before a vehicle does [MB/s]; 0 for not at all",
                &ServerConfig::scrub_mb_per_s, 0, 10'000},
    ConfigField{"shutdown_deadline_ms", "N",
                "how long open calls may take to end when the server stops",
                &ServerConfig::shutdown_deadline_ms, 0, 600'000},
    ConfigField{"self_probe_interval_ms", "N",
                "how often the server tries a new connection to itself; 0 for never",
                &ServerConfig::self_probe_interval_ms, 0, 3'600'000},
    ConfigField{
        "drain_notice_ms", "N",
        "how long a server that drains or stops still takes sessions while it says that it is "
        "not ready, so that a router sends none here by the time vehicles are told to move",
        &ServerConfig::drain_notice_ms, 0, 600'000},
    ConfigField{"drain_grace_ms", "N",
                "how long clients may take to move once the server drains or stops",
                &ServerConfig::drain_grace_ms, 0, 600'000},
    ConfigField{"log_level", "LEVEL", "debug, info, warn or error", &ServerConfig::log_level, 0, 0,
                true},
    ConfigField{"log_format", "FORMAT", "text or json, a line each", &ServerConfig::log_format},
};

constexpr std::array kLogLevels = {"debug", "info", "warn", "error"};

const ConfigField* FindField(const std::string& key) {
  const auto* field = std::ranges::find_if(kFields, [&key](const ConfigField& candidate) {
    return key == candidate.key || (!key.empty() && key == candidate.former_key);
  });
  return field == kFields.end() ? nullptr : field;
}

absl::Status Expected(const std::string& key, const Json& value, const char* what) {
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %s; it must be %s", key, value.dump(), what));
}

absl::Status Take(const std::string& key, const Json& value, ServerConfig* config) {
  const ConfigField* field = FindField(key);
  if (field == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrFormat("key %s (value %s) is unknown", Quoted(key), value.dump()));
  }
  if (const auto* text = std::get_if<std::string ServerConfig::*>(&field->member)) {
    if (!value.is_string()) return Expected(key, value, "a string");
    config->*(*text) = value.get<std::string>();
  } else if (const auto* flag = std::get_if<bool ServerConfig::*>(&field->member)) {
    if (!value.is_boolean()) return Expected(key, value, "true or false");
    config->*(*flag) = value.get<bool>();
  } else {
    // Compared as a double, since an integer of JSON may be larger than any of ours.
    if (!value.is_number_integer() || value.get<double>() < field->min ||
        value.get<double>() > field->max) {
      return Expected(key, value,
                      absl::StrFormat("an integer in [%d, %d]", field->min, field->max).c_str());
    }
    config->*std::get<int ServerConfig::*>(field->member) = value.get<int>();
  }
  return absl::OkStatus();
}

absl::StatusOr<Json> ParseFile(const std::filesystem::path& path) {
  const absl::StatusOr<std::string> text = ReadSmallFile(path);
  if (!text.ok()) return text.status();
  std::set<std::string> keys;
  std::string repeated;
  const auto note = [&](int depth, Json::parse_event_t event, const Json& parsed) {
    if (depth == 1 && event == Json::parse_event_t::key) {
      const auto key = parsed.get<std::string>();
      if (!keys.insert(key).second) repeated = key;
    }
    return true;
  };
  try {
    Json json = Json::parse(*text, note);
    if (repeated.empty()) return json;
    return absl::InvalidArgumentError(
        absl::StrCat(path.string(), ": key ", Quoted(repeated), " is there more than once"));
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": ", error.what()));
  }
}

}  // namespace

std::span<const ConfigField> ConfigFields() { return kFields; }

std::vector<const ConfigField*> ChangedFields(const ServerConfig& before,
                                              const ServerConfig& after) {
  std::vector<const ConfigField*> changed;
  for (const ConfigField& field : kFields) {
    const bool same =
        std::visit([&](auto member) { return before.*member == after.*member; }, field.member);
    if (!same) changed.push_back(&field);
  }
  return changed;
}

void TakeField(const ConfigField& field, const ServerConfig& from, ServerConfig* to) {
  std::visit([&](auto member) { to->*member = from.*member; }, field.member);
}

absl::Status ReadConfigFile(const std::filesystem::path& path, ServerConfig* config) {
  const absl::StatusOr<Json> json = ParseFile(path);
  if (!json.ok()) return json.status();
  const std::string prefix = absl::StrCat(path.string(), ": ");
  if (!json->is_object()) return WithPrefix(prefix, Expected("the file", *json, "an object"));
  for (const auto& [key, value] : json->items()) {
    if (absl::Status status = Take(key, value, config); !status.ok()) {
      return WithPrefix(prefix, status);
    }
  }
  return absl::OkStatus();
}

absl::Status Validate(const ServerConfig& config) {
  if (config.data.empty()) {
    return absl::InvalidArgumentError("data is empty; it must name the folder of the maps");
  }
  if (absl::Status status = ParseListenAddress(config.listen).status(); !status.ok()) {
    return status;
  }
  if (!config.metrics_listen.empty()) {
    absl::Status status = ParseMetricsAddress(config.metrics_listen).status();
    if (!status.ok()) return status;
  }
  for (const ConfigField& field : kFields) {
    const auto* member = std::get_if<int ServerConfig::*>(&field.member);
    if (member == nullptr) continue;
    const int value = config.*(*member);
    if (value < field.min || value > field.max) {
      return absl::InvalidArgumentError(absl::StrFormat("%s is %d; it must lie in [%d, %d]",
                                                        field.key, value, field.min, field.max));
    }
  }
  if (std::ranges::find(kLogLevels, config.log_level) == kLogLevels.end()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "log_level is %s; it must be debug, info, warn or error", Quoted(config.log_level)));
  }
  if (config.log_format != "text" && config.log_format != "json") {
    return absl::InvalidArgumentError(
        absl::StrFormat("log_format is %s; it must be text or json", Quoted(config.log_format)));
  }
  return ValidateTogether(config);
}

}  // namespace dcloc::server
