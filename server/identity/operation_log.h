#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/base/clock.h"
#include "server/identity/principal.h"

namespace dcloc::server {

/// Something that a caller changed, or tried to.
struct Operation {
  std::int64_t number = 0;  ///< rises by one with each since the start, from 1
  SystemTime time;          ///< of its end
  Principal principal;
  std::string peer;
  std::string method;   ///< "dcloc.v1.MapService.ActivateMapVersion"
  std::string request;  ///< printable
  absl::StatusCode code = absl::StatusCode::kOk;
  std::string message;  ///< of the status; printable
};

/// Who did what lately: the calls of RPCs that change something (`MethodPermissions` says which),
/// whether they succeeded or not. Those that were not permitted are in the log alone, so that
/// nobody without rights can push out the others, and when it is full, the oldest of the tenant
/// with the most goes. Bounded, in memory; each is also a line of the log, "operation".
/// Thread-safe.
class OperationLog {
 public:
  static constexpr std::size_t kMaxKept = 1000;  ///< of all tenants
  static constexpr std::size_t kMaxText = 200;   ///< of a request or a message

  OperationLog();

  /// What a request asks for, as one printable line; cut off after `kMaxText`.
  static std::string TextOf(const google::protobuf::Message& request);

  /// Keeps the end of a call, if its RPC changes something: the one that `request` is of.
  void Note(const grpc::ServerContextBase& context, const Principal& principal,
            const google::protobuf::Message& request, const absl::Status& status);

  /// The same for a call of many requests of that type; `text` is what was asked for, from
  /// `TextOf`.
  void Note(const grpc::ServerContextBase& context, const Principal& principal,
            const google::protobuf::Descriptor* request, std::string text,
            const absl::Status& status);

  /// The tenant's with a number below `before`, by descending number, at most `limit`.
  std::vector<Operation> List(absl::string_view tenant, std::int64_t before, int limit) const;

 private:
  void DropOldestOfLargest();  ///< with the mutex held

  std::map<const google::protobuf::Descriptor*, const char*> method_of_;
  mutable std::mutex mutex_;
  std::deque<Operation> kept_;  ///< oldest first
  std::int64_t last_number_ = 0;
};

}  // namespace dcloc::server
