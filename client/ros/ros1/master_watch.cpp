#include "client/ros/ros1/master_watch.h"

#include <ros/master.h>
#include <ros/this_node.h>

#include <chrono>
#include <optional>

namespace dcloc::node {
namespace {

constexpr std::chrono::milliseconds kInterval{1000};
constexpr std::chrono::milliseconds kNap{50};  // so that the end does not wait for an interval

/// The process of the master; nothing while there is none.
std::optional<int> MasterProcess() {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue process;
  request[0] = ::ros::this_node::getName();
  if (!::ros::master::execute("getPid", request, response, process, /*wait_for_master=*/false) ||
      process.getType() != XmlRpc::XmlRpcValue::TypeInt) {
    return std::nullopt;
  }
  return static_cast<int>(process);
}

}  // namespace

MasterWatch::MasterWatch() : thread_([this] { Run(); }) {}

MasterWatch::~MasterWatch() {
  ends_ = true;
  thread_.join();
}

void MasterWatch::Run() {
  std::optional<int> known;
  while (!ends_) {
    if (const std::optional<int> process = MasterProcess()) {
      if (known && *process != *known) restarted_ = true;
      known = process;
    }
    for (auto waited = kNap; waited <= kInterval && !ends_; waited += kNap) {
      std::this_thread::sleep_for(kNap);
    }
  }
}

}  // namespace dcloc::node
