#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>

#include "absl/status/status.h"

namespace dcloc::server {

/// How a server is set up. Defaults are here and nowhere else.
struct ServerConfig {
  std::string data;                        ///< folder of the embedded store
  std::string listen = "127.0.0.1:50051";  ///< HOST:PORT; port 0 takes a free one

  std::string tls_cert;  ///< PEM files; without a certificate the server speaks plaintext
  std::string tls_key;
  std::string tls_client_ca;  ///< clients must show a certificate that this authority signed
  bool allow_plaintext_off_loopback = false;

  bool stub_matcher = false;
  int worker_count = 0;  ///< threads that localize; 0: one per processor
  int max_session_count = 1000;
  int max_pending_scan_count = 8;  ///< per session, read but not yet answered
  int max_map_mib = 1024;          ///< of one map file
  int shutdown_deadline_ms = 5000;
  std::string log_level = "info";
};

/// One setting: its key in a configuration file, which with '-' for '_' is its flag's name.
struct ConfigField {
  const char* key;
  const char* type_name;  ///< of the value, for help
  const char* help;
  std::variant<std::string ServerConfig::*, bool ServerConfig::*, int ServerConfig::*> member;
  int min = 0;  ///< of an int
  int max = 0;
};

/// All settings.
std::span<const ConfigField> ConfigFields();

/// Takes the settings that the JSON file has; the others stay. NotFound, or InvalidArgument naming
/// the file, the key, the value and the bound; an unknown key is an error.
absl::Status ReadConfigFile(const std::filesystem::path& path, ServerConfig* config);

/// OK, or InvalidArgument naming the key, the value and the bound.
absl::Status Validate(const ServerConfig& config);

}  // namespace dcloc::server
