#pragma once

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <functional>
#include <memory>
#include <string>

#include "client/sdk/channel.h"
#include "dcloc/v1/localization_service.grpc.pb.h"

namespace dcloc::client {

using LocalizeServerStream = grpc::ServerReaderWriter<v1::LocalizeResponse, v1::LocalizeRequest>;

/// A localization service that behaves as a test says, listening on a free port of this machine.
class FakeServer {
 public:
  using Behaviour = std::function<grpc::Status(grpc::ServerContext&, LocalizeServerStream&)>;

  explicit FakeServer(Behaviour behaviour) : service_(std::move(behaviour)) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(&service_);
    // As dcloc-server: clients may ping often.
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
    server_ = builder.BuildAndStart();
  }
  ~FakeServer() { Die(); }
  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;

  /// Cuts off all streams.
  void Die() { server_->Shutdown(std::chrono::system_clock::now()); }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  std::shared_ptr<grpc::Channel> Channel() const { return *MakeChannel({.server = address()}); }

 private:
  class Service final : public v1::LocalizationService::Service {
   public:
    explicit Service(Behaviour behaviour) : behaviour_(std::move(behaviour)) {}
    grpc::Status Localize(grpc::ServerContext* context, LocalizeServerStream* stream) override {
      return behaviour_(*context, *stream);
    }

   private:
    Behaviour behaviour_;
  };

  Service service_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

/// Reads the `open` and says that the session is open.
inline void AcceptOpen(LocalizeServerStream& stream) {
  v1::LocalizeRequest request;
  stream.Read(&request);
  v1::LocalizeResponse opened;
  opened.mutable_opened()->set_session_id("session of " + request.open().vehicle_id());
  stream.Write(opened);
}

/// Answers each scan by its sequence number, refusing those of the radar "broken".
inline grpc::Status AnswerAll(grpc::ServerContext&, LocalizeServerStream& stream) {
  AcceptOpen(stream);
  v1::LocalizeRequest request;
  while (stream.Read(&request)) {
    v1::LocalizeResponse response;
    if (request.scan().radar_id() == "broken") {
      response.mutable_rejected()->set_sequence_number(request.scan().sequence_number());
    } else {
      response.mutable_result()->set_sequence_number(request.scan().sequence_number());
    }
    stream.Write(response);
  }
  return grpc::Status::OK;
}

}  // namespace dcloc::client
