#include "client/sdk/map_client.h"

#include <grpcpp/client_context.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/sdk/sha256.h"
#include "client/sdk/status.h"

namespace dcloc::client {
namespace {

constexpr std::int64_t kChunk_bytes = 256 << 10;
constexpr std::int64_t kSlowestUpload_bytesps = 1'000'000;

using Milliseconds = std::chrono::milliseconds;

void SetDeadline(grpc::ClientContext& context, Milliseconds timeout) {
  context.set_deadline(std::chrono::system_clock::now() + timeout);
}

// Calls a unary method of the stub.
template <typename Request, typename Response>
absl::StatusOr<Response> Call(v1::MapService::Stub& stub,
                              grpc::Status (v1::MapService::Stub::*method)(grpc::ClientContext*,
                                                                           const Request&,
                                                                           Response*),
                              const Request& request, Milliseconds timeout) {
  grpc::ClientContext context;
  SetDeadline(context, timeout);
  Response response;
  const grpc::Status status = (stub.*method)(&context, request, &response);
  if (!status.ok()) return FromGrpc(status);
  return response;
}

// Calls a paged method until the last page; `items` takes a page's items out of a response.
template <typename Item, typename Request, typename Response>
absl::StatusOr<std::vector<Item>> CallForAllPages(
    v1::MapService::Stub& stub,
    grpc::Status (v1::MapService::Stub::*method)(grpc::ClientContext*, const Request&, Response*),
    Request request, google::protobuf::RepeatedPtrField<Item>* (Response::*items)(),
    Milliseconds timeout) {
  std::vector<Item> all;
  do {
    absl::StatusOr<Response> page = Call(stub, method, request, timeout);
    if (!page.ok()) return page.status();
    for (Item& item : *((*page).*items)()) all.push_back(std::move(item));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return all;
}

// False when the server does not want more; the call's status then says why.
bool SendFile(std::ifstream& file, std::int64_t size_bytes,
              grpc::ClientWriter<v1::UploadMapRequest>& writer,
              const MapClient::UploadProgress& progress) {
  v1::UploadMapRequest request;
  std::string& data = *request.mutable_chunk()->mutable_data();
  for (std::int64_t offset = 0; offset < size_bytes;) {
    data.resize(static_cast<std::size_t>(std::min(kChunk_bytes, size_bytes - offset)));
    file.read(data.data(), static_cast<std::streamsize>(data.size()));
    // A file cut short meanwhile: what arrives no longer fits the hash, and the server says so.
    if (file.gcount() == 0) break;
    data.resize(static_cast<std::size_t>(file.gcount()));
    request.mutable_chunk()->set_offset_bytes(offset);
    if (!writer.Write(request)) return false;
    offset += file.gcount();
    if (progress) progress(offset, size_bytes);
  }
  return writer.WritesDone();
}

}  // namespace

MapClient::MapClient(const std::shared_ptr<grpc::Channel>& channel, Milliseconds timeout)
    : stub_(v1::MapService::NewStub(channel)), timeout_(timeout) {}

absl::StatusOr<v1::MapVersion> MapClient::Upload(const std::filesystem::path& file,
                                                 const std::string& map_name, bool activate,
                                                 const UploadProgress& progress) {
  const absl::StatusOr<std::string> sha256 = Sha256OfFile(file);
  if (!sha256.ok()) return sha256.status();
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream) return absl::ErrnoToStatus(errno, file.string());
  const std::int64_t size_bytes = stream.tellg();
  stream.seekg(0);

  grpc::ClientContext context;
  SetDeadline(context, timeout_ + Milliseconds(size_bytes * 1000 / kSlowestUpload_bytesps));
  v1::UploadMapResponse response;
  const auto writer = stub_->UploadMap(&context, &response);
  v1::UploadMapRequest request;
  request.mutable_header()->set_map_name(map_name);
  request.mutable_header()->set_size_bytes(size_bytes);
  request.mutable_header()->set_sha256(*sha256);
  request.mutable_header()->set_activate(activate);
  if (writer->Write(request)) SendFile(stream, size_bytes, *writer, progress);
  const grpc::Status status = writer->Finish();
  if (!status.ok()) return FromGrpc(status);
  return std::move(*response.mutable_version());
}

absl::StatusOr<std::vector<v1::Map>> MapClient::List() {
  return CallForAllPages<v1::Map>(*stub_, &v1::MapService::Stub::ListMaps, v1::ListMapsRequest(),
                                  &v1::ListMapsResponse::mutable_maps, timeout_);
}

absl::StatusOr<std::vector<v1::MapVersion>> MapClient::ListVersions(const std::string& map_name) {
  v1::ListMapVersionsRequest request;
  request.set_map_name(map_name);
  return CallForAllPages<v1::MapVersion>(*stub_, &v1::MapService::Stub::ListMapVersions, request,
                                         &v1::ListMapVersionsResponse::mutable_versions, timeout_);
}

absl::StatusOr<v1::Map> MapClient::Get(const std::string& map_name) {
  v1::GetMapRequest request;
  request.set_map_name(map_name);
  auto response = Call(*stub_, &v1::MapService::Stub::GetMap, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_map());
}

absl::StatusOr<v1::MapVersion> MapClient::GetVersion(const std::string& map_name,
                                                     std::int64_t version) {
  v1::GetMapVersionRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  auto response = Call(*stub_, &v1::MapService::Stub::GetMapVersion, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_version());
}

absl::StatusOr<v1::Map> MapClient::Activate(const std::string& map_name, std::int64_t version) {
  v1::ActivateMapVersionRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  auto response = Call(*stub_, &v1::MapService::Stub::ActivateMapVersion, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_map());
}

absl::Status MapClient::DeleteVersion(const std::string& map_name, std::int64_t version) {
  v1::DeleteMapVersionRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  return Call(*stub_, &v1::MapService::Stub::DeleteMapVersion, request, timeout_).status();
}

absl::Status MapClient::Delete(const std::string& map_name) {
  v1::DeleteMapRequest request;
  request.set_map_name(map_name);
  return Call(*stub_, &v1::MapService::Stub::DeleteMap, request, timeout_).status();
}

}  // namespace dcloc::client
