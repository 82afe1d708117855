#include <chrono>
#include <fstream>
#include <iterator>

#include "client/datasets/bag_contents.h"
#include "client/datasets/bag_overview.h"
#include "client/rosbag/bag_writer.h"
#include "client/rosbag/message_types.h"
#include "client/rosbag/message_writer.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"

namespace dcloc {
namespace {

constexpr std::uint8_t kFloat32 = 7;  // of sensor_msgs/PointField

rosbag::PointCloud Cloud(Stamp stamp) {
  rosbag::PointCloud cloud{.header = {stamp, "front"}};
  for (const char* name : {"range", "azimuth", "range_rate", "rcs"}) {
    const auto offset = static_cast<std::uint32_t>(cloud.fields.size() * sizeof(float));
    cloud.fields.push_back({name, offset, kFloat32, 1});
  }
  cloud.point_count = 3;
  cloud.point_bytes = cloud.fields.size() * sizeof(float);
  for (std::size_t i = 0; i < cloud.point_count * cloud.fields.size(); ++i) {
    const float value = 0.25F * static_cast<float>(i + 1);
    cloud.data.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  return cloud;
}

/// A radar, its mount, the vehicle's velocity and its pose.
FuzzInput Bag(rosbag::Compression compression, int scan_count) {
  const MemoryFile file;
  auto bag = rosbag::BagWriter::Create(file.path(), compression);
  Require(bag.ok(), "a bag begins");
  absl::Status status;
  Stamp stamp(std::chrono::seconds(1'700'000'000));
  status.Update(bag->Add("/tf_static", rosbag::kTf2, stamp,
                         rosbag::FormatTransforms({{stamp, "base_link", "front", Pose3()}})));
  for (int i = 0; i < scan_count; ++i, stamp += std::chrono::milliseconds(77)) {
    status.Update(bag->Add("/tf", rosbag::kTf2, stamp,
                           rosbag::FormatTransforms({{stamp, "map", "base_link", Pose3()}})));
    status.Update(bag->Add("/velocity", rosbag::kTwistWithCovarianceStamped, stamp,
                           rosbag::FormatVelocity({stamp, "base_link"}, EgoVelocity())));
    status.Update(bag->Add("/radar/front", rosbag::kPointCloud2, stamp,
                           rosbag::FormatPointCloud(Cloud(stamp))));
  }
  Require(status.ok() && bag->Close().ok(), "a bag ends");
  std::ifstream in(file.path(), std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void TakeContents(const std::filesystem::path& path, const BagMapping& mapping) {
  const auto contents = ReadBagContents(path, mapping);
  if (!contents.ok()) return;
  for (const Scan& scan : contents->scans) {
    Require(scan.azimuth_rad.size() == scan.size() && scan.range_rate_mps.size() == scan.size(),
            "a target has all of its columns");
    static_cast<void>(contents->transforms.Static("base_link", "front"));
    static_cast<void>(contents->transforms.At("map", "base_link", scan.stamp));
  }
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  return {Bag(rosbag::Compression::kNone, 3), Bag(rosbag::Compression::kNone, 0),
          Bag(rosbag::Compression::kLz4, 2), Bag(rosbag::Compression::kBz2, 2)};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dcloc;  // NOLINT(google-build-using-namespace)
  MemoryFile file;
  const std::filesystem::path& path = file.Write(data, size);
  const auto overview = ReadBagOverview(path);
  if (!overview.ok()) return 0;
  const BagMapping mapping = ProposeMapping(*overview);
  if (!mapping.radars.empty()) {
    Require(Validate(mapping).ok(), "what is proposed can be taken");
    TakeContents(path, mapping);
  }
  return 0;
}
