#include "server/config/config.h"

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  return {InputOf(R"({"data": "store", "listen": "127.0.0.1:50051", "metrics_listen": "9464",)"
                  R"( "max_session_count": 50, "require_identity": true, "log_level": "warn"})"),
          InputOf(R"({"data": "store", "tls_cert": "a.pem", "tls_key": "a.key",)"
                  R"( "listen": "[::1]:0", "scrub_mb_per_s": 0, "quarantine_days": 1})"),
          InputOf("{}")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  dcloc::server::ServerConfig config;
  const absl::Status status = dcloc::server::ReadConfigFile(file.Write(data, size), &config);
  static_cast<void>(dcloc::server::Validate(config));
  if (status.ok()) return 0;
  dcloc::Require(status.message().find(file.path().string()) != absl::string_view::npos,
                 "an error names the file");
  return 0;
}
