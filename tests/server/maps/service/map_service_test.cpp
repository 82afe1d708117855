#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class MapServiceTest : public ::testing::Test {
 protected:
  grpc::Status Upload(const std::vector<std::byte>& bytes, const v1::UploadMapHeader& header) {
    return UploadMap(*server_.maps, header, bytes, &uploaded_, 1000);
  }
  grpc::Status Upload(const std::vector<std::byte>& bytes) {
    return Upload(bytes, HeaderOf(bytes));
  }

  v1::ListMapsResponse ListMaps() {
    Call call;
    v1::ListMapsResponse response;
    EXPECT_TRUE(server_.maps->ListMaps(&call, {}, &response).ok());
    return response;
  }

  TestServer server_;
  v1::UploadMapResponse uploaded_;
};

TEST_F(MapServiceTest, AnEmptyStoreHasNoMaps) {
  EXPECT_EQ(ListMaps().maps_size(), 0);
  EXPECT_EQ(ListMaps().next_page_token(), "");
}

TEST_F(MapServiceTest, WhatWasUploadedIsDownloaded) {
  const std::vector<std::byte> bytes = SmallMap("big", 3000);  // some megabytes: several chunks
  ASSERT_GT(bytes.size(), 2U << 20);
  const grpc::Status status = UploadMap(*server_.maps, HeaderOf(bytes), bytes, &uploaded_);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(uploaded_.version().version(), 1);
  EXPECT_TRUE(uploaded_.version().active());
  EXPECT_EQ(uploaded_.version().info().keyframe_count(), 3000);
  EXPECT_EQ(uploaded_.version().info().drive_name(), "big");
  EXPECT_GT(uploaded_.version().create_time().seconds(), 1'600'000'000);

  Call call;
  v1::DownloadMapRequest request;
  request.set_map_name("town");
  const auto reader = server_.maps->DownloadMap(&call, request);
  v1::DownloadMapResponse message;
  ASSERT_TRUE(reader->Read(&message));
  EXPECT_EQ(message.version().sha256(), Sha256Of(bytes));
  std::string received;
  while (reader->Read(&message)) {
    ASSERT_EQ(message.chunk().offset_bytes(), static_cast<std::int64_t>(received.size()));
    received += message.chunk().data();
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(Sha256Of(std::as_bytes(std::span(received))), Sha256Of(bytes));
}

TEST_F(MapServiceTest, DamagedUploadsAreDataLossAndLeaveNothing) {
  const std::vector<std::byte> bytes = SmallMap();
  v1::UploadMapHeader header = HeaderOf(bytes);
  header.set_sha256(std::string(64, '0'));
  grpc::Status status = Upload(bytes, header);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DATA_LOSS);
  EXPECT_THAT(status.error_message(), HasSubstr("sha256"));

  const std::vector<std::byte> truncated(bytes.begin(), bytes.end() - 1);
  status = Upload(truncated, HeaderOf(bytes));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DATA_LOSS);

  std::vector<std::byte> flipped = bytes;
  flipped[flipped.size() / 2] ^= std::byte{16};
  status = Upload(flipped, HeaderOf(bytes));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DATA_LOSS) << "against the announced hash";
  status = Upload(flipped, HeaderOf(flipped));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::DATA_LOSS) << "with a hash of its own";
  EXPECT_EQ(ListMaps().maps_size(), 0);
}

TEST_F(MapServiceTest, MalformedUploadsAreRefusedByName) {
  const std::vector<std::byte> bytes = SmallMap();
  v1::UploadMapHeader header = HeaderOf(bytes);
  header.set_map_name("No Such Name");
  grpc::Status status = Upload(bytes, header);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("header.map_name"));

  header = HeaderOf(bytes);
  header.set_size_bytes(10);
  status = Upload(bytes, header);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("chunk.data"));

  const auto status_of = [&](const std::vector<v1::UploadMapRequest>& requests) {
    Call call;
    const auto writer = server_.maps->UploadMap(&call, &uploaded_);
    for (const auto& request : requests) writer->Write(request);
    writer->WritesDone();
    return writer->Finish();
  };
  v1::UploadMapRequest with_header;
  *with_header.mutable_header() = HeaderOf(bytes);
  v1::UploadMapRequest with_chunk;
  with_chunk.mutable_chunk()->set_data("x");
  with_chunk.mutable_chunk()->set_offset_bytes(3);
  EXPECT_THAT(status_of({}).error_message(), HasSubstr("header is missing"));
  EXPECT_THAT(status_of({with_chunk}).error_message(), HasSubstr("header is missing"));
  EXPECT_THAT(status_of({with_header, with_header}).error_message(), HasSubstr("chunk is missing"));
  EXPECT_THAT(status_of({with_header, with_chunk}).error_message(), HasSubstr("offset_bytes is 3"));
  EXPECT_EQ(status_of({with_header}).error_code(), grpc::StatusCode::DATA_LOSS);
}

