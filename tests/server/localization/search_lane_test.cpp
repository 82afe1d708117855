#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

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

/// What a whole drive takes of those threads.
void DriveThrough(const TestServer& server, const TownDrive& drive, bool with_prior,
                  Searched& searched) {
  const double begin_ms = BackgroundCpu_ms();
  double found_ms = 0.0;
  TestSession session(*server.localization);
  v1::OpenSession open = drive.Open();
  if (!with_prior) open.clear_initial_pose();
  ASSERT_TRUE(session.Open(open));
  ASSERT_TRUE(session.Read().has_value());
  std::optional<v1::LocalizeResponse> answer;
  for (const v1::Scan& scan : drive.Scans()) {
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

TEST(SearchLaneTest, WhoSearchesForItsPlaceIsOnItAndWhoTracksIsNot) {
  if (getpriority(PRIO_PROCESS, 0) == 19) GTEST_SKIP() << "the process is the last already";
  const TownDrive drive;
  ServerConfig config;
  config.worker_count = 1;
  const TestServer server(config);
  v1::UploadMapResponse response;
  const grpc::Status status = UploadMap(*server.maps, HeaderOf(drive.map), drive.map, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  for (const bool with_prior : {true, false}) {
    Searched searched;
    DriveThrough(server, drive, with_prior, searched);
    // To wake idle threads takes up to a millisecond or so on a busy machine.
    EXPECT_GT(searched.until_tracking_ms, 4.0) << with_prior;
    EXPECT_LT(searched.tracking_ms, 3.0) << with_prior;
    RecordProperty(with_prior ? "with_prior_ms" : "without_ms",
                   std::to_string(searched.until_tracking_ms));
  }
}

}  // namespace
}  // namespace dcloc::server
