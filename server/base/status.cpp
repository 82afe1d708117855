#include "server/base/status.h"

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

namespace {

grpc::Status GrpcStatusOf(const absl::Status& status) {
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), std::string(status.message()));
}

}  // namespace

grpc::Status ToGrpc(const absl::Status& status) noexcept {
  grpc::Status converted;
  const absl::Status made = WithinMemory([&] { converted = GrpcStatusOf(status); });
  if (!made.ok()) converted = GrpcStatusOf(made);
  return converted;
}

std::string Quoted(absl::string_view text) {
  constexpr std::size_t kShown = 80;
  const bool cut = text.size() > kShown;
  return absl::StrCat("\"", absl::CHexEscape(text.substr(0, kShown)), cut ? "...\"" : "\"");
}

absl::Status WithPrefix(absl::string_view prefix, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(prefix, status.message()));
}

}  // namespace dcloc::server
