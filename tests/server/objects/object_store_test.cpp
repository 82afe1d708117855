#include "server/objects/object_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "server/objects/object_error.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/s3_stub.h"

namespace dcloc::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using Clock = std::chrono::steady_clock;
using Kind = S3Fault::Kind;

const S3Fault kUnavailable{.kind = Kind::kStatus, .status = 503, .code = "SlowDown"};

/// What passes: after any of them the same request may be answered.
const std::map<std::string, S3Fault> kPassing = {
    {"500", {.kind = Kind::kStatus, .status = 500, .code = "InternalError"}},
    {"503", kUnavailable},
    {"429", {.kind = Kind::kStatus, .status = 429, .code = "TooManyRequests"}},
    {"400", {.kind = Kind::kStatus, .status = 400, .code = "RequestTimeout"}},
    {"reset", {.kind = Kind::kReset}},
    {"cut", {.kind = Kind::kCutBody}}};

class ObjectStoreTest : public ::testing::Test {
 protected:
  ObjectStoreTest() { Open(stub_.Options()); }

  void Open(const ObjectOptions& options) { store_ = *ObjectStore::Open(options); }

  absl::Status Put(const std::string& key, const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    const FileDescriptor file = *OpenToRead(folder_.Write("file", bytes));
    return store_->Put(key, file, static_cast<std::int64_t>(text.size()), Sha256Of(bytes));
  }

  absl::StatusOr<std::string> Read(const std::string& key, std::size_t size,
                                   std::int64_t offset = 0) {
    std::string text(size, '?');
    absl::Status status = store_->Read(key, offset, std::as_writable_bytes(std::span(text)));
    if (!status.ok()) return status;
    return text;
  }

  S3Stub stub_;
  TemporaryFolder folder_;
  std::unique_ptr<ObjectStore> store_;
};

TEST_F(ObjectStoreTest, WhatIsPutCanBeReadListedCopiedAndRemoved) {
  ASSERT_TRUE(Put("maps/a", "abcdef").ok());
  EXPECT_THAT(stub_.objects(), ElementsAre(Pair("site/maps/a", "abcdef")));
  EXPECT_EQ(*Read("maps/a", 3, 2), "cde");
  EXPECT_EQ(*store_->SizeOf("maps/a"), 6);
  ASSERT_TRUE(store_->PutText("ages", "1 2").ok());
  EXPECT_EQ(*store_->ReadText("ages"), "1 2");
  ASSERT_TRUE(store_->Copy("maps/a", "quarantine/a").ok());
  EXPECT_THAT(*store_->List("quarantine/"), ElementsAre(Pair("a", 6)));
  ASSERT_TRUE(store_->Remove("maps/a").ok());
  EXPECT_TRUE(store_->Remove("maps/a").ok()) << "once more does no harm";
  EXPECT_TRUE(store_->List("maps/")->empty());
  EXPECT_EQ(store_->counts().written_bytes, 9);
  EXPECT_EQ(store_->counts().failed, 0);
}

TEST_F(ObjectStoreTest, WhatIsMissingIsNotFound) {
  EXPECT_TRUE(absl::IsNotFound(Read("none", 1).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->ReadText("none").status()));
  EXPECT_TRUE(absl::IsNotFound(store_->SizeOf("none").status()));
  EXPECT_TRUE(absl::IsNotFound(store_->Copy("none", "other")));
  EXPECT_EQ(store_->counts().repeated, 0) << "it would not be there the next time either";
}

TEST_F(ObjectStoreTest, AnObjectThatEndsBeforeIsDataLoss) {
  ASSERT_TRUE(Put("a", "abc").ok());
  EXPECT_TRUE(absl::IsDataLoss(Read("a", 2, 7).status()));
}

TEST_F(ObjectStoreTest, LargeObjectsAreReadInRangesAndLongListsInPages) {
  ObjectOptions options = stub_.Options();
  options.max_range_bytes = 4;
  Open(options);
  ASSERT_TRUE(Put("a", "0123456789").ok());
  EXPECT_EQ(*Read("a", 9, 1), "123456789");
  EXPECT_THAT(stub_.requests(), ElementsAre(HasSubstr("PUT"), HasSubstr("bytes=1-4"),
                                            HasSubstr("bytes=5-8"), HasSubstr("bytes=9-9")));
  stub_.SetPageSize(3);
  for (int i = 0; i < 10; ++i) stub_.Put(absl::StrCat("site/list/", i), "x");
  EXPECT_EQ(store_->List("list/")->size(), 10U);
}

