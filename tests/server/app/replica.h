#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/end_to_end/server_process.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {

/// A process of the server among several on one database, with what is its own in a folder of its
/// own. It keeps no map in memory that nobody uses.
class Replica {
 public:
  /// `arguments`: where the database and the map files are.
  Replica(const std::filesystem::path& folder, const std::string& name,
          std::vector<std::string> arguments)
      : log_(folder / (name + ".log")),
        process_(DCLOC_SERVER_PROGRAM, folder / name, log_,
                 {.arguments = WithColdMaps(std::move(arguments))}) {
    if (!process_.WaitUntilReady()) throw std::runtime_error(name + " did not start");
    channel_ = process_.Channel();
    maps = v1::MapService::NewStub(channel_);
    localization = v1::LocalizationService::NewStub(channel_);
    admin = v1::AdminService::NewStub(channel_);
  }

  void Kill() { process_.Kill(); }
  bool Terminate() { return process_.Terminate(); }

  grpc::Status Activate(std::int64_t version) {
    v1::ActivateMapVersionRequest request;
    request.set_map_name("town");
    request.set_version(version);
    v1::ActivateMapVersionResponse response;
    Call call;
    return maps->ActivateMapVersion(&call, request, &response);
  }

  grpc::Status DeleteMap() {
    v1::DeleteMapRequest request;
    request.set_map_name("town");
    v1::DeleteMapResponse response;
    Call call;
    return maps->DeleteMap(&call, request, &response);
  }

  grpc::Status Upload(const std::vector<std::byte>& bytes) {
    v1::UploadMapResponse response;
    return UploadMap(*maps, HeaderOf(bytes), bytes, &response);
  }

  /// What the log says so far.
  std::string Log() const {
    std::ifstream file(log_);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  grpc::StatusCode ListMaps(const std::string& token) {
    CallAs call(token);
    v1::ListMapsResponse response;
    return maps->ListMaps(&call, {}, &response).error_code();
  }

  std::unique_ptr<v1::MapService::Stub> maps;
  std::unique_ptr<v1::LocalizationService::Stub> localization;
  std::unique_ptr<v1::AdminService::Stub> admin;

 private:
  static std::vector<std::string> WithColdMaps(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--warm-map-mib", "0"});
    return arguments;
  }

  const std::filesystem::path log_;
  ServerProcess process_;
  std::shared_ptr<grpc::Channel> channel_;
};

/// A session of a vehicle, with a scan after the other.
class Vehicle {
 public:
  explicit Vehicle(Replica& replica, const std::string& token = "")
      : session_(*replica.localization, token) {
    session_.Open(OpenMessage());
    const auto answer = session_.Read();
    is_open_ = answer && answer->has_opened();
    if (is_open_) version_ = answer->opened().map_version();
  }

  bool is_open() const { return is_open_; }
  std::int64_t version() const { return version_; }
  bool Localize() { return session_.Localize(ScanMessage(next_++)).has_value(); }
  grpc::Status End() {
    session_.CloseSending();
    return session_.Finish();
  }

 private:
  TestSession session_;
  bool is_open_ = false;
  std::int64_t version_ = 0;
  std::int64_t next_ = 1;
};

}  // namespace dcloc::server
