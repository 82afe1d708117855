#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dcloc/v1/admin_service.grpc.pb.h"
#include "dcloc/v1/localization_service.grpc.pb.h"
#include "dcloc/v1/map_service.grpc.pb.h"
#include "server/server.h"
#include "spdlog/spdlog.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/messages.h"

namespace dcloc::server {

/// A server in this process on a free port and an empty store, and stubs to talk to it.
struct TestServer {
  explicit TestServer(ServerConfig config = StubConfig()) {
    spdlog::set_level(spdlog::level::warn);
    config.data = folder.path() / "store";
    config.listen = "127.0.0.1:0";
    absl::StatusOr<std::unique_ptr<Server>> started = Server::Start(config);
    if (!started.ok()) throw std::runtime_error(std::string(started.status().message()));
    server = *std::move(started);
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    channel =
        grpc::CreateCustomChannel(server->address(), grpc::InsecureChannelCredentials(), arguments);
    localization = v1::LocalizationService::NewStub(channel);
    maps = v1::MapService::NewStub(channel);
    admin = v1::AdminService::NewStub(channel);
  }

  static ServerConfig StubConfig() {
    ServerConfig config;
    config.stub_matcher = true;
    config.warm_map_mib = 0;  // what is in memory is what someone uses
    return config;
  }

  TemporaryFolder folder;
  std::unique_ptr<Server> server;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::LocalizationService::Stub> localization;
  std::unique_ptr<v1::MapService::Stub> maps;
  std::unique_ptr<v1::AdminService::Stub> admin;
};

/// A context that gives up rather than to hang a test.
struct Call : grpc::ClientContext {
  Call() { set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(120)); }
};

/// A call with a token; with an empty one, without.
struct CallAs : Call {
  explicit CallAs(const std::string& token) {
    if (!token.empty()) AddMetadata("authorization", "Bearer " + token);
  }
};

inline v1::UploadMapHeader HeaderOf(std::span<const std::byte> bytes) {
  v1::UploadMapHeader header;
  header.set_map_name("town");
  header.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
  header.set_sha256(Sha256Of(bytes));
  header.set_activate(true);
  return header;
}

/// Uploads `bytes` under `header`, in chunks of `chunk_size`.
inline grpc::Status UploadMap(v1::MapService::Stub& maps, const v1::UploadMapHeader& header,
                              std::span<const std::byte> bytes, v1::UploadMapResponse* response,
                              std::size_t chunk_size = std::size_t{1} << 20) {
  Call call;
  const auto writer = maps.UploadMap(&call, response);
  v1::UploadMapRequest request;
  *request.mutable_header() = header;
  bool open = writer->Write(request);
  for (std::size_t offset = 0; open && offset < bytes.size(); offset += chunk_size) {
    const auto part = bytes.subspan(offset, std::min(chunk_size, bytes.size() - offset));
    request.mutable_chunk()->set_offset_bytes(static_cast<std::int64_t>(offset));
    request.mutable_chunk()->set_data(part.data(), part.size());
    open = writer->Write(request);
  }
  writer->WritesDone();
  return writer->Finish();
}

/// One Localize call, in lockstep.
class TestSession {
 public:
  explicit TestSession(v1::LocalizationService::Stub& stub, const std::string& token = "")
      : call_(token), stream_(stub.Localize(&call_)) {}

  bool Open(const v1::OpenSession& open) {
    v1::LocalizeRequest request;
    *request.mutable_open() = open;
    return stream_->Write(request);
  }

  bool Send(const v1::Scan& scan) {
    v1::LocalizeRequest request;
    *request.mutable_scan() = scan;
    return stream_->Write(request);
  }

  bool Send(const v1::LocalizeRequest& request) { return stream_->Write(request); }

  /// The next answer; nothing when the stream has ended.
  std::optional<v1::LocalizeResponse> Read() {
    v1::LocalizeResponse response;
    return stream_->Read(&response) ? std::optional(std::move(response)) : std::nullopt;
  }

  /// Sends a scan and reads its answer.
  std::optional<v1::LocalizeResponse> Localize(const v1::Scan& scan) {
    return Send(scan) ? Read() : std::nullopt;
  }

  void Cancel() { call_.TryCancel(); }
  void CloseSending() { stream_->WritesDone(); }

  /// Reads what is left and gives the end's status.
  grpc::Status Finish() {
    while (Read()) {
    }
    return stream_->Finish();
  }

 private:
  CallAs call_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::LocalizeRequest, v1::LocalizeResponse>> stream_;
};

/// Waits, for at most some seconds, until `done`.
template <typename Predicate>
bool Eventually(Predicate done) {
  for (int i = 0; i < 1000; ++i) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Whether `count` is the same for a while.
inline bool StandsStill(const std::atomic<int>& count) {
  const int before = count;
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  return count == before;
}

}  // namespace dcloc::server
