#include "server/app/map_file_metrics.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <span>
#include <string>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/s3_stub.h"

namespace dcloc::server {
namespace {

class MapFileMetricsTest : public ::testing::Test {
 protected:
  /// By name, with the value of the label behind it.
  std::map<std::string, double> Values() const {
    std::vector<prometheus::MetricFamily> families;
    AddMapFileMetrics(objects_.get(), cache_.get(), families);
    std::map<std::string, double> values;
    for (const prometheus::MetricFamily& family : families) {
      EXPECT_FALSE(family.help.empty()) << family.name;
      for (const prometheus::ClientMetric& metric : family.metric) {
        const std::string label = metric.label.empty() ? "" : " " + metric.label[0].value;
        values[family.name + label] = family.type == prometheus::MetricType::Counter
                                          ? metric.counter.value
                                          : metric.gauge.value;
      }
    }
    return values;
  }

  TemporaryFolder folder_;
  S3Stub stub_;
  std::shared_ptr<ObjectStore> objects_ = *ObjectStore::Open(stub_.Options());
  std::shared_ptr<MapCache> cache_ = *MapCache::Open(folder_.path() / "cache", 100);
};

TEST_F(MapFileMetricsTest, AnObjectStoresRequestsAndBytesAreCounted) {
  ASSERT_TRUE(objects_->PutText("a", "abc").ok());
  stub_.FailNext({.kind = S3Fault::Kind::kStatus, .status = 503});
  ASSERT_TRUE(objects_->ReadText("a").ok());
  std::map<std::string, double> values = Values();
  EXPECT_EQ(values["dcloc_object_store_requests_total answered"], 2.0);
  EXPECT_EQ(values["dcloc_object_store_requests_total repeated"], 1.0);
  EXPECT_EQ(values["dcloc_object_store_bytes_total written"], 3.0);
  EXPECT_EQ(values["dcloc_object_store_bytes_total read"], 3.0);
  EXPECT_EQ(values["dcloc_object_store_away"], 0.0);
  stub_.Stop();
  EXPECT_FALSE(objects_->ReadText("a").ok());
  values = Values();
  EXPECT_EQ(values["dcloc_object_store_requests_total failed"], 1.0);
  EXPECT_EQ(values["dcloc_object_store_away"], 1.0);
}

TEST_F(MapFileMetricsTest, ACachesReadsAreCounted) {
  const std::vector<std::byte> first(60, std::byte{1});
  const std::vector<std::byte> second(60, std::byte{2});
  EXPECT_FALSE(cache_->Read(Sha256Of(first)).ok());
  cache_->Write(Sha256Of(first), first);
  EXPECT_TRUE(cache_->Read(Sha256Of(first)).ok());
  cache_->Write(Sha256Of(second), second);
  cache_->Write(Sha256Of(first), std::vector<std::byte>(101));
  std::map<std::string, double> values = Values();
  EXPECT_EQ(values["dcloc_map_cache_reads_total hit"], 1.0);
  EXPECT_EQ(values["dcloc_map_cache_reads_total miss"], 1.0);
  EXPECT_EQ(values["dcloc_map_cache_evictions_total"], 1.0);
  EXPECT_EQ(values["dcloc_map_cache_failures_total not_stored"], 1.0);
  EXPECT_EQ(values["dcloc_map_cache_failures_total damaged"], 0.0);
  EXPECT_EQ(values["dcloc_map_cache_bytes"], 60.0);
  EXPECT_EQ(values["dcloc_map_cache_max_bytes"], 100.0);
}

TEST_F(MapFileMetricsTest, WhatIsNotThereHasNone) {
  objects_ = nullptr;
  cache_ = nullptr;
  EXPECT_TRUE(Values().empty());
}

}  // namespace
}  // namespace dcloc::server
