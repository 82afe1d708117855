#include "server/tickets/session_tickets.h"

#include <gtest/gtest.h>

#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "tests/server/tickets/ticket_fixture.h"

namespace dcloc::server {
namespace {

class SessionTicketsTest : public ::testing::Test {
 protected:
  std::string Sealed() const { return *tickets_->Seal(SomeContent(), SomeBinding(), kTicketNow); }
  TicketUse Use(const std::string& ticket) const {
    return tickets_->Open(ticket, SomeBinding(), kTicketNow).use;
  }

  KeyFile file_{KeyLine("first", '1')};
  std::unique_ptr<SessionTickets> tickets_ = file_.Tickets();
};

TEST_F(SessionTicketsTest, AnotherServerOfTheFleetReadsAllOfIt) {
  const OpenedTicket opened = file_.Tickets()->Open(Sealed(), SomeBinding(), kTicketNow);
  ASSERT_EQ(opened.use, TicketUse::kAccepted);
  EXPECT_EQ(opened.key_id, "first");
  const TicketContent& content = opened.content;
  const TicketContent expected = SomeContent();
  EXPECT_EQ(content.map_version, expected.map_version);
  EXPECT_EQ(content.map_sha256, expected.map_sha256);
  EXPECT_EQ(content.epoch, expected.epoch);
  EXPECT_EQ(content.last_sequence_number, expected.last_sequence_number);
  EXPECT_EQ(content.session_id, expected.session_id);
  // Each number to the bit: written again it gives the same bytes.
  EXPECT_EQ(*WriteTicketContent(content, kMaxTicketSize),
            *WriteTicketContent(expected, kMaxTicketSize));
  EXPECT_EQ(content.snapshot.pose.covariance, expected.snapshot.pose.covariance);
  EXPECT_EQ(content.snapshot.contradiction_m, expected.snapshot.contradiction_m);
  EXPECT_EQ(content.snapshot.tracking.last_lost_to_outliers,
            expected.snapshot.tracking.last_lost_to_outliers);
}

TEST_F(SessionTicketsTest, IsSmall) {
  EXPECT_LT(Sealed().size(), 1400U);
  RecordProperty("bytes", static_cast<int>(Sealed().size()));
}

// One is made for a dozen scans, and 20 us of each are allowed for it.
TEST_F(SessionTicketsTest, CostsLittle) {
  constexpr int kCount = 1000;
  const std::clock_t begin = std::clock();
  for (int i = 0; i < kCount; ++i) EXPECT_FALSE(Sealed().empty());
  const double seal_us = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / kCount;
  EXPECT_LT(seal_us, 240.0);
  RecordProperty("seal_us", std::to_string(seal_us));
}

TEST_F(SessionTicketsTest, NoTwoAreSealedAlike) { EXPECT_NE(Sealed(), Sealed()); }

TEST_F(SessionTicketsTest, TooManyLearnedRadarsAreLeftOut) {
  TicketContent content = SomeContent();
  for (int i = 0; i < 64; ++i) {
    const std::string id = absl::StrCat("a-radar-with-quite-a-long-name-", i);
    content.snapshot.known.Of(id) = {.radar_id = id,
                                     .mount_yaw_error = {{0.01, 1e-6}},
                                     .clock_ahead = {{1.0, 1e-6}},
                                     .stamp_delay = {{0.1, 1e-6}},
                                     .range_bias_error = {{0.4, 1e-3}},
                                     .beta_error = {{0.01, 1e-6}}};
  }
  const auto sealed = tickets_->Seal(content, SomeBinding(), kTicketNow);
  ASSERT_TRUE(sealed.ok()) << sealed.status();
  EXPECT_LE(sealed->size(), kMaxTicketSize);
  const OpenedTicket opened = tickets_->Open(*sealed, SomeBinding(), kTicketNow);
  EXPECT_TRUE(opened.content.snapshot.known.radars.empty());
  EXPECT_TRUE(opened.content.snapshot.known.wheel_scale.has_value());
}

TEST_F(SessionTicketsTest, NoByteCanBeAltered) {
  const std::string ticket = Sealed();
  for (std::size_t i = 0; i < ticket.size(); ++i) {
    std::string altered = ticket;
    altered[i] = static_cast<char>(altered[i] ^ 0x10);
    EXPECT_NE(Use(altered), TicketUse::kAccepted) << "byte " << i;
  }
  std::string altered = ticket;
  altered.back() = static_cast<char>(altered.back() ^ 1);
  EXPECT_EQ(Use(altered), TicketUse::kForged);
}

// The time of expiry stands in clear, but it is sealed too.
TEST_F(SessionTicketsTest, ItsLifeCannotBeProlonged) {
  std::string ticket = Sealed();
  constexpr std::size_t kExpiry = 4 + 1 + 5 + 8;
  ticket[kExpiry + 4] = static_cast<char>(ticket[kExpiry + 4] + 1);
  EXPECT_EQ(Use(ticket), TicketUse::kForged);
}

TEST_F(SessionTicketsTest, CutShortItIsNoTicket) {
  const std::string ticket = Sealed();
  for (std::size_t size = 0; size < ticket.size(); ++size) {
    const TicketUse use = Use(ticket.substr(0, size));
    EXPECT_TRUE(use == TicketUse::kMalformed || use == TicketUse::kForged) << size << " bytes";
  }
  EXPECT_EQ(Use(ticket.substr(0, 40)), TicketUse::kMalformed);
}

TEST_F(SessionTicketsTest, NoiseIsNoTicket) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string noise(random() % 5000, '\0');
    for (char& byte : noise) byte = static_cast<char>(random());
    if (i % 2 == 0) noise = absl::StrCat("dct1", noise);
    EXPECT_NE(Use(noise), TicketUse::kAccepted);
  }
}

