// dcloc_node: a vehicle's session with a dcloc server, as a node of ROS 1.
#include <ros/console.h>
#include <ros/ros.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/ros/localizer_node.h"
#include "client/ros/ros1/master_watch.h"
#include "client/ros/ros1/raw_message.h"
#include "client/ros/ros1/ros_parameters.h"
#include "client/ros/ros1/ros_sink.h"

namespace dcloc::node {
namespace {

constexpr std::uint32_t kIncomingCount = 500;
constexpr double kAdvanceInterval_s = 0.01;
constexpr double kDiagnosticsInterval_s = 1.0;
constexpr double kMasterInterval_s = 0.5;

using Event = ::ros::MessageEvent<const RawMessage>;

Stamp ToStamp(const ::ros::Time& time) {
  return Stamp(std::chrono::nanoseconds(static_cast<std::int64_t>(time.toNSec())));
}

void Take(LocalizerNode& node, const std::string& topic, const Event& event) {
  const ::ros::M_string& header = event.getConnectionHeader();
  const rosbag::Connection connection{topic, header.at("type"), header.at("md5sum")};
  node.Take({connection, ToStamp(event.getReceiptTime()), event.getConstMessage()->data},
            std::chrono::steady_clock::now());
}

std::vector<::ros::Subscriber> Subscribe(::ros::NodeHandle& handle, LocalizerNode& node) {
  std::vector<::ros::Subscriber> subscribers;
  for (const std::string& topic : node.topics()) {
    ::ros::SubscribeOptions options;
    options.initByFullCallbackType<const Event&>(
        topic, kIncomingCount, [&node, topic](const Event& event) { Take(node, topic, event); });
    options.transport_hints = ::ros::TransportHints().tcpNoDelay();
    subscribers.push_back(handle.subscribe(options));
  }
  return subscribers;
}

int Run() {
  ::ros::NodeHandle handle;
  ::ros::NodeHandle own("~");
  RosSink sink(handle, own);
  const auto parameters = ReadParameters(own);
  const auto options =
      parameters.ok() ? OptionsOf(*parameters) : absl::StatusOr<NodeOptions>(parameters.status());
  auto node = options.ok() ? LocalizerNode::Create(*options, sink)
                           : absl::StatusOr<std::unique_ptr<LocalizerNode>>(options.status());
  if (!node.ok()) {
    ROS_FATAL_STREAM(node.status().message());
    return 1;
  }
  std::vector<::ros::Subscriber> subscribers = Subscribe(handle, **node);
  using Wall = ::ros::WallTimerEvent;
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const ::ros::WallTimer advance =
      handle.createWallTimer(::ros::WallDuration(kAdvanceInterval_s),
                             [&](const Wall& /*event*/) { (*node)->Advance(now()); });
  const ::ros::WallTimer diagnose =
      handle.createWallTimer(::ros::WallDuration(kDiagnosticsInterval_s),
                             [&](const Wall& /*event*/) { (*node)->Diagnose(now()); });
  MasterWatch master;
  const ::ros::WallTimer register_anew =
      handle.createWallTimer(::ros::WallDuration(kMasterInterval_s), [&](const Wall& /*event*/) {
        if (!master.TakeRestart()) return;
        sink.Warn("the ROS master was started anew; its topics are told to it again");
        subscribers.clear();  // or roscpp takes them for known
        subscribers = Subscribe(handle, **node);
        sink.AdvertiseAnew();
      });
  ::ros::WallTimer tell;
  if (options->odometry_rate_hz > 0.0) {
    tell = handle.createWallTimer(
        ::ros::WallDuration(1.0 / options->odometry_rate_hz),
        [&](const Wall& /*event*/) { (*node)->TellPose(ToStamp(::ros::Time::now())); });
  }
  ::ros::spin();
  return 0;
}

}  // namespace
}  // namespace dcloc::node

int main(int argc, char** argv) {
  ros::init(argc, argv, "dcloc");
  return dcloc::node::Run();
}
