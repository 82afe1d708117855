#include "client/cli/doctor/tls_probe.h"

#include <fcntl.h>
#include <netdb.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace dcloc::cli {
namespace {

using Milliseconds = std::chrono::milliseconds;

template <auto kFree>
struct Free {
  template <typename T>
  void operator()(T* object) const {
    kFree(object);
  }
};

/// A file descriptor that is closed with it.
class Socket {
 public:
  explicit Socket(int descriptor = -1) : descriptor_(descriptor) {}
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Socket() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

struct Address {
  std::string host;  ///< without the brackets of IPv6
  std::string port;
};

Address AddressOf(const std::string& server) {
  const std::size_t colon = server.rfind(':');
  std::string host = server.substr(0, colon);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  return {host, colon == std::string::npos ? "" : server.substr(colon + 1)};
}

/// Waits for the connection that was begun; an errno, or 0.
int FinishConnecting(int descriptor, Milliseconds timeout) {
  pollfd waiting{.fd = descriptor, .events = POLLOUT, .revents = 0};
  const int ready = poll(&waiting, 1, static_cast<int>(timeout.count()));
  if (ready == 0) return ETIMEDOUT;
  if (ready < 0) return errno;
  int error = 0;
  socklen_t size = sizeof(error);
  getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

absl::StatusOr<Socket> Connect(const std::string& server, Milliseconds timeout) {
  const Address address = AddressOf(server);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  if (const int error = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &list);
      error != 0) {
    return absl::NotFoundError(absl::StrCat(address.host, ": ", gai_strerror(error)));
  }
  const std::unique_ptr<addrinfo, Free<freeaddrinfo>> owner(list);
  int error = ECONNREFUSED;
  for (const addrinfo* entry = list; entry != nullptr; entry = entry->ai_next) {
    Socket socket(::socket(entry->ai_family, entry->ai_socktype | SOCK_NONBLOCK, 0));
    if (socket.descriptor() < 0) continue;
    error = connect(socket.descriptor(), entry->ai_addr, entry->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) error = FinishConnecting(socket.descriptor(), timeout);
    if (error == 0) return socket;
  }
  const std::string what(absl::ErrnoToStatus(error, server).message());
  return error == ETIMEDOUT ? absl::DeadlineExceededError(what) : absl::UnavailableError(what);
}

std::string SslError() {
  const unsigned long error = ERR_get_error();
  const char* const reason = ERR_reason_error_string(error);
  return reason == nullptr ? "the connection was closed" : reason;
}

using Context = std::unique_ptr<SSL_CTX, Free<SSL_CTX_free>>;

absl::StatusOr<Context> MakeContext(const client::ChannelOptions& options) {
  Context context(SSL_CTX_new(TLS_client_method()));
  const auto fail = [](const std::string& file) {
    return absl::InvalidArgumentError(absl::StrCat(file, ": ", SslError()));
  };
  if (!options.tls_ca.empty() &&
      SSL_CTX_load_verify_locations(context.get(), options.tls_ca.c_str(), nullptr) != 1) {
    return fail(options.tls_ca);
  }
  if (!options.tls_cert.empty() &&
      SSL_CTX_use_certificate_chain_file(context.get(), options.tls_cert.c_str()) != 1) {
    return fail(options.tls_cert);
  }
  if (!options.tls_key.empty() &&
      SSL_CTX_use_PrivateKey_file(context.get(), options.tls_key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return fail(options.tls_key);
  }
  return context;
}

std::int64_t SecondsOf(const ASN1_TIME* time) {
  std::tm parts{};
  return ASN1_TIME_to_tm(time, &parts) == 1 ? std::int64_t{timegm(&parts)} : 0;
}

/// DNS names and addresses of the subject's alternative names, by which alone a name is checked.
std::string NamesOf(X509* certificate) {
  auto* const found = static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr));
  std::vector<std::string> names;
  for (int i = 0; found != nullptr && i < sk_GENERAL_NAME_num(found); ++i) {
    const GENERAL_NAME* const name = sk_GENERAL_NAME_value(found, i);
    const bool is_dns = name->type == GEN_DNS;
    if (!is_dns && name->type != GEN_IPADD) continue;
    const ASN1_STRING* const value = is_dns ? name->d.dNSName : name->d.iPAddress;
    const std::string bytes(reinterpret_cast<const char*>(ASN1_STRING_get0_data(value)),
                            static_cast<std::size_t>(ASN1_STRING_length(value)));
    if (is_dns) {
      names.push_back(bytes);
    } else if (bytes.size() == 4) {
      names.push_back(absl::StrJoin(bytes, ".", [](std::string* out, char byte) {
        absl::StrAppend(out, int{static_cast<unsigned char>(byte)});
      }));
    }
  }
  GENERAL_NAMES_free(found);
  return absl::StrJoin(names, ", ");
}

/// Lets the certificate be held against the name, which may be an address.
void Expect(SSL* ssl, const std::string& name) {
  X509_VERIFY_PARAM* const parameters = SSL_get0_param(ssl);
  if (X509_VERIFY_PARAM_set1_ip_asc(parameters, name.c_str()) == 1) return;
  SSL_set1_host(ssl, name.c_str());
  SSL_set_tlsext_host_name(ssl, name.c_str());
}

int NoteRequest(SSL*, void* asks) {
  *static_cast<bool*>(asks) = true;
  return 1;
}

}  // namespace

absl::Status ProbeTcp(const std::string& server, Milliseconds timeout) {
  return Connect(server, timeout).status();
}

absl::StatusOr<TlsProbe> ProbeTls(const client::ChannelOptions& options, Milliseconds timeout) {
  absl::StatusOr<Context> context = MakeContext(options);
  if (!context.ok()) return context.status();
  absl::StatusOr<Socket> socket = Connect(options.server, timeout);
  if (!socket.ok()) return socket.status();
  // From here on blocking, with a limit for each read and write.
  fcntl(socket->descriptor(), F_SETFL, 0);
  const timeval limit{.tv_sec = timeout.count() / 1000, .tv_usec = timeout.count() % 1000 * 1000};
  setsockopt(socket->descriptor(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  setsockopt(socket->descriptor(), SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));

  TlsProbe probe;
  probe.expected_name =
      options.tls_server_name.empty() ? AddressOf(options.server).host : options.tls_server_name;
  SSL_CTX_set_cert_cb(context->get(), NoteRequest, &probe.asks_for_certificate);
  const std::unique_ptr<SSL, Free<SSL_free>> ssl(SSL_new(context->get()));
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_set_alpn_protos(ssl.get(), kHttp2, sizeof(kHttp2));
  Expect(ssl.get(), probe.expected_name);
  SSL_set_fd(ssl.get(), socket->descriptor());
  ERR_clear_error();
  if (SSL_connect(ssl.get()) != 1) {
    return absl::FailedPreconditionError(
        absl::StrCat(options.server, ": no TLS handshake: ", SslError()));
  }
  const std::unique_ptr<X509, Free<X509_free>> certificate(SSL_get1_peer_certificate(ssl.get()));
  if (certificate == nullptr) {
    return absl::FailedPreconditionError(absl::StrCat(options.server, ": shows no certificate"));
  }
  const long verified = SSL_get_verify_result(ssl.get());
  if (verified != X509_V_OK) probe.fault = X509_verify_cert_error_string(verified);
  probe.names = NamesOf(certificate.get());
  probe.not_before_s = SecondsOf(X509_get0_notBefore(certificate.get()));
  probe.not_after_s = SecondsOf(X509_get0_notAfter(certificate.get()));
  return probe;
}

}  // namespace dcloc::cli