TEST_F(SessionTicketsTest, ItIsOfOneVehicleOfOnePrincipalInOneMapWithOneRig) {
  const std::string ticket = Sealed();
  const Principal principal{.name = "fleet-a", .tenant = "north"};
  v1::OpenSession vehicle = SomeOpen();
  vehicle.set_vehicle_id("car-2");
  v1::OpenSession map = SomeOpen();
  map.set_map_name("country");
  v1::OpenSession rig = SomeOpen();
  rig.mutable_rig()->mutable_radars(0)->set_beta_s(0.04);
  v1::OpenSession options = SomeOpen();
  options.mutable_options()->set_scans_per_submap(3);
  const std::vector<TicketBinding> others = {
      BindingOf({.name = "fleet-b", .tenant = "north"}, SomeOpen()),
      BindingOf({.name = "fleet-a", .tenant = "south"}, SomeOpen()),
      BindingOf({.name = "fleet-an", .tenant = "orth"}, SomeOpen()),
      BindingOf(principal, vehicle),
      BindingOf(principal, map),
      BindingOf(principal, rig),
      BindingOf(principal, options)};
  for (const TicketBinding& other : others) {
    EXPECT_EQ(tickets_->Open(ticket, other, kTicketNow).use, TicketUse::kForeign);
  }
  // What is known of the pose may change from one opening to the next.
  v1::OpenSession prior = SomeOpen();
  prior.mutable_initial_pose();
  EXPECT_EQ(tickets_->Open(ticket, BindingOf(principal, prior), kTicketNow).use,
            TicketUse::kAccepted);
}

TEST_F(SessionTicketsTest, ItExpires) {
  const std::string ticket = Sealed();
  const auto use_after = [&](std::chrono::seconds age) {
    return tickets_->Open(ticket, SomeBinding(), kTicketNow + age).use;
  };
  EXPECT_EQ(use_after(std::chrono::seconds(59)), TicketUse::kAccepted);
  EXPECT_EQ(use_after(std::chrono::seconds(60)), TicketUse::kExpired);
  EXPECT_EQ(use_after(-std::chrono::seconds(30)), TicketUse::kAccepted) << "clocks differ";
  EXPECT_EQ(use_after(-std::chrono::seconds(31)), TicketUse::kExpired) << "from the future";
}

TEST_F(SessionTicketsTest, KeysAreRotatedWithAnOverlap) {
  const std::string old_ticket = Sealed();
  const KeyFile both(absl::StrCat(KeyLine("second", '2'), KeyLine("first", '1')));
  EXPECT_EQ(both.Tickets()->Open(old_ticket, SomeBinding(), kTicketNow).use, TicketUse::kAccepted);
  const std::string new_ticket = *both.Tickets()->Seal(SomeContent(), SomeBinding(), kTicketNow);
  EXPECT_EQ(Use(new_ticket), TicketUse::kUnknownKey);
  KeyFile second(KeyLine("second", '2'));
  EXPECT_EQ(second.Tickets()->Open(new_ticket, SomeBinding(), kTicketNow).use,
            TicketUse::kAccepted);
  EXPECT_EQ(second.Tickets()->Open(old_ticket, SomeBinding(), kTicketNow).use,
            TicketUse::kUnknownKey);
  // The same name for another secret.
  KeyFile impostor(KeyLine("first", '9'));
  EXPECT_EQ(impostor.Tickets()->Open(old_ticket, SomeBinding(), kTicketNow).use,
            TicketUse::kForged);
}

TEST_F(SessionTicketsTest, WhatIsSealedIsCheckedAsWhatAnybodySends) {
  TicketContent content = SomeContent();
  content.snapshot.pose.covariance(0, 0) = -1.0;
  EXPECT_EQ(Use(*tickets_->Seal(content, SomeBinding(), kTicketNow)), TicketUse::kUnusable);
  content = SomeContent();
  content.epoch = 0;
  EXPECT_EQ(Use(*tickets_->Seal(content, SomeBinding(), kTicketNow)), TicketUse::kUnusable);
}

}  // namespace
}  // namespace dcloc::server
