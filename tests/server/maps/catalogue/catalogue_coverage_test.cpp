#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/maps/catalogue/catalogue.h"
#include "tests/server/fixtures/places.h"

// What each catalogue promises of coverage: what a look at every box would find.
namespace dcloc::server {
namespace {

using ::testing::IsEmpty;

using Found = std::vector<std::pair<std::string, double>>;

/// Maps with random boxes, some of them without an extent, on both sides of the date line.
class CatalogueCoverageTest : public ::testing::TestWithParam<CatalogueImplementation> {
 protected:
  static constexpr int kMapCount = 40;

  void SetUp() override {
    if (!GetParam().is_there) GTEST_SKIP() << GetParam().name << " is not installed";
    place_ = GetParam().make_place();
    catalogue_ = place_->Open();
    for (int i = 0; i < kMapCount; ++i) {
      const std::string name = absl::StrCat(i % 4 == 0 ? "acme/" : "", "map-", 100 + i);
      boxes_.emplace_back(name, RandomBoxes(/*on_earth=*/i % 5 != 0));
      ASSERT_TRUE(catalogue_->AddVersion(name, HashOf(i), {}, boxes_.back().second).ok());
      // Of a version that is not active nothing is found.
      ASSERT_TRUE(catalogue_->AddVersion(name, HashOf(1000 + i), {}, RandomBoxes(true)).ok());
      ASSERT_TRUE(catalogue_->Activate(name, 1).ok());
    }
  }

  static std::string HashOf(int number) {
    return absl::StrCat(std::string(60, 'a'), 1000 + number);
  }

  double Random(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(random_);
  }

  std::vector<CoverageBox> RandomBoxes(bool on_earth) {
    std::vector<CoverageBox> boxes;
    const double x = Random(-3000.0, 3000.0) + 500'000.0;
    const double y = Random(-3000.0, 3000.0) + 5'400'000.0;
    const double longitude_deg = Random(179.9, 180.1);
    const double latitude_deg = Random(59.9, 60.1);
    for (int i = 0; i < 5; ++i) {
      const double width = i == 0 ? 0.0 : Random(0.0, 75.0);
      CoverageBox box{.map_m = {x + 60.0 * i, x + 60.0 * i + width, y, y + width},
                      .degrees = std::nullopt};
      if (on_earth) {
        const double shift_deg = 0.001 * i;
        box.degrees = Rectangle{longitude_deg + shift_deg, longitude_deg + shift_deg + width / 56e3,
                                latitude_deg, latitude_deg + width / 111e3};
      }
      boxes.push_back(box);
    }
    return boxes;
  }

  /// By looking at every box, with the date line anywhere.
  Found OnEarth(const std::string& prefix, const GeodeticPosition& position,
                double radius_m) const {
    const double cosine = std::cos(position.latitude_deg * M_PI / 180.0);
    return Nearest([&](const std::string& name, const CoverageBox& box) {
      const bool ours = name.starts_with(prefix) && name.find('/', prefix.size()) == name.npos;
      double least_m = INFINITY;
      for (const double turn_deg : {-360.0, 0.0, 360.0}) {
        if (!ours || !box.degrees) continue;
        least_m = std::min(least_m,
                           111'320.0 * DistanceTo(*box.degrees, position.longitude_deg + turn_deg,
                                                  position.latitude_deg, cosine));
      }
      return least_m <= radius_m ? least_m : INFINITY;
    });
  }

  template <typename Distance>
  Found Nearest(const Distance& distance_of) const {
    Found found;
    for (const auto& [name, boxes] : boxes_) {
      double least_m = INFINITY;
      for (const CoverageBox& box : boxes) least_m = std::min(least_m, distance_of(name, box));
      if (std::isfinite(least_m)) found.emplace_back(name, least_m);
    }
    std::ranges::sort(found, {}, [](const auto& one) { return std::pair(one.second, one.first); });
    return found;
  }

