#include "server/app/server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>

#include "core/registration/gicp.h"
#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"

namespace dcloc::server {
namespace {

// Somebody else's registration: it counts, and leaves nothing in the workspace.
class CountingMethod final : public RegistrationMethod<2> {
 public:
  Registration<2> Register(const RegistrationInput<2>& input,
                           RegistrationWorkspace<2>& /*workspace*/) const override {
    ++call_count;
    GicpOptions options;
    options.initial_blur_m = input.guess_sigma_m;
    return RegisterGicp<2>(input.points, input.map, input.T_local_vehicle_guess, options);
  }

  mutable std::atomic<int> call_count = 0;
};

v1::LocalizationResult LastResult(TestServer& server, const TownDrive& drive) {
  v1::UploadMapResponse response;
  EXPECT_TRUE(UploadMap(*server.maps, HeaderOf(drive.map), drive.map, &response).ok());
  TestSession session(*server.localization);
  EXPECT_TRUE(session.Open(drive.Open()) && session.Read().has_value());
  v1::LocalizationResult last;
  for (const v1::Scan& scan : drive.Scans()) {
    const auto answer = session.Localize(scan);
    EXPECT_TRUE(answer && answer->has_result());
    if (answer) last = answer->result();
  }
  session.CloseSending();
  EXPECT_TRUE(session.Finish().ok());
  return last;
}

TEST(ServerTest, LocalizesByTheRegistrationThatTheProgramChose) {
  const TownDrive drive(120.0);
  const auto method = std::make_shared<CountingMethod>();
  TestServer server(ServerConfig(), {.planar = method, .spatial = nullptr});
  EXPECT_EQ(LastResult(server, drive).state(), v1::LOCALIZATION_STATE_TRACKING);
  EXPECT_GT(method->call_count, 20);
}

TEST(ServerTest, TheStubRegistersNothing) {
  const TownDrive drive(60.0);
  const auto method = std::make_shared<CountingMethod>();
  TestServer server(TestServer::StubConfig(), {.planar = method, .spatial = nullptr});
  EXPECT_NE(LastResult(server, drive).state(), v1::LOCALIZATION_STATE_TRACKING);
  EXPECT_EQ(method->call_count, 0);
}

}  // namespace
}  // namespace dcloc::server
