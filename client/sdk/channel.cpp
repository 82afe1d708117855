#include "client/sdk/channel.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "client/sdk/token.h"

namespace dcloc::client {
namespace {

constexpr int kMaxMessage_bytes = 2 << 20;
// A server that is gone is noticed within their sum. Not below what dcloc-server lets a client do.
constexpr int kKeepaliveTime_ms = 10'000;
constexpr int kKeepaliveTimeout_ms = 10'000;
// gRPC's own are 1 s to 2 min: far too long for a vehicle whose server has just been restarted.
constexpr int kInitialReconnectBackoff_ms = 100;
constexpr int kMaxReconnectBackoff_ms = 5'000;
// Nor 2 min for a name server that is silent, and 30 s until a name is looked up again.
constexpr int kLookUpTimeout_ms = 1'500;
constexpr int kMinLookUpInterval_ms = 500;
// Waits until a name that was not found is looked up again grow to 2 min, and cannot be set. A
// channel that nobody has used for so long forgets them.
constexpr int kIdleTimeout_ms = 500;

/// The host of HOST:PORT, an IPv6 one without its brackets.
absl::string_view HostOf(absl::string_view server) {
  absl::string_view host = server.substr(0, server.rfind(':'));
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  return host;
}

absl::Status CheckOptions(const ChannelOptions& options) {
  // gRPC would take port 443 for an address without one.
  const std::size_t colon = options.server.rfind(':');
  const std::string port = colon == std::string::npos ? "" : options.server.substr(colon + 1);
  const bool is_number = !port.empty() && port.size() <= 5 &&
                         port.find_first_not_of("0123456789") == std::string::npos;
  if (colon == 0 || !is_number || std::stoi(port) < 1 || std::stoi(port) > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat("server is \"", options.server, "\"; it must be HOST:PORT"));
  }
  if (options.tls_cert.empty() != options.tls_key.empty()) {
    return absl::InvalidArgumentError("tls_cert and tls_key go together; only one is given");
  }
  if (options.tls_ca.empty() && (!options.tls_cert.empty() || !options.tls_server_name.empty())) {
    return absl::InvalidArgumentError(
        "TLS needs tls_ca, the authority of the server's certificate");
  }
  if (!options.token_file.empty() && options.tls_ca.empty() &&
      !IsLoopback(HostOf(options.server))) {
    return absl::InvalidArgumentError(absl::StrCat(
        "token_file is given and server is ", options.server,
        ", another machine: a token is not sent there in plaintext; TLS needs tls_ca"));
  }
  // A header with other characters would end the process.
  if (options.tenant.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_") !=
      std::string::npos) {
    return absl::InvalidArgumentError(absl::StrCat("tenant is \"", absl::CHexEscape(options.tenant),
                                                   "\"; it may have a-z, 0-9, '-' and '_'"));
  }
  return absl::OkStatus();
}

absl::Status ReadPem(absl::string_view option, const std::string& path, std::string& pem) {
  if (path.empty()) return absl::OkStatus();
  std::ifstream file(path, std::ios::binary);
  pem.assign(std::istreambuf_iterator<char>(file), {});
  if (!file) return absl::ErrnoToStatus(errno, absl::StrCat(option, ": ", path));
  // Broken credentials would only show as a connection that never comes.
  if (pem.find("-----BEGIN ") == std::string::npos) {
    return absl::InvalidArgumentError(absl::StrCat(option, ": ", path, ": no PEM in it"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeCredentials(
    const ChannelOptions& options) {
  if (options.tls_ca.empty()) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions pem;
  absl::Status status = ReadPem("tls_ca", options.tls_ca, pem.pem_root_certs);
  status.Update(ReadPem("tls_cert", options.tls_cert, pem.pem_cert_chain));
  status.Update(ReadPem("tls_key", options.tls_key, pem.pem_private_key));
  if (!status.ok()) return status;
  return grpc::SslCredentials(pem);
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::Channel>> MakeChannel(const ChannelOptions& options) {
  if (absl::Status status = CheckOptions(options); !status.ok()) return status;
  const auto credentials = MakeCredentials(options);
  if (!credentials.ok()) return credentials.status();
  Headers headers;
  if (!options.token_file.empty()) {
    const absl::StatusOr<std::string> token = ReadToken(options.token_file);
    if (!token.ok()) return token.status();
    headers.insert(ProofOf(*token));
  }
  if (!options.tenant.empty()) headers.emplace("dcloc-tenant", options.tenant);
  Interceptors interceptors;
  if (!headers.empty()) interceptors = SendHeaders(std::move(headers));
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxMessage_bytes);
  arguments.SetMaxSendMessageSize(kMaxMessage_bytes);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveTime_ms);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeout_ms);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kInitialReconnectBackoff_ms);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kMaxReconnectBackoff_ms);
  arguments.SetInt(GRPC_ARG_DNS_ARES_QUERY_TIMEOUT_MS, kLookUpTimeout_ms);
  arguments.SetInt(GRPC_ARG_CLIENT_IDLE_TIMEOUT_MS, kIdleTimeout_ms);
  arguments.SetInt(GRPC_ARG_DNS_MIN_TIME_BETWEEN_RESOLUTIONS_MS, kMinLookUpInterval_ms);
  // While a scan is being matched for long, the stream is quiet; pings may go on.
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // A stream that begins on a connection that has just broken would be begun anew behind our back,
  // on another one, and its first write reported as failed: it would be open, and never written to.
  // Sessions and uploads begin anew by themselves.
  arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  if (!options.tls_server_name.empty()) {
    arguments.SetSslTargetNameOverride(options.tls_server_name);
  }
  if (options.own_connection) arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // Plaintext to this machine stays on it, whatever proxy the environment names.
  if (options.tls_ca.empty() && IsLoopback(HostOf(options.server))) {
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  }
  return grpc::experimental::CreateCustomChannelWithInterceptors(
      options.server, *credentials, arguments, std::move(interceptors));
}

}  // namespace dcloc::client