  static Found FoundOf(const absl::StatusOr<std::vector<CoverageRecord>>& records) {
    Found found;
    EXPECT_TRUE(records.ok()) << records.status();
    for (const CoverageRecord& record : *records) {
      EXPECT_EQ(record.version, 1);
      found.emplace_back(record.map_name, record.distance_m);
    }
    return found;
  }

  /// The same maps in the same order, and the distances but for rounding.
  static void ExpectSame(const Found& found, const Found& expected, const std::string& of) {
    ASSERT_EQ(found.size(), expected.size()) << of;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].first, expected[i].first) << of;
      EXPECT_NEAR(found[i].second, expected[i].second, 1e-6) << of;
    }
  }

  std::mt19937 random_{7};
  std::vector<std::pair<std::string, std::vector<CoverageBox>>> boxes_;
  std::unique_ptr<CataloguePlace> place_;
  std::unique_ptr<Catalogue> catalogue_;
};

TEST_P(CatalogueCoverageTest, PlacesOnTheEarthAreFoundAsByLookingAtEveryBox) {
  int found_count = 0;
  for (int i = 0; i < 200; ++i) {
    double longitude_deg = Random(179.85, 180.15);
    if (longitude_deg > 180.0) longitude_deg -= 360.0;
    const GeodeticPosition place{.latitude_deg = Random(59.85, 60.15),
                                 .longitude_deg = longitude_deg};
    const std::string prefix = i % 3 == 0 ? "acme/" : "";
    const double radius_m = Random(0.0, 5000.0);
    const Found expected = OnEarth(prefix, place, radius_m);
    ExpectSame(FoundOf(catalogue_->FindCoverage(prefix, place, radius_m, 100)), expected,
               absl::StrCat("place ", i));
    found_count += static_cast<int>(expected.size());
  }
  EXPECT_GT(found_count, 100) << "there was something to find";
}

TEST_P(CatalogueCoverageTest, PlacesInAMapAreFoundAsByLookingAtEveryBox) {
  int found_count = 0;
  for (int i = 0; i < 200; ++i) {
    const auto& [map_name, boxes] = boxes_[static_cast<std::size_t>(i % kMapCount)];
    const std::string& name = map_name;
    const Rectangle& near = boxes[static_cast<std::size_t>(i % 5)].map_m;
    const Eigen::Vector2d p_map(near.min_x + Random(-90.0, 90.0), near.min_y + Random(-90.0, 90.0));
    const double radius_m = Random(0.0, 60.0);
    const Found expected = Nearest([&](const std::string& of, const CoverageBox& box) {
      const double distance_m = DistanceTo(box.map_m, p_map.x(), p_map.y());
      return of == name && distance_m <= radius_m ? distance_m : INFINITY;
    });
    ExpectSame(FoundOf(catalogue_->FindCoverage(name, p_map, radius_m)), expected,
               absl::StrCat("place ", i));
    found_count += static_cast<int>(expected.size());
  }
  EXPECT_GT(found_count, 50);
  EXPECT_EQ(catalogue_->FindCoverage("city", Eigen::Vector2d(0, 0), 1.0).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_P(CatalogueCoverageTest, OfManyTheNearestAreGivenAndCoverageGoesWithItsMap) {
  const GeodeticPosition place{.latitude_deg = 60.0, .longitude_deg = 180.0};
  const Found all = OnEarth("", place, 50'000.0);
  ASSERT_GT(all.size(), 3U);
  ExpectSame(FoundOf(catalogue_->FindCoverage("", place, 50'000.0, 3)),
             Found(all.begin(), all.begin() + 3), "the nearest");
  for (const auto& [name, boxes] : boxes_) ASSERT_TRUE(catalogue_->DeleteMap(name).ok());
  EXPECT_THAT(*catalogue_->FindCoverage("", place, 50'000.0, 3), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Catalogues, CatalogueCoverageTest,
                         ::testing::ValuesIn(CatalogueImplementations()), NameOfImplementation());

}  // namespace
}  // namespace dcloc::server
