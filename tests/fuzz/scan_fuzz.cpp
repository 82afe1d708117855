#include "server/convert/scan.h"

#include "core/geometry/geodetic_anchor.h"
#include "server/convert/position_fix.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc {
namespace {

const Rig& TheRig() {
  static const Rig rig = [] {
    v1::Rig message;
    *message.add_radars() = server::RadarMessage("front");
    return *server::convert::FromProto(message, "rig");
  }();
  return rig;
}

void TakeScan(const v1::Scan& message) {
  Scan scan;
  if (!server::convert::FromProto(message, TheRig(), &scan).ok()) return;
  Require(Validate(scan, TheRig()).ok(), "a scan that was taken is valid");
}

void TakeFix(const v1::PositionFix& message) {
  const GeodeticAnchor anchor{.origin = {.latitude_deg = 52.0, .longitude_deg = 8.0}};
  const auto fix = server::convert::FromProto(message, anchor);
  Require(!fix.ok() || Validate(*fix).ok(), "a fix that was taken is valid");
  static_cast<void>(server::convert::FromProto(message, std::nullopt));
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  v1::Scan full = server::ScanMessage(7, 6);
  for (int i = 0; i < 6; ++i) full.add_elevation_rad(0.01F);
  for (int i = 0; i < 3; ++i) {
    full.mutable_motion()->add_stamp_offset_ns(-20'000'000 * (3 - i));
    full.mutable_motion()->add_speed_mps(5.0F);
    full.mutable_motion()->add_yaw_rate_radps(0.1F);
  }
  v1::PositionFix gnss = server::FixMessage(1);
  *gnss.mutable_gnss_fix() = server::GnssFixMessage();
  std::vector<FuzzInput> seeds;
  for (const v1::Scan& scan : {server::ScanMessage(0, 4), full, server::ScanMessage(1, 0)}) {
    v1::LocalizeRequest request;
    *request.mutable_scan() = scan;
    seeds.push_back(InputOf(request.SerializeAsString()));
  }
  for (const v1::PositionFix& fix : {server::FixMessage(0), gnss}) {
    v1::LocalizeRequest request;
    *request.mutable_position_fix() = fix;
    seeds.push_back(InputOf(request.SerializeAsString()));
  }
  return seeds;
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::v1::LocalizeRequest request;
  if (!request.ParseFromArray(data, static_cast<int>(size))) return 0;
  dcloc::TakeScan(request.scan());
  dcloc::TakeFix(request.position_fix());
  return 0;
}
