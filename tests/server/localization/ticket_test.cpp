#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"
#include "tests/server/tickets/ticket_fixture.h"

// A session goes on at a server that knows nothing of it but its ticket.
namespace dcloc::server {
namespace {

constexpr int kSent = 120;  // scans that the first server gets

class TicketTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    town_ = new TownDrive(200.0);
    scans_ = town_->Scans();
  }
  static void TearDownTestSuite() {
    delete town_;
    town_ = nullptr;
  }

  TicketTest() : first_(Config(&file_)), second_(Config(&file_)) {
    Fill(first_);
    Fill(second_);
  }

  static ServerConfig Config(const KeyFile* file) {
    ServerConfig config;
    config.worker_count = 1;
    if (file != nullptr) config.ticket_keys = file->path.string();
    return config;
  }

  static void Fill(const TestServer& server) {
    v1::UploadMapResponse response;
    ASSERT_TRUE(UploadMap(*server.maps, HeaderOf(town_->map), town_->map, &response).ok());
  }

  static v1::OpenSession Resumable() {
    v1::OpenSession open = town_->Open();
    open.set_resumable(true);
    return open;
  }

  static v1::SessionOpened Open(TestSession& session, const v1::OpenSession& open) {
    EXPECT_TRUE(session.Open(open));
    const auto opened = session.Read();
    EXPECT_TRUE(opened && opened->has_opened()) << session.Finish().error_message();
    return opened ? opened->opened() : v1::SessionOpened();
  }

  /// What a vehicle has after `kSent` scans at the first server.
  void DriveFirst() {
    TestSession session(*first_.localization);
    opened_ = Open(session, Resumable());
    for (int i = 0; i < kSent; ++i) {
      const auto answer = session.Localize(scans_[static_cast<std::size_t>(i)]);
      ASSERT_TRUE(answer && answer->has_result());
      if (answer->has_ticket()) {
        ticket_ = answer->ticket();
        ++ticket_count_;
      }
      last_ = answer->result();
    }
  }

  /// The `open` of a vehicle whose server is gone.
  v1::OpenSession GoOn() const {
    v1::OpenSession open = Resumable();
    open.set_ticket(ticket_.sealed());
    open.set_answered_sequence_number(kSent - 1);
    open.set_epoch(opened_.epoch());
    *open.mutable_initial_pose() = last_.pose();
    return open;
  }

  /// Opens at the second server, and sees that an ordinary session begins.
  void ExpectRefused(const v1::OpenSession& open, TicketUse use) {
    TestSession session(*second_.localization);
    const v1::SessionOpened opened = Open(session, open);
    EXPECT_EQ(opened.ticket_use(), static_cast<int>(use)) << NameOf(use);
    EXPECT_FALSE(opened.has_last_sequence_number());
    EXPECT_TRUE(session.Localize(scans_[kSent])->has_result());
  }

  static inline TownDrive* town_ = nullptr;
  static inline std::vector<v1::Scan> scans_;

  const KeyFile file_{KeyLine("first", '1')};
  TestServer first_;
  TestServer second_;
  v1::SessionOpened opened_;
  v1::SessionTicket ticket_;
  v1::LocalizationResult last_;
  int ticket_count_ = 0;
};

