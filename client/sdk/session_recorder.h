#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client/sdk/recording.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// Records a session's requests and answers, where that is asked for. Not thread-safe.
class SessionRecorder {
 public:
  /// Errors as of RecordingWriter; without `Begin` nothing is recorded.
  absl::Status Begin(const std::string& file, const v1::OpenSession& open,
                     const v1::SessionOpened& opened);

  void Add(const v1::LocalizeRequest& request, const v1::LocalizeResponse& answer);

  /// Ends the recording, saying why, unless it has ended.
  void End(const std::string& reason);

  const absl::Status& status() const { return status_; }

 private:
  std::optional<RecordingWriter> writer_;
  absl::Status status_;
};

}  // namespace dcloc::client
