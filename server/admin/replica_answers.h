#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "server/replicas/replicas.h"

namespace dcloc::server {

/// The answer of the one that has the session, and its address; else NotFound as it is `here`, or
/// Unavailable where a replica that may have it did not answer.
template <typename Response>
absl::Status TakeFound(const absl::Status& here, std::vector<ReplicaAnswer<Response>> answers,
                       Response* response, std::string* address = nullptr) {
  absl::Status status = here;
  for (ReplicaAnswer<Response>& answer : answers) {
    if (answer.status.ok()) {
      if (address != nullptr) *address = answer.address;
      *response = std::move(answer.response);
      return absl::OkStatus();
    }
    if (answer.status.error_code() == grpc::StatusCode::NOT_FOUND) continue;
    status = absl::UnavailableError(absl::StrCat(here.message(), " here, and ", answer.address,
                                                 " did not say: ", answer.status.error_message()));
  }
  return status;
}

/// What the one replica that was asked said.
template <typename Response>
absl::Status TakeOnly(std::vector<ReplicaAnswer<Response>> answers, Response* response) {
  ReplicaAnswer<Response>& answer = answers.front();
  *response = std::move(answer.response);
  if (answer.status.ok()) return absl::OkStatus();
  return {static_cast<absl::StatusCode>(answer.status.error_code()),
          absl::StrCat("replica ", answer.address, ": ", answer.status.error_message())};
}

/// Asks `others` which of them has a session, and tells `done` its address, or why there is none:
/// as `TakeFound`. The call of `context` lives until then.
inline void FindReplicaOf(Replicas& replicas, const std::vector<std::string>& others,
                          const grpc::CallbackServerContext& context, const std::string& session_id,
                          const absl::Status& here,
                          std::function<void(const absl::StatusOr<std::string>&)> done) {
  v1::GetSessionRequest get;
  get.set_session_id(session_id);
  replicas.Ask<v1::GetSessionRequest, v1::GetSessionResponse>(
      others, context, get, &v1::AdminService::StubInterface::async_interface::GetSession,
      replicas.bounds().answer, [here, done = std::move(done)](auto answers) {
        v1::GetSessionResponse found;
        std::string address;
        const absl::Status status = TakeFound(here, std::move(answers), &found, &address);
        status.ok() ? done(address) : done(status);
      });
}

}  // namespace dcloc::server
