#include "server/maps/catalogue/catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/places.h"

// What each catalogue promises of maps, versions, labels and files.
namespace dcloc::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

constexpr std::int64_t kNewest = std::numeric_limits<std::int64_t>::max();

std::string FileNamed(char digit) { return std::string(64, digit); }

MapInfo InfoOf(std::uint64_t size_bytes) {
  MapInfo info;
  info.size_bytes = size_bytes;
  return info;
}

class CatalogueTest : public ::testing::TestWithParam<CatalogueImplementation> {
 protected:
  void SetUp() override {
    if (!GetParam().is_there) GTEST_SKIP() << GetParam().name << " is not installed";
    place_ = GetParam().make_place();
    catalogue_ = place_->Open();
  }

  std::int64_t Add(const std::string& map_name, char digit, std::uint64_t size_bytes = 1) {
    const auto record = catalogue_->AddVersion(map_name, FileNamed(digit), InfoOf(size_bytes), {});
    EXPECT_TRUE(record.ok()) << record.status();
    return record.ok() ? record->version : 0;
  }

  std::vector<std::string> NamesOf(const std::string& prefix, const std::string& after = "",
                                   int limit = 100) {
    std::vector<std::string> names;
    const auto maps = catalogue_->ListMaps(prefix, after, limit);
    for (const MapRecord& map : *maps) {
      names.push_back(map.name);
    }
    return names;
  }

  std::unique_ptr<CataloguePlace> place_;
  std::unique_ptr<Catalogue> catalogue_;
};

