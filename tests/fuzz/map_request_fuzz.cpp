#include "server/convert/map.h"

#include <google/protobuf/stubs/logging.h>

#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/convert/page.h"
#include "server/maps/jobs/map_build.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc {
namespace {

template <typename Message>
std::optional<Message> Parsed(const FuzzInput& bytes) {
  Message message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return std::nullopt;
  return message;
}

void TakeTile(const v1::ReadMapTileRequest& message) {
  const auto query = server::convert::FromProto(message);
  if (!query.ok()) return;
  const server::Rectangle& bounds = query->bounds_m;
  Require(bounds.max_x - bounds.min_x <= 5000.0 && bounds.max_y - bounds.min_y <= 5000.0,
          "a tile that was taken is not too large");
}

void TakeBuild(const v1::MapBuildHeader& message) {
  const auto build = server::FromProto(message);
  Require(!build.ok() || Validate(build->rig).ok(), "a rig that was taken is valid");
}

}  // namespace

// The first byte says what the others are.
std::vector<FuzzInput> FuzzSeeds() {
  google::protobuf::SetLogHandler(nullptr);  // it prints a line for each text that is no UTF-8
  v1::FindCoverageRequest near;
  near.mutable_position()->set_latitude_deg(52.0);
  near.set_radius_m(100.0);
  v1::ReadMapTileRequest tile;
  tile.set_map_name("town");
  tile.set_max_x_m(100.0);
  tile.set_max_y_m(50.0);
  v1::SetMapCanaryRequest canary;
  canary.set_map_name("town");
  canary.set_version(2);
  v1::MapBuildHeader build;
  build.set_map_name("town");
  *build.mutable_rig()->add_radars() = server::RadarMessage("front");
  std::vector<FuzzInput> seeds;
  const auto add = [&](char kind, const std::string& bytes) {
    seeds.push_back(InputOf(absl::StrCat(std::string(1, kind), bytes)));
  };
  add('0', near.SerializeAsString());
  add('1', tile.SerializeAsString());
  add('2', canary.SerializeAsString());
  add('3', build.SerializeAsString());
  add('4', "17");
  add('4', "town-a");
  add('5', std::string(64, 'a'));
  return seeds;
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dcloc;  // NOLINT(google-build-using-namespace)
  if (size == 0) return 0;
  const FuzzInput bytes(data + 1, data + size);
  const std::string text(bytes.begin(), bytes.end());
  switch (data[0] % 6) {
    case 0:
      if (auto m = Parsed<v1::FindCoverageRequest>(bytes)) {
        static_cast<void>(server::convert::FromProto(*m));
      }
      break;
    case 1:
      if (auto m = Parsed<v1::ReadMapTileRequest>(bytes)) TakeTile(*m);
      break;
    case 2:
      if (auto m = Parsed<v1::SetMapCanaryRequest>(bytes)) {
        static_cast<void>(server::convert::Check(*m));
      }
      break;
    case 3:
      if (auto m = Parsed<v1::MapBuildHeader>(bytes)) TakeBuild(*m);
      break;
    case 4: {
      const auto number = server::convert::NumberFromPageToken(text, 1);
      Require(!number.ok() || *number >= 1, "a page begins at 1");
      static_cast<void>(server::convert::CheckPageToken(text));
      break;
    }
    default:
      Require(server::convert::CheckSha256("sha256", text).ok() <= (text.size() == 64),
              "a hash has 64 digits");
      break;
  }
  return 0;
}
