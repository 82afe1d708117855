#include "server/sessions/recording_subscriber.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

class SilentSubscriber final : public RecordingSubscriber {
 public:
  void OnOpened(const RecordingStart& /*start*/) override {}
  void OnScan(const v1::Scan& /*scan*/, const ScanAnswer& /*answer*/) override {}
  bool TakesFixes() const override { return true; }
  void OnFix(const v1::PositionFix& /*fix*/, const FixAnswer& /*answer*/) override {}
  void OnEnd(const absl::Status& /*status*/) override {}
};

TEST(RecordingRequestsTest, WhoAskedFirstIsServedFirstAndOnce) {
  RecordingRequests requests;
  const auto first = std::make_shared<SilentSubscriber>();
  const auto second = std::make_shared<SilentSubscriber>();
  requests.Add("", "car", first);
  requests.Add("", "car", second);
  EXPECT_EQ(requests.Take("", "car"), first);
  EXPECT_EQ(requests.Take("", "car"), second);
  EXPECT_EQ(requests.Take("", "car"), nullptr);
}

TEST(RecordingRequestsTest, AreOfATenantsVehicle) {
  RecordingRequests requests;
  const auto subscriber = std::make_shared<SilentSubscriber>();
  requests.Add("acme", "car", subscriber);
  EXPECT_EQ(requests.Take("", "car"), nullptr);
  EXPECT_EQ(requests.Take("acme", "van"), nullptr);
  EXPECT_EQ(requests.Take("acme", "car"), subscriber);
}

TEST(RecordingRequestsTest, WhoGaveUpIsPassedOver) {
  RecordingRequests requests;
  auto gone = std::make_shared<SilentSubscriber>();
  const auto waiting = std::make_shared<SilentSubscriber>();
  requests.Add("", "car", gone);
  requests.Add("", "car", waiting);
  gone.reset();
  EXPECT_EQ(requests.Take("", "car"), waiting);
}

}  // namespace
}  // namespace dcloc::server
