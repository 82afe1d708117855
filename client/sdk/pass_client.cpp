#include "client/sdk/pass_client.h"

#include "client/sdk/calls.h"

namespace dcloc::client {

PassClient::PassClient(const std::shared_ptr<grpc::Channel>& channel,
                       std::chrono::milliseconds timeout)
    : stub_(v1::PassService::NewStub(channel)), timeout_(timeout) {}

absl::StatusOr<int> PassClient::SetConsent(const v1::PassConsent& consent,
                                           v1::PassConsentState state) {
  v1::SetPassConsentRequest request;
  *request.mutable_consent() = consent;
  request.set_state(state);
  const auto response = Call(*stub_, &v1::PassService::Stub::SetPassConsent, request, timeout_);
  if (!response.ok()) return response.status();
  return response->removed_pass_count();
}

absl::StatusOr<std::vector<v1::PassConsent>> PassClient::ListConsents() {
  return CallForAllPages<v1::PassConsent>(
      *stub_, &v1::PassService::Stub::ListPassConsents, v1::ListPassConsentsRequest(),
      &v1::ListPassConsentsResponse::mutable_consents, timeout_);
}

absl::StatusOr<std::vector<v1::Pass>> PassClient::List(const std::string& map_name) {
  v1::ListPassesRequest request;
  request.set_map_name(map_name);
  return CallForAllPages<v1::Pass>(*stub_, &v1::PassService::Stub::ListPasses, request,
                                   &v1::ListPassesResponse::mutable_passes, timeout_);
}

}  // namespace dcloc::client