TEST_F(MapServiceTest, ACancelledUploadLeavesNothing) {
  const std::vector<std::byte> bytes = SmallMap();
  {
    Call call;
    const auto writer = server_.maps->UploadMap(&call, &uploaded_);
    v1::UploadMapRequest request;
    *request.mutable_header() = HeaderOf(bytes);
    ASSERT_TRUE(writer->Write(request));
    call.TryCancel();
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  EXPECT_EQ(ListMaps().maps_size(), 0);
  // The caller knows of its cancelling before the server does.
  grpc::Status status = Upload(bytes);
  for (int i = 0; !status.ok() && i < 500; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    status = Upload(bytes);
  }
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(MapServiceTest, ListsArePaged) {
  const std::vector<std::byte> bytes = SmallMap();
  for (const char* name : {"a", "b", "c"}) {
    v1::UploadMapHeader header = HeaderOf(bytes);
    header.set_map_name(name);
    ASSERT_TRUE(Upload(bytes, header).ok());
  }
  v1::ListMapsRequest request;
  request.set_page_size(2);
  std::vector<std::string> names;
  int pages = 0;
  do {
    Call call;
    v1::ListMapsResponse response;
    ASSERT_TRUE(server_.maps->ListMaps(&call, request, &response).ok());
    for (const v1::Map& map : response.maps()) names.push_back(map.name());
    request.set_page_token(response.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_THAT(names, ::testing::ElementsAre("a", "b", "c"));
  EXPECT_EQ(pages, 2);

  Call call;
  v1::ListMapsResponse response;
  request.set_page_size(5000);
  const grpc::Status status = server_.maps->ListMaps(&call, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("page_size is 5000"));
}

TEST_F(MapServiceTest, VersionsAreListedNewestFirstAndPaged) {
  for (const char* name : {"first", "second", "third"}) ASSERT_TRUE(Upload(SmallMap(name)).ok());
  v1::ListMapVersionsRequest request;
  request.set_map_name("town");
  request.set_page_size(2);
  std::vector<std::int64_t> versions;
  do {
    Call call;
    v1::ListMapVersionsResponse response;
    ASSERT_TRUE(server_.maps->ListMapVersions(&call, request, &response).ok());
    for (const v1::MapVersion& version : response.versions()) {
      versions.push_back(version.version());
      EXPECT_EQ(version.active(), version.version() == 3);
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_THAT(versions, ::testing::ElementsAre(3, 2, 1));
}

TEST_F(MapServiceTest, ActivatesRollsBackAndDeletes) {
  for (const char* name : {"first", "second"}) ASSERT_TRUE(Upload(SmallMap(name)).ok());
  v1::ActivateMapVersionRequest activate;
  activate.set_map_name("town");
  activate.set_version(1);
  v1::ActivateMapVersionResponse activated;
  {
    Call call;
    ASSERT_TRUE(server_.maps->ActivateMapVersion(&call, activate, &activated).ok());
  }
  EXPECT_EQ(activated.map().active_version(), 1);
  EXPECT_EQ(activated.map().version_count(), 2);
  v1::DeleteMapVersionRequest remove;
  remove.set_map_name("town");
  remove.set_version(1);
  v1::DeleteMapVersionResponse removed;
  {
    Call call;
    const grpc::Status status = server_.maps->DeleteMapVersion(&call, remove, &removed);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
    EXPECT_THAT(status.error_message(), HasSubstr("active"));
  }
  remove.set_version(2);
  {
    Call call;
    EXPECT_TRUE(server_.maps->DeleteMapVersion(&call, remove, &removed).ok());
  }
  v1::DeleteMapRequest remove_map;
  remove_map.set_map_name("town");
  v1::DeleteMapResponse removed_map;
  {
    Call call;
    EXPECT_TRUE(server_.maps->DeleteMap(&call, remove_map, &removed_map).ok());
  }
  EXPECT_EQ(ListMaps().maps_size(), 0);
}

TEST_F(MapServiceTest, WhatIsNotThereIsNotFoundAndBadNamesAreRefused) {
  ASSERT_TRUE(Upload(SmallMap()).ok());
  const auto get = [&](const std::string& name, std::int64_t version) {
    Call call;
    v1::GetMapVersionRequest request;
    request.set_map_name(name);
    request.set_version(version);
    v1::GetMapVersionResponse response;
    return server_.maps->GetMapVersion(&call, request, &response);
  };
  EXPECT_TRUE(get("town", 0).ok());
  EXPECT_TRUE(get("town", 1).ok());
  EXPECT_EQ(get("town", 2).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(get("city", 0).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(get("town", -1).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(get(std::string(1'000'000, 'a'), 0).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(get("' OR 1=1 --", 0).error_code(), grpc::StatusCode::INVALID_ARGUMENT);

  Call call;
  v1::DownloadMapRequest request;
  request.set_map_name("city");
  const auto reader = server_.maps->DownloadMap(&call, request);
  v1::DownloadMapResponse message;
  EXPECT_FALSE(reader->Read(&message));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace dcloc::server
