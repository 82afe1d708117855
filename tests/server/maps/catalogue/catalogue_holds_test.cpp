#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/places.h"

// What each catalogue promises of holds.
namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// A catalogue with versions 1 and 2 of a map, none of them active.
class CatalogueHoldsTest : public ::testing::TestWithParam<CatalogueImplementation> {
 protected:
  void SetUp() override {
    if (!GetParam().is_there) GTEST_SKIP() << GetParam().name << " is not installed";
    place_ = GetParam().make_place();
    catalogue_ = place_->Open();
    for (const char digit : {'a', 'b'}) {
      EXPECT_TRUE(catalogue_->AddVersion("town", std::string(64, digit), {}, {}).ok());
    }
  }

  std::unique_ptr<CataloguePlace> place_;
  std::unique_ptr<Catalogue> catalogue_;
};

TEST_P(CatalogueHoldsTest, AVersionIsDeletedOnceItsLastHolderHasGivenItBack) {
  Hold first = *catalogue_->HoldVersion("town", 1, "a:1");
  Hold second = *catalogue_->HoldVersion("town", 1, "b:1");
  const absl::Status status = catalogue_->DeleteVersion("town", 1);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("version 1"), HasSubstr("in use")));
  first = Hold();
  EXPECT_EQ(catalogue_->DeleteVersion("town", 1).code(), absl::StatusCode::kFailedPrecondition);
  second = Hold();
  EXPECT_TRUE(catalogue_->DeleteVersion("town", 1).ok());
}

TEST_P(CatalogueHoldsTest, OneHolderMayHoldAVersionSeveralTimes) {
  Hold first = *catalogue_->HoldVersion("town", 1, "a:1");
  const Hold second = *catalogue_->HoldVersion("town", 1, "a:1");
  first = Hold();
  EXPECT_EQ(catalogue_->DeleteVersion("town", 1).code(), absl::StatusCode::kFailedPrecondition);
}

TEST_P(CatalogueHoldsTest, AMapIsDeletedOnceNoneOfItsVersionsIsHeld) {
  ASSERT_TRUE(catalogue_->AddVersion("city", std::string(64, 'a'), {}, {}).ok());
  Hold city = *catalogue_->HoldVersion("city", 1, "a:1");
  Hold town = *catalogue_->HoldVersion("town", 2, "a:1");
  EXPECT_THAT(MessageOf(catalogue_->DeleteMap("town")), HasSubstr("version 2"));
  EXPECT_TRUE(catalogue_->DeleteVersion("town", 1).ok()) << "that one is not held";
  town = Hold();
  EXPECT_TRUE(catalogue_->DeleteMap("town").ok()) << "another map's holds are its own";
  EXPECT_EQ(catalogue_->DeleteMap("town").code(), absl::StatusCode::kNotFound);
}

TEST_P(CatalogueHoldsTest, WhatIsNotThereCannotBeHeld) {
  EXPECT_EQ(catalogue_->HoldVersion("city", 1, "a:1").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(catalogue_->HoldVersion("town", 7, "a:1").status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(catalogue_->DeleteMap("town").ok());
  EXPECT_EQ(catalogue_->HoldVersion("town", 1, "a:1").status().code(), absl::StatusCode::kNotFound);
}

TEST_P(CatalogueHoldsTest, AFileHasOneHolderAtATimeWhetherItIsThereOrNot) {
  for (const std::string& sha256 : {std::string(64, 'a'), std::string(64, 'f')}) {
    Hold first = *catalogue_->HoldFile(sha256, "a:1");
    const absl::Status status = catalogue_->HoldFile(sha256, "b:1").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
    EXPECT_THAT(MessageOf(status), AllOf(HasSubstr(sha256), HasSubstr("a:1")));
    EXPECT_EQ(catalogue_->HoldFile(sha256, "a:1").status().code(), absl::StatusCode::kUnavailable);
    first = Hold();
    EXPECT_TRUE(catalogue_->HoldFile(sha256, "b:1").ok());
  }
}

TEST_P(CatalogueHoldsTest, AHoldMayOutliveItsCatalogue) {
  Hold version = *catalogue_->HoldVersion("town", 1, "a:1");
  const Hold file = *catalogue_->HoldFile(std::string(64, 'a'), "a:1");
  catalogue_.reset();
  version = Hold();
  catalogue_ = place_->Open();
  EXPECT_TRUE(catalogue_->DeleteVersion("town", 1).ok());
}

TEST_P(CatalogueHoldsTest, NoHoldIsTakenWhileItsVersionIsDeleted) {
  std::atomic<int> held = 0;
  constexpr int kHolders = 2;
  std::vector<std::thread> holders;
  holders.reserve(kHolders);
  for (int i = 0; i < kHolders; ++i) {
    holders.emplace_back([&] {
      for (int k = 0; k < 200; ++k) {
        const absl::StatusOr<Hold> hold = catalogue_->HoldVersion("town", 1, "a:1");
        if (!hold.ok()) return;
        ++held;
        std::this_thread::yield();
        --held;
      }
    });
  }
  while (!catalogue_->DeleteVersion("town", 1).ok()) std::this_thread::yield();
  EXPECT_EQ(held, 0);
  for (std::thread& holder : holders) holder.join();
}

INSTANTIATE_TEST_SUITE_P(Catalogues, CatalogueHoldsTest,
                         ::testing::ValuesIn(CatalogueImplementations()), NameOfImplementation());

}  // namespace
}  // namespace dcloc::server
