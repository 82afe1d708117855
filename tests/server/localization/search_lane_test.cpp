#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"

namespace dcloc::server {
namespace {

/// Processor time so far of this process's threads that come after the others for the system.
double BackgroundCpu_ms() {
  const int own_nice = getpriority(PRIO_PROCESS, 0);
  std::int64_t sum_ns = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (getpriority(PRIO_PROCESS, static_cast<id_t>(std::stoul(task.path().filename()))) <=
        own_nice) {
      continue;
    }
    std::int64_t run_ns = 0;
    std::ifstream(task.path() / "schedstat") >> run_ns;
    sum_ns += run_ns;
  }
  return 1e-6 * static_cast<double>(sum_ns);
}

struct Searched {
  double until_tracking_ms = 0.0;
  double tracking_ms = 0.0;
};

/// Its targets, each as often as it takes for 5,000.
v1::Scan Enlarged(v1::Scan scan) {
  const auto enlarge = [](auto& column) {
    for (int i = 0; column.size() < 5'000; ++i) {
      const auto value = column[i];
      column.Add(value);
    }
  };
  enlarge(*scan.mutable_range_m());
  enlarge(*scan.mutable_range_rate_mps());
  enlarge(*scan.mutable_azimuth_rad());
  if (scan.rcs_dbsm_size() > 0) enlarge(*scan.mutable_rcs_dbsm());
  return scan;
}

class SearchLaneTest : public ::testing::Test {
 protected:
  SearchLaneTest() {
    v1::UploadMapResponse response;
    const grpc::Status status =
        UploadMap(*server_.maps, HeaderOf(drive_.map), drive_.map, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }

  void SetUp() override {
    if (getpriority(PRIO_PROCESS, 0) == 19) GTEST_SKIP() << "the process is the last already";
  }

  /// What a whole drive takes of those threads.
  void DriveThrough(const v1::OpenSession& open, const std::vector<v1::Scan>& scans,
                    Searched& searched) const {
    const double begin_ms = BackgroundCpu_ms();
    double found_ms = 0.0;
    TestSession session(*server_.localization);
    ASSERT_TRUE(session.Open(open));
    ASSERT_TRUE(session.Read().has_value());
    std::optional<v1::LocalizeResponse> answer;
    for (const v1::Scan& scan : scans) {
      answer = session.Localize(scan);
      ASSERT_TRUE(answer && answer->has_result());
      const bool is_found = answer->result().state() == v1::LOCALIZATION_STATE_TRACKING;
      if (is_found && found_ms == 0.0) found_ms = BackgroundCpu_ms();
    }
    searched = {found_ms - begin_ms, BackgroundCpu_ms() - found_ms};
    EXPECT_EQ(answer->result().state(), v1::LOCALIZATION_STATE_TRACKING);
    session.CloseSending();
    EXPECT_TRUE(session.Finish().ok());
  }

  const TownDrive drive_;
  const TestServer server_{[] {
    ServerConfig config;
    config.worker_count = 1;
    return config;
  }()};
};

TEST_F(SearchLaneTest, WhoSearchesForItsPlaceIsOnItAndWhoTracksIsNot) {
  for (const bool with_prior : {true, false}) {
    v1::OpenSession open = drive_.Open();
    if (!with_prior) open.clear_initial_pose();
    Searched searched;
    DriveThrough(open, drive_.Scans(), searched);
    EXPECT_GT(searched.until_tracking_ms, 4.0) << with_prior;
    // To wake idle threads takes a while on a busy machine, and with sanitizers.
    EXPECT_LT(searched.tracking_ms, 0.5 * searched.until_tracking_ms) << with_prior;
    RecordProperty(with_prior ? "with_prior_ms" : "without_ms",
                   std::to_string(searched.until_tracking_ms));
  }
}

TEST_F(SearchLaneTest, WhoSendsLargeScansIsOnIt) {
  std::vector<v1::Scan> scans = drive_.Scans();
  std::ranges::transform(scans, scans.begin(), Enlarged);
  Searched searched;
  DriveThrough(drive_.Open(), scans, searched);
  EXPECT_GT(searched.tracking_ms, 0.5 * static_cast<double>(scans.size()));
}

}  // namespace
}  // namespace dcloc::server
