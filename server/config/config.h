#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "server/objects/object_options.h"
#include "server/postgres/postgres_options.h"

namespace dcloc::server {

/// How a server is set up. Defaults are here and nowhere else.
struct ServerConfig {
  std::string data;             ///< folder of the embedded store
  std::string catalogue;        ///< "postgresql://..."; empty: the embedded one
  std::string map_folder;       ///< of map files that servers with one catalogue share
  std::string map_files;        ///< "s3://BUCKET/PREFIX", in place of such a folder
  std::string object_endpoint;  ///< "https://HOST:PORT" of the bucket's service
  std::string object_region = "us-east-1";
  std::string object_credentials;          ///< file of an access key; empty: the environment
  std::string object_ca;                   ///< PEM; empty: the authorities that the system trusts
  int object_timeout_ms = 10'000;          ///< of a request, but for its body
  std::string map_cache;                   ///< folder; empty: `cache` in `data`
  int map_cache_mib = 4096;                ///< of copies of map files that servers share; 0: none
  int database_connection_count = 4;       ///< for statements, at most
  int database_timeout_ms = 2000;          ///< of a statement
  int identity_away_s = 900;               ///< known identities hold so long without the database
  std::string listen = "127.0.0.1:50051";  ///< HOST:PORT; port 0 takes a free one
  std::string replica_address;             ///< by which other servers reach this; empty: not known
  std::string replica_ca;                  ///< PEM files for calls to other servers
  std::string replica_cert;
  std::string replica_key;
  int replica_timeout_ms = 2000;  ///< of a call to another server
  std::string metrics_listen;     ///< HOST:PORT or PORT of HTTP; empty: no metrics

  std::string tls_cert;  ///< PEM files; without a certificate the server speaks plaintext
  std::string tls_key;
  std::string tls_client_ca;  ///< clients must show a certificate that this authority signed
  bool allow_plaintext_off_loopback = false;

  bool stub_localizer = false;
  int worker_count = 0;           ///< threads that localize; 0: one per processor
  bool require_identity = false;  ///< refuse callers without one, even before the first is created

  bool keep_worse_canaries = false;  ///< do not withdraw a canary whose vehicles track less

  int max_session_count = 1000;
  int max_unopened_stream_count = 1000;          ///< streams whose first message has not come
  int max_unopened_stream_count_per_peer = 200;  ///< of an address or principal; 0: no own limit
  int max_connection_count_per_peer = 0;         ///< of an address; 0: half of what the files allow
  int max_call_rate_hz_per_connection = 2000;    ///< 0: no limit
  int open_timeout_ms = 10'000;                  ///< of a stream, for its first message
  int peer_timeout_ms = 60'000;                  ///< of a peer that does not send, or does not read
  int max_session_count_per_principal = 0;       ///< 0: no limit of its own
  int max_scan_rate_hz_per_principal = 0;        ///< over all of its sessions; 0: no limit
  int max_download_count = 256;                  ///< under way
  int max_download_count_per_caller = 32;        ///< of a principal, else of an address
  int max_target_count = 20'000;                 ///< of one scan
  int max_pending_scan_count = 8;                ///< per session, read but not yet answered
  int answer_history_count = 256;                ///< per session, for scans that come again
  int session_detached_timeout_ms = 60'000;
  int session_idle_timeout_ms = 600'000;  ///< 0: for ever
  std::string ticket_keys;                ///< file of the fleet's keys; empty: no tickets
  int ticket_lifetime_s = 60;             ///< how long a ticket can be used
  int ticket_interval_ms = 1000;          ///< between two tickets of a session
  int max_message_kib = 2048;
  int max_map_mib = 1024;              ///< of one map file
  std::string pass_key;                ///< file of the pseudonyms' key; empty: `pass.key` in `data`
  int pass_storage_mib = 1024;         ///< of a tenant's passes together
  int pass_vehicle_mib_per_day = 256;  ///< of a vehicle's passes
  int pass_retention_days = 30;        ///< of passes
  int max_tenant_storage_mib = 0;      ///< of a tenant's map versions together; 0: no limit
  int warm_map_mib = 1024;  ///< of maps that stay in memory without a session; 0: none do
  int unfinished_upload_timeout_s = 86'400;  ///< then bytes of an interrupted upload are removed
  int quarantine_days = 30;  ///< of map files without a version; 0: they are kept for good
  int scrub_mb_per_s = 20;   ///< of map files that are read to see whether they are whole; 0: none
  int shutdown_deadline_ms = 5000;
  int self_probe_interval_ms = 5000;  ///< 0: never
  int drain_notice_ms = 0;
  int drain_grace_ms = 1000;
  std::string log_level = "info";
  std::string log_format = "text";
};

/// One setting: its key in a configuration file, which with '-' for '_' is its flag's name.
struct ConfigField {
  const char* key;
  const char* type_name;  ///< of the value, for help
  const char* help;
  std::variant<std::string ServerConfig::*, bool ServerConfig::*, int ServerConfig::*> member;
  int min = 0;  ///< of an int
  int max = 0;
  bool reloadable = false;      ///< a running server takes a new value on SIGHUP
  const char* former_key = "";  ///< by which it is known as well; none if empty
};

/// The settings in which the two differ.
std::vector<const ConfigField*> ChangedFields(const ServerConfig& before,
                                              const ServerConfig& after);

/// Copies one setting.
void TakeField(const ConfigField& field, const ServerConfig& from, ServerConfig* to);

/// All settings.
std::span<const ConfigField> ConfigFields();

/// Reads the settings that the JSON file has; the others keep their values. NotFound, or
/// InvalidArgument naming the file, the key, the value and the bound; an unknown key is an error.
absl::Status ReadConfigFile(const std::filesystem::path& path, ServerConfig* config);

/// How the database of `catalogue` is reached.
PostgresOptions DatabaseOptionsOf(const ServerConfig& config);

/// How the object store of `map_files` is reached.
ObjectOptions ObjectOptionsOf(const ServerConfig& config);

/// OK, or InvalidArgument naming the key, the value and the bound.
absl::Status Validate(const ServerConfig& config);

}  // namespace dcloc::server