TEST_P(CatalogueTest, WhatIsAddedIsThereAfterwardsToTheLastBit) {
  MapInfo info = InfoOf(123);
  info.name = std::string("drive\0\xff", 7);  // a file may say anything
  info.description = "'; DROP TABLE map; --";
  info.keyframe_count = 7;
  info.point_count = 1'000'000'007;
  info.length_m = 0.1 + 0.2;
  info.min_map_m = {-1e-300, 1.0 / 3.0, 500'000.000000001};
  info.max_map_m = {1e300, 2.0 / 3.0, 5'400'000.3};
  info.has_elevation = true;
  info.anchor = GeodeticAnchor{.origin = {.latitude_deg = 52.123456789012345,
                                          .longitude_deg = -179.99999999999997,
                                          .height_m = 0.1},
                               .x_axis_east_rad = 0.1};
  ASSERT_TRUE(catalogue_->AddVersion("town", FileNamed('a'), info, {}).ok());
  catalogue_.reset();
  catalogue_ = place_->Open();
  const MapVersionRecord record = *catalogue_->GetVersion("town", 1);
  EXPECT_EQ(record.map_name, "town");
  EXPECT_EQ(record.sha256, FileNamed('a'));
  EXPECT_FALSE(record.active);
  EXPECT_EQ(record.info.size_bytes, 123U);
  EXPECT_EQ(record.info.name, info.name);
  EXPECT_EQ(record.info.description, info.description);
  EXPECT_EQ(record.info.keyframe_count, 7U);
  EXPECT_EQ(record.info.point_count, 1'000'000'007U);
  EXPECT_EQ(record.info.length_m, info.length_m);
  EXPECT_EQ(record.info.min_map_m, info.min_map_m);
  EXPECT_EQ(record.info.max_map_m, info.max_map_m);
  EXPECT_TRUE(record.info.has_elevation);
  ASSERT_TRUE(record.info.anchor.has_value());
  EXPECT_EQ(record.info.anchor->origin.latitude_deg, info.anchor->origin.latitude_deg);
  EXPECT_EQ(record.info.anchor->origin.longitude_deg, info.anchor->origin.longitude_deg);
  EXPECT_EQ(record.info.anchor->x_axis_east_rad, info.anchor->x_axis_east_rad);
}

TEST_P(CatalogueTest, VersionsAreNumberedOnceAndListedNewestFirst) {
  EXPECT_EQ(Add("town", 'a'), 1);
  EXPECT_EQ(Add("town", 'b'), 2);
  EXPECT_EQ(Add("town", 'a'), 1) << "the map has that file already";
  ASSERT_TRUE(catalogue_->DeleteVersion("town", 2).ok());
  EXPECT_EQ(Add("town", 'c'), 3) << "a number is not used again";
  EXPECT_EQ(Add("town", 'b'), 4);
  std::vector<std::int64_t> versions;
  const auto listed = catalogue_->ListVersions("town", 4, 2);
  for (const MapVersionRecord& record : *listed) {
    versions.push_back(record.version);
  }
  EXPECT_THAT(versions, ElementsAre(3, 1));
  EXPECT_EQ(catalogue_->GetMap("town")->version_count, 3);
  EXPECT_THAT(*catalogue_->ListVersions("town", 1, 10), IsEmpty());
  EXPECT_EQ(catalogue_->ListVersions("city", kNewest, 10).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_P(CatalogueTest, LabelsMoveTogether) {
  for (const char digit : {'a', 'b', 'c'}) Add("town", digit);
  EXPECT_EQ(catalogue_->GetVersion("town", 0).status().code(),
            absl::StatusCode::kFailedPrecondition);
  ASSERT_TRUE(catalogue_->Activate("town", 1).ok());
  ASSERT_TRUE(catalogue_->SetCanary("town", 2, 0.25).ok());
  EXPECT_EQ(catalogue_->GetMap("town")->canary_share, 0.25);
  EXPECT_EQ(catalogue_->SetCanary("town", 1, 0.5).code(), absl::StatusCode::kFailedPrecondition);
  ASSERT_TRUE(catalogue_->Activate("town", 2).ok());
  MapRecord map = *catalogue_->GetMap("town");
  EXPECT_EQ(map.active_version, 2);
  EXPECT_EQ(map.previous_version, 1);
  EXPECT_EQ(map.canary_version, 0);
  EXPECT_EQ(map.canary_share, 0.0);
  ASSERT_TRUE(catalogue_->Activate("town", 2).ok());
  EXPECT_EQ(catalogue_->GetMap("town")->previous_version, 1) << "nothing has changed";
  EXPECT_EQ(catalogue_->GetVersion("town", 0)->version, 2);
  EXPECT_TRUE(catalogue_->GetVersion("town", 0)->active);
  EXPECT_EQ(catalogue_->Activate("town", 9).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(catalogue_->Activate("city", 1).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(catalogue_->SetCanary("town", 9, 0.5).code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(catalogue_->SetCanary("town", 3, 0.5).ok());
  ASSERT_TRUE(catalogue_->SetCanary("town", 0, 0.0).ok());
  EXPECT_EQ(catalogue_->GetMap("town")->canary_version, 0);
}

TEST_P(CatalogueTest, AVersionWithALabelIsNotDeleted) {
  for (const char digit : {'a', 'b', 'c'}) Add("town", digit);
  ASSERT_TRUE(catalogue_->Activate("town", 1).ok());
  ASSERT_TRUE(catalogue_->Activate("town", 2).ok());
  ASSERT_TRUE(catalogue_->SetCanary("town", 3, 0.5).ok());
  EXPECT_THAT(MessageOf(catalogue_->DeleteVersion("town", 2)), HasSubstr("is active"));
  EXPECT_THAT(MessageOf(catalogue_->DeleteVersion("town", 3)), HasSubstr("is the canary"));
  EXPECT_TRUE(catalogue_->DeleteVersion("town", 1).ok());
  EXPECT_EQ(catalogue_->GetMap("town")->previous_version, 0);
  EXPECT_EQ(catalogue_->DeleteVersion("town", 1).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(catalogue_->DeleteVersion("city", 1).code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(catalogue_->DeleteMap("town").ok());
  EXPECT_EQ(catalogue_->GetMap("town").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(catalogue_->GetVersion("town", 2).status().code(), absl::StatusCode::kNotFound);
}

TEST_P(CatalogueTest, ATenantHasItsOwnMapsInTheOrderOfTheirBytes) {
  for (const char* name : {"b", "a_1", "a-1", "a", "acme/town", "acme/a", "acm/x"}) Add(name, 'a');
  EXPECT_THAT(NamesOf(""), ElementsAre("a", "a-1", "a_1", "b"));
  EXPECT_THAT(NamesOf("", "a", 2), ElementsAre("a-1", "a_1"));
  EXPECT_THAT(NamesOf("acme/"), ElementsAre("acme/a", "acme/town"));
  EXPECT_THAT(NamesOf("acme/", "acme/a"), ElementsAre("acme/town"));
  EXPECT_THAT(NamesOf("ac/"), IsEmpty());
}

TEST_P(CatalogueTest, AFileCountsOnce) {
  Add("town", 'a', 100);
  Add("city", 'a', 100);
  Add("city", 'b', 10);
  Add("acme/town", 'c', 1);
  EXPECT_EQ(*catalogue_->SizeOfMaps(""), 110);
  EXPECT_EQ(*catalogue_->SizeOfMaps("acme/"), 1);
  EXPECT_EQ(*catalogue_->SizeOfMaps("none/"), 0);
  EXPECT_EQ(*catalogue_->SizeOfFile("", FileNamed('b')), 10);
  EXPECT_EQ(*catalogue_->SizeOfFile("acme/", FileNamed('b')), 0);
  EXPECT_THAT(*catalogue_->ListFiles(),
              UnorderedElementsAre(Pair(FileNamed('a'), 100), Pair(FileNamed('b'), 10),
                                   Pair(FileNamed('c'), 1)));
}

TEST_P(CatalogueTest, AFileIsLooseOnceItsLastVersionIsGone) {
  ASSERT_TRUE(catalogue_->AddLooseFile(FileNamed('a')).ok());
  ASSERT_TRUE(catalogue_->AddLooseFile(FileNamed('a')).ok());
  EXPECT_THAT(*catalogue_->ListLooseFiles(), ElementsAre(FileNamed('a')));
  EXPECT_FALSE(*catalogue_->HasFile(FileNamed('a')));
  Add("town", 'a');
  Add("city", 'a');
  EXPECT_THAT(*catalogue_->ListLooseFiles(), IsEmpty());
  EXPECT_TRUE(*catalogue_->HasFile(FileNamed('a')));
  ASSERT_TRUE(catalogue_->DeleteMap("town").ok());
  EXPECT_THAT(*catalogue_->ListLooseFiles(), IsEmpty());
  ASSERT_TRUE(catalogue_->DeleteVersion("city", 1).ok());
  EXPECT_THAT(*catalogue_->ListLooseFiles(), ElementsAre(FileNamed('a')));
  ASSERT_TRUE(catalogue_->RemoveLooseFile(FileNamed('a')).ok());
  EXPECT_THAT(*catalogue_->ListLooseFiles(), IsEmpty());
}

TEST_P(CatalogueTest, ManyMayChangeItAtOnce) {
  constexpr int kClients = 4;
  constexpr int kRounds = 8;
  std::vector<std::thread> clients;
  clients.reserve(kClients);
  for (int client = 0; client < kClients; ++client) {
    clients.emplace_back([&, client] {
      for (int round = 0; round < kRounds; ++round) {
        const std::string own = absl::StrCat(std::string(60, 'e'), client, 100 + round);
        for (const std::string& sha256 : {own, std::string(60, 'f') + absl::StrCat(1000 + round)}) {
          absl::StatusOr<MapVersionRecord> record;
          do {  // what others hold up may be tried again
            record = catalogue_->AddVersion("town", sha256, InfoOf(1), {});
          } while (absl::IsUnavailable(record.status()));
          ASSERT_TRUE(record.ok()) << record.status();
        }
      }
    });
  }
  for (std::thread& client : clients) client.join();
  const auto records = *catalogue_->ListVersions("town", kNewest, 1000);
  std::set<std::string> files;
  for (const MapVersionRecord& record : records) files.insert(record.sha256);
  EXPECT_EQ(records.size(), kRounds * (kClients + 1)) << "each file once";
  EXPECT_EQ(files.size(), records.size());
}

TEST_P(CatalogueTest, OfTwoThatDeleteTheLastVersionsOfAFileOneNotesIt) {
  for (int round = 0; round < 10; ++round) {
    const std::vector<std::string> names = {"town", "city"};
    for (const std::string& name : names) Add(name, 'a');
    std::vector<std::thread> clients;
    clients.reserve(names.size());
    for (const std::string& name : names) {
      clients.emplace_back([&] { EXPECT_TRUE(catalogue_->DeleteMap(name).ok()); });
    }
    for (std::thread& client : clients) client.join();
    ASSERT_THAT(*catalogue_->ListLooseFiles(), ElementsAre(FileNamed('a'))) << "round " << round;
    ASSERT_TRUE(catalogue_->RemoveLooseFile(FileNamed('a')).ok());
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogues, CatalogueTest, ::testing::ValuesIn(CatalogueImplementations()),
                         NameOfImplementation());

}  // namespace
}  // namespace dcloc::server