TEST_F(ObjectStoreTest, WhatPassesIsTriedAgain) {
  ASSERT_TRUE(Put("a", "abcdef").ok());
  for (const auto& [name, fault] : kPassing) {
    SCOPED_TRACE(name);
    const std::size_t before = stub_.requests().size();
    stub_.FailNext(fault, 2, "GET");
    EXPECT_EQ(*Read("a", 6), "abcdef");
    EXPECT_EQ(stub_.requests().size(), before + 3);
  }
  EXPECT_GT(store_->counts().repeated, 0);
  EXPECT_EQ(store_->counts().failed, 0);
}

TEST_F(ObjectStoreTest, AnUploadThatBreaksOffIsSentAgainFromItsBeginning) {
  const std::string large(3 << 20, 'x');
  stub_.FailNext({.kind = Kind::kReset}, 2, "PUT");
  ASSERT_TRUE(Put("a", large).ok());
  EXPECT_EQ(stub_.objects()["site/a"], large);
  EXPECT_EQ(stub_.requests().size(), 3U);
}

TEST_F(ObjectStoreTest, AttemptsAreBoundedInNumberAndTime) {
  ASSERT_TRUE(Put("a", "abcdef").ok());
  for (const auto& [name, fault] : kPassing) {
    SCOPED_TRACE(name);
    Open(stub_.Options());
    stub_.FailNext(fault, 100, "GET");
    const auto begin = Clock::now();
    const absl::Status status = Read("a", 6).status();
    EXPECT_TRUE(absl::IsUnavailable(status)) << status;
    EXPECT_TRUE(IsObjectStoreError(status));
    EXPECT_THAT(MessageOf(status), HasSubstr("try again"));
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds(3));
    EXPECT_LE(store_->counts().repeated, 3);
    stub_.ForgetFaults();
  }
}

TEST_F(ObjectStoreTest, WhatWouldNotBeBetterIsNotTriedAgain) {
  stub_.FailNext({.kind = Kind::kStatus, .status = 403, .code = "AccessDenied"});
  const absl::Status status = Read("a", 1).status();
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_THAT(ObjectStoreReason(status), HasSubstr("403 AccessDenied"));
  EXPECT_THAT(MessageOf(status), ::testing::Not(HasSubstr("403"))) << "it is not the client's";
  EXPECT_EQ(store_->counts().repeated, 0);
  EXPECT_FALSE(store_->away()) << "it has answered";
  ObjectOptions options = stub_.Options();
  options.location = "s3://another/site";
  Open(options);
  EXPECT_THAT(ObjectStoreReason(store_->List("").status()), HasSubstr("NoSuchBucket"));
}

TEST_F(ObjectStoreTest, WhileItIsAwayNobodyWaitsAndOneAtATimeLooks) {
  ASSERT_TRUE(Put("a", "abc").ok());
  stub_.Stop();
  EXPECT_TRUE(absl::IsUnavailable(Read("a", 3).status()));
  EXPECT_TRUE(store_->away());
  const auto begin = Clock::now();
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(Read("a", 3).ok());
  EXPECT_LT(Clock::now() - begin, std::chrono::milliseconds(500));
  stub_.Start();
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_EQ(*Read("a", 3), "abc") << "it is found to be back by who asks";
  EXPECT_FALSE(store_->away());
}

TEST_F(ObjectStoreTest, ABodyThatIsSlowOrDoesNotComeIsCutInTime) {
  ASSERT_TRUE(Put("a", std::string(100, 'x')).ok());
  ObjectOptions options = stub_.Options();
  options.timeout = std::chrono::milliseconds(400);
  for (const Kind kind : {Kind::kSlowBody, Kind::kNoAnswer}) {
    Open(options);
    stub_.FailNext({.kind = kind}, 100, "GET");
    const auto begin = Clock::now();
    EXPECT_TRUE(absl::IsUnavailable(Read("a", 100).status()));
    EXPECT_LT(Clock::now() - begin, std::chrono::milliseconds(2500));
    EXPECT_TRUE(store_->away());
    stub_.ForgetFaults();
  }
}

TEST_F(ObjectStoreTest, ANewAccessKeyIsTakenWithoutARestart) {
  const auto write = [&](const std::string& key) {
    const std::string text =
        absl::StrCat("[default]\naws_access_key_id = ", key, "\naws_secret_access_key = s\n");
    const auto path = folder_.Write("keys", std::as_bytes(std::span(text)));
    std::filesystem::permissions(path, std::filesystem::perms::owner_read);
    return path;
  };
  ObjectOptions options = stub_.Options();
  options.credentials_file = write("old-key");
  Open(options);
  EXPECT_THAT(ObjectStoreReason(store_->PutText("a", "x")), HasSubstr("InvalidAccessKeyId"));
  std::filesystem::remove(options.credentials_file);
  write("stub-key");
  EXPECT_TRUE(store_->PutText("a", "x").ok());
}

}  // namespace
}  // namespace dcloc::server