TEST_F(TicketTest, AnotherServerGoesOnWhereTheVehicleIs) {
  DriveFirst();
  EXPECT_EQ(opened_.epoch(), 1);
  EXPECT_EQ(opened_.ticket_interval_ns(), 1'000'000'000);
  ASSERT_GT(ticket_count_, 3) << "about one a second";
  ASSERT_LT(ticket_count_, 10);
  EXPECT_LE(ticket_.sealed().size(), 1400U);
  EXPECT_LE(ticket_.last_sequence_number(), kSent - 13) << "a second of scans fills a sub-map";

  TestSession session(*second_.localization);
  const v1::SessionOpened opened = Open(session, GoOn());
  EXPECT_EQ(opened.ticket_use(), v1::TICKET_USE_ACCEPTED);
  EXPECT_EQ(opened.last_sequence_number(), ticket_.last_sequence_number());
  EXPECT_GT(opened.epoch(), opened_.epoch());
  EXPECT_NE(opened.session_id(), opened_.session_id());
  for (auto i = static_cast<std::size_t>(ticket_.last_sequence_number()) + 1; i < kSent; ++i) {
    ASSERT_TRUE(session.Send(scans_[i]));
  }
  for (std::size_t i = kSent; i < kSent + 40; ++i) {
    const auto answer = session.Localize(scans_[i]);
    ASSERT_TRUE(answer && answer->has_result());
    EXPECT_EQ(answer->result().sequence_number(), static_cast<int>(i)) << "the first one to come";
    EXPECT_EQ(answer->result().state(), v1::LOCALIZATION_STATE_TRACKING);
    EXPECT_EQ(answer->result().resets().count(), last_.resets().count()) << "no jump";
    const v1::Vector3& p = answer->result().pose().pose().translation_m();
    const Eigen::Vector3d truth = town_->live.scans[i].T_map_vehicle.translation_m;
    EXPECT_LT(std::hypot(p.x() - truth.x(), p.y() - truth.y()), 0.3);
  }
}

// The next server was gone too, before it had made a ticket.
TEST_F(TicketTest, ATicketCanBeUsedTwice) {
  DriveFirst();
  v1::OpenSession open = GoOn();
  std::int64_t epoch = opened_.epoch();
  for (int i = 0; i < 3; ++i) {
    open.set_epoch(epoch);
    TestSession session(*second_.localization);
    const v1::SessionOpened opened = Open(session, open);
    EXPECT_EQ(opened.ticket_use(), v1::TICKET_USE_ACCEPTED);
    EXPECT_GT(opened.epoch(), epoch);
    epoch = opened.epoch();
  }
}

TEST_F(TicketTest, ThoseThatCannotBeUsedAreToldAndAnOrdinarySessionBegins) {
  DriveFirst();
  v1::OpenSession open = GoOn();
  open.set_ticket("no ticket");
  ExpectRefused(open, TicketUse::kMalformed);
  open.set_ticket(ticket_.sealed().substr(0, 100));
  ExpectRefused(open, TicketUse::kForged);
  std::string altered = ticket_.sealed();
  altered.back() = static_cast<char>(altered.back() + 1);
  open.set_ticket(altered);
  ExpectRefused(open, TicketUse::kForged);
  open = GoOn();
  open.set_vehicle_id("car-2");
  ExpectRefused(open, TicketUse::kForeign);
  open = GoOn();
  open.set_epoch(opened_.epoch() + 17);
  ExpectRefused(open, TicketUse::kStale);
}

TEST_F(TicketTest, AServerWithoutTheKeyOrAnyKeySaysSo) {
  DriveFirst();
  const KeyFile other(KeyLine("other", '2'));
  for (const KeyFile* file : {&other, static_cast<const KeyFile*>(nullptr)}) {
    const TestServer server(Config(file));
    Fill(server);
    TestSession session(*server.localization);
    const v1::SessionOpened opened = Open(session, GoOn());
    EXPECT_EQ(opened.ticket_use(),
              file == nullptr ? v1::TICKET_USE_NOT_OFFERED : v1::TICKET_USE_UNKNOWN_KEY);
    EXPECT_EQ(opened.ticket_interval_ns() > 0, file != nullptr);
    EXPECT_GT(opened.epoch(), opened_.epoch()) << "it rises all the same";
  }
}

TEST_F(TicketTest, AVersionWithOtherBytesIsAnotherMap) {
  DriveFirst();
  const TestServer server(Config(&file_));
  const std::vector<std::byte> bytes = town_->Map("elsewhere");
  v1::UploadMapResponse response;
  ASSERT_TRUE(UploadMap(*server.maps, HeaderOf(bytes), bytes, &response).ok());
  TestSession session(*server.localization);
  EXPECT_EQ(Open(session, GoOn()).ticket_use(), v1::TICKET_USE_OTHER_MAP_VERSION);
}

TEST_F(TicketTest, AResumeTokenComesFirstAndTheTicketWhereItIsNotKnown) {
  TestSession driving(*first_.localization);
  opened_ = Open(driving, Resumable());
  for (int i = 0; i < kSent; ++i) {
    const auto answer = driving.Localize(scans_[static_cast<std::size_t>(i)]);
    ASSERT_TRUE(answer);
    if (answer->has_ticket()) ticket_ = answer->ticket();
    last_ = answer->result();
  }
  v1::OpenSession open = GoOn();
  open.set_resume_token(opened_.resume_token());
  TestSession there(*first_.localization);
  const v1::SessionOpened resumed = Open(there, open);
  EXPECT_TRUE(resumed.resumed());
  EXPECT_EQ(resumed.epoch(), opened_.epoch());
  EXPECT_EQ(resumed.ticket_use(), v1::TICKET_USE_UNSPECIFIED);

  TestSession elsewhere(*second_.localization);
  const v1::SessionOpened gone_on = Open(elsewhere, open);
  EXPECT_FALSE(gone_on.resumed());
  EXPECT_EQ(gone_on.ticket_use(), v1::TICKET_USE_ACCEPTED);

  // The first server's session is stale now, and its token alone does not bring it back.
  v1::OpenSession back;
  back.set_vehicle_id(open.vehicle_id());
  back.set_resume_token(opened_.resume_token());
  back.set_epoch(gone_on.epoch());
  TestSession stale(*first_.localization);
  ASSERT_TRUE(stale.Open(back));
  EXPECT_EQ(stale.Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(TicketTest, WithoutAResumableSessionThereAreNone) {
  TestSession session(*first_.localization);
  EXPECT_EQ(Open(session, town_->Open()).ticket_interval_ns(), 0);
  for (std::size_t i = 0; i < 60; ++i) EXPECT_FALSE(session.Localize(scans_[i])->has_ticket());
}

// Its answer was never given, although those of higher numbers were.
TEST_F(TicketTest, AScanThatWasLateIsAnsweredAfterTheCatchingUp) {
  DriveFirst();
  TestSession session(*second_.localization);
  const v1::SessionOpened opened = Open(session, GoOn());
  constexpr int kLate = kSent - 4;
  for (auto i = opened.last_sequence_number() + 1; i < kSent; ++i) {
    if (i == kLate) continue;
    ASSERT_TRUE(session.Send(scans_[static_cast<std::size_t>(i)]));
  }
  for (const std::int64_t number : {std::int64_t{kLate}, opened.last_sequence_number() - 1}) {
    const auto answer = session.Localize(scans_[static_cast<std::size_t>(number)]);
    ASSERT_TRUE(answer && answer->has_rejected());
    EXPECT_EQ(answer->rejected().sequence_number(), number);
    EXPECT_EQ(answer->rejected().code(), grpc::StatusCode::OUT_OF_RANGE);
  }
  EXPECT_TRUE(session.Localize(scans_[kSent])->has_result());
}

TEST_F(TicketTest, CanBeMovedBeforeItsFirstScan) {
  DriveFirst();
  TestSession session(*second_.localization);
  ASSERT_EQ(Open(session, GoOn()).ticket_use(), v1::TICKET_USE_ACCEPTED);
  const std::vector<std::byte> bytes = town_->Map("the next drive");
  v1::UploadMapHeader header = HeaderOf(bytes);
  header.set_activate(false);
  v1::UploadMapResponse uploaded;
  ASSERT_TRUE(UploadMap(*second_.maps, header, bytes, &uploaded).ok());
  Call call;
  v1::ActivateMapVersionRequest activate;
  activate.set_map_name("town");
  activate.set_version(2);
  activate.set_move_sessions(true);
  v1::ActivateMapVersionResponse moved;
  ASSERT_TRUE(second_.maps->ActivateMapVersion(&call, activate, &moved).ok());
  EXPECT_EQ(moved.moved_session_count(), 1);

  for (std::size_t i = kSent; i < kSent + 20; ++i) {
    const auto answer = session.Localize(scans_[i]);
    ASSERT_TRUE(answer && answer->has_result());
    EXPECT_EQ(answer->result().map_version(), 2);
    const v1::Vector3& p = answer->result().pose().pose().translation_m();
    const Eigen::Vector3d truth = town_->live.scans[i].T_map_vehicle.translation_m;
    EXPECT_LT(std::hypot(p.x() - truth.x(), p.y() - truth.y()), 0.5);
  }
}

TEST_F(TicketTest, TheHighestEpochCanBeSentBack) {
  v1::OpenSession open = Resumable();
  open.set_epoch(std::int64_t{1} << 53);
  for (int i = 0; i < 2; ++i) {
    TestSession session(*first_.localization);
    open.set_epoch(Open(session, open).epoch());
    EXPECT_EQ(open.epoch(), std::int64_t{1} << 53);
  }
}

TEST_F(TicketTest, ANumberThatIsNoneIsRejectedAlthoughTheSessionCatchesUp) {
  DriveFirst();
  TestSession session(*second_.localization);
  Open(session, GoOn());
  v1::Scan scan = scans_[kSent];
  scan.set_sequence_number(-1);
  EXPECT_TRUE(session.Localize(scan)->has_rejected());
}

}  // namespace
}  // namespace dcloc::server
