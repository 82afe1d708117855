#include "server/replicas/replicas.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

/// On a call that another server handed on. Who sends it without being one gets what this server
/// alone knows, no more.
constexpr char kHandedOnBy[] = "x-dcloc-handed-on-by";
constexpr char kProof[] = "authorization";
constexpr char kTenant[] = "dcloc-tenant";

bool IsHandedOn(const grpc::CallbackServerContext& context) {
  return context.client_metadata().contains(kHandedOnBy);
}

}  // namespace

void Replicas::Join(std::string address) {
  if (parts_.directory == nullptr) return;
  own_address_ = std::move(address);
  parts_.directory->Announce(own_address_);
}

int Replicas::known_count() const {
  return own_address_.empty() ? 1 : 1 + static_cast<int>(parts_.directory->Others().size());
}

std::vector<std::string> Replicas::OthersFor(const grpc::CallbackServerContext& context) const {
  if (own_address_.empty() || IsHandedOn(context)) return {};
  return parts_.directory->Others();
}

absl::StatusOr<std::vector<std::string>> Replicas::Named(const grpc::CallbackServerContext& context,
                                                         const std::string& address) const {
  if (address.empty() || address == own_address_) return std::vector<std::string>();
  if (IsHandedOn(context)) {
    return absl::FailedPreconditionError(
        absl::StrCat("replica is ", Quoted(address), "; this one has become ", own_address_));
  }
  std::vector<std::string> others = OthersFor(context);
  if (std::ranges::find(others, address) != others.end()) return std::vector{address};
  if (own_address_.empty()) {
    return absl::NotFoundError(
        absl::StrCat("replica is ", Quoted(address), "; this server is by itself"));
  }
  others.push_back(own_address_);
  return absl::NotFoundError(
      absl::StrCat("replica is ", Quoted(address), "; there are ", absl::StrJoin(others, ", ")));
}

bool Replicas::CanHandOn(const grpc::CallbackServerContext& context) const {
  return context.client_metadata().contains(kProof) || !parts_.access.needs_proof();
}

absl::StatusOr<Replicas::Line> Replicas::Call(const std::string& address,
                                              const grpc::CallbackServerContext& context) {
  if (!CanHandOn(context)) {
    return absl::FailedPreconditionError(
        "the caller's certificate cannot be handed on: ask it by itself, or call with a token");
  }
  channels_.KeepOnly(parts_.directory->Others());
  absl::StatusOr<std::shared_ptr<grpc::Channel>> channel = channels_.To(address);
  if (!channel.ok()) return channel.status();
  Line line{.stub = v1::AdminService::NewStub(*channel),
            .context = grpc::ClientContext::FromCallbackServerContext(context)};
  line.context->AddMetadata(kHandedOnBy, own_address_);
  for (const char* key : {kProof, kTenant}) {
    const auto sent = context.client_metadata().find(key);
    if (sent == context.client_metadata().end()) continue;
    line.context->AddMetadata(key, std::string(sent->second.data(), sent->second.size()));
  }
  return line;
}

}  // namespace dcloc::server
