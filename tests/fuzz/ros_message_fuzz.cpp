#include <array>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/rosbag/message_reader.h"
#include "client/rosbag/message_types.h"
#include "client/rosbag/message_writer.h"
#include "tests/fuzz/fuzz_target.h"

namespace dcloc {
namespace {

constexpr std::array kMotions = {&rosbag::kOdometry, &rosbag::kTwistStamped,
                                 &rosbag::kTwistWithCovarianceStamped, &rosbag::kPoseStamped,
                                 &rosbag::kPoseWithCovarianceStamped};

void TakeCloud(absl::string_view bytes) {
  const auto cloud = rosbag::ParsePointCloud(bytes);
  if (!cloud.ok() || cloud->point_count == 0) return;
  for (const rosbag::PointField& field : cloud->fields) {
    static_cast<void>(cloud->Value(field, 0));
    static_cast<void>(cloud->Value(field, cloud->point_count - 1));
  }
}

}  // namespace

// The first byte says what the others are.
std::vector<FuzzInput> FuzzSeeds() {
  const rosbag::Header header{Stamp(std::chrono::seconds(1'700'000'000)), "front"};
  rosbag::PointCloud cloud{.header = header};
  cloud.fields = {{"range", 0, 7, 1}, {"count", 4, 4, 1}, {"snr", 8, 8, 1}};
  cloud.point_count = 2;
  cloud.point_bytes = 16;
  cloud.data.assign(32, '\1');
  const std::string velocity = rosbag::FormatVelocity(header, EgoVelocity());
  // Long enough for each type; its text lengths and numbers are zero.
  const std::string zeros(800, '\0');
  std::vector<FuzzInput> seeds;
  const auto add = [&](std::size_t kind, absl::string_view bytes) {
    seeds.push_back(InputOf(absl::StrCat(kind, bytes)));
  };
  add(0, rosbag::FormatPointCloud(cloud));
  add(1, rosbag::FormatTransforms({{header.stamp, "map", "base_link", Pose3()}}));
  add(2, velocity);
  add(3, absl::StrCat(velocity.substr(0, 20), zeros));
  for (std::size_t i = 0; i < kMotions.size(); ++i) add(4 + i, absl::StrCat(velocity, zeros));
  return seeds;
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dcloc;  // NOLINT(google-build-using-namespace)
  if (size == 0) return 0;
  const absl::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t kind = (data[0] + 2U) % 10U;  // '0' is 0
  if (kind == 0) {
    TakeCloud(bytes);
  } else if (kind == 1) {
    static_cast<void>(rosbag::ParseTransforms(bytes));
  } else if (kind == 2) {
    static_cast<void>(rosbag::ParseImu(bytes));
  } else if (kind == 3) {
    static_cast<void>(rosbag::ParseSatelliteFix(bytes));
  } else if (kind - 4 < kMotions.size()) {
    static_cast<void>(rosbag::ParseMotion(kMotions[kind - 4]->name, bytes));
  } else {
    static_cast<void>(rosbag::ParseMessageHeader(bytes));
  }
  return 0;
}
