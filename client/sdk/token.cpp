#include "client/sdk/token.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace dcloc::client {
namespace {

using grpc::experimental::ClientRpcInfo;
using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;

constexpr std::size_t kMaxToken_bytes = 4096;

class HeaderInterceptor final : public grpc::experimental::Interceptor {
 public:
  explicit HeaderInterceptor(const Headers& headers) : headers_(headers) {}

  void Intercept(InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      methods->GetSendInitialMetadata()->insert(headers_.begin(), headers_.end());
    }
    methods->Proceed();
  }

 private:
  const Headers& headers_;  ///< the factory's, which the channel holds for as long as its calls
};

class HeaderInterceptorFactory final
    : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  explicit HeaderInterceptorFactory(Headers headers) : headers_(std::move(headers)) {}

  grpc::experimental::Interceptor* CreateClientInterceptor(ClientRpcInfo* /*info*/) override {
    return new HeaderInterceptor(headers_);  // gRPC deletes it
  }

 private:
  const Headers headers_;
};

}  // namespace

absl::StatusOr<std::string> ReadToken(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string token(std::istreambuf_iterator<char>(file), {});
  if (!file) return absl::ErrnoToStatus(errno, absl::StrCat("token_file: ", path));
  absl::StripTrailingAsciiWhitespace(&token);
  // Anything else would be refused, or taken for another header, far from here.
  const bool is_one_word = std::ranges::all_of(token, [](char c) { return c > ' ' && c <= '~'; });
  if (token.empty() || token.size() > kMaxToken_bytes || !is_one_word) {
    return absl::InvalidArgumentError(
        absl::StrCat("token_file: ", path, ": must hold one word of 1 to ", kMaxToken_bytes,
                     " printable ASCII characters, and has ", token.size(), " bytes"));
  }
  return token;
}

bool IsLoopback(absl::string_view host) {
  const std::string name(host);
  if (name == "localhost") return true;
  in_addr v4{};
  if (inet_pton(AF_INET, name.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  in6_addr v6{};
  return inet_pton(AF_INET6, name.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

Interceptors SendHeaders(Headers headers) {
  Interceptors interceptors;
  interceptors.push_back(std::make_unique<HeaderInterceptorFactory>(std::move(headers)));
  return interceptors;
}

}  // namespace dcloc::client
