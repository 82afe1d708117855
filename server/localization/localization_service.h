#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "dcloc/v1/localization_service.grpc.pb.h"
#include "server/localization/localize_stream.h"

namespace dcloc::server {

/// Starts a LocalizeStream for each call and keeps track of those that are open.
class LocalizationService final : public v1::LocalizationService::CallbackService {
 public:
  LocalizationService(SessionHost host, int max_session_count);

  grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* Localize(
      grpc::CallbackServerContext* context) override;

  /// Ends all calls, those to come as well, once what was read of them is answered.
  void EndAll(const grpc::Status& status);

 private:
  struct OpenStream {
    std::weak_ptr<LocalizeStream> stream;
    OpenCalls::Token token;
  };

  void Forget(LocalizeStream* stream);

  const SessionHost host_;
  const int max_session_count_;

  std::mutex mutex_;
  std::map<LocalizeStream*, OpenStream> streams_;
  grpc::Status refusal_;  ///< not OK once all have been ended
};

}  // namespace dcloc::server
