#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/admin/record_stream.h"
#include "server/replicas/replicas.h"
#include "server/sessions/recording_subscriber.h"

namespace dcloc::server {

/// Has the next session of a vehicle recorded for `stream` by `others` too. `done` is called once
/// all of them wait for it: Unavailable names one that does not. `request` and the call of
/// `context` live until then; `replicas` and `recordings` as long as the stream.
void RecordElsewhere(Replicas& replicas, RecordingRequests& recordings,
                     const std::vector<std::string>& others,
                     const grpc::CallbackServerContext& context,
                     const v1::RecordSessionRequest& request,
                     const std::shared_ptr<RecordStream>& stream,
                     std::function<void(const absl::Status& status)> done);

}  // namespace dcloc::server
