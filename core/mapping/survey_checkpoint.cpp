#include "core/mapping/survey_checkpoint.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#include "core/map/data_loss.h"
#include "core/map/map_file.h"

namespace dcloc {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");

constexpr std::array<char, 8> kMagic = {'D', 'C', 'L', 'O', 'C', 'S', 'V', 'Y'};
/// Rises when the layout or the stages of a survey change.
constexpr std::uint32_t kVersion = 1;

class Writer {
 public:
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void Put(Number value) {
    const auto raw = std::bit_cast<std::array<std::byte, sizeof(Number)>>(value);
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
  }
  void Put(const Eigen::Vector2d& v) { Put(v.x()), Put(v.y()); }
  void Put(const Pose2& T) { Put(T.translation_m), Put(T.yaw_rad); }
  void Put(const SurveyEdge& edge) {
    Put(std::uint64_t{edge.from}), Put(std::uint64_t{edge.to});
    Put(edge.T_from_to.pose);
    for (const double value : edge.T_from_to.covariance.reshaped()) Put(value);
    Put(std::uint8_t{edge.is_certain});
  }
  void Put(const NodeFix& fix) {
    Put(std::uint64_t{fix.node});
    Put(fix.p_node), Put(fix.p_map), Put(fix.sigma_m);
  }
  void Put(const std::string& text) {
    Put(std::uint64_t{text.size()});
    for (const char c : text) Put(c);
  }
  template <typename T>
  void Put(const std::vector<T>& values) {
    Put(std::uint64_t{values.size()});
    for (const T& value : values) Put(value);
  }

  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

// Once something is missing, all else is, too.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void Get(Number& value) {
    if (bytes_.size() < sizeof(Number)) return Fail();
    std::memcpy(&value, bytes_.data(), sizeof(Number));
    bytes_ = bytes_.subspan(sizeof(Number));
  }
  void Get(Eigen::Vector2d& v) { Get(v.x()), Get(v.y()); }
  void Get(Pose2& T) { Get(T.translation_m), Get(T.yaw_rad); }
  void Get(SurveyEdge& edge) {
    GetIndex(edge.from), GetIndex(edge.to);
    Get(edge.T_from_to.pose);
    for (double& value : edge.T_from_to.covariance.reshaped()) Get(value);
    std::uint8_t is_certain = 0;
    Get(is_certain);
    edge.is_certain = is_certain != 0;
  }
  void Get(NodeFix& fix) {
    GetIndex(fix.node);
    Get(fix.p_node), Get(fix.p_map), Get(fix.sigma_m);
  }
  void Get(std::string& text) {
    text.resize(GetCount());
    for (char& c : text) Get(c);
  }
  template <typename T>
  void Get(std::vector<T>& values) {
    values.resize(GetCount());
    for (T& value : values) Get(value);
  }

  bool is_whole() const { return is_good_ && bytes_.empty(); }

 private:
  void GetIndex(std::size_t& index) {
    std::uint64_t value = 0;
    Get(value);
    index = value;
  }
  // Each thing that is counted has a byte at least.
  std::size_t GetCount() {
    std::uint64_t count = 0;
    Get(count);
    if (count <= bytes_.size()) return count;
    Fail();
    return 0;
  }
  void Fail() {
    is_good_ = false;
    bytes_ = {};
  }

  std::span<const std::byte> bytes_;
  bool is_good_ = true;
};

/// Of a checkpoint that is written or read, the content in its order.
template <typename Checkpoint, typename Visit>
void ForEachPart(Checkpoint& checkpoint, const Visit& visit) {
  visit(checkpoint.finished_stage_count);
  visit(checkpoint.T_map_nodes);
  visit(checkpoint.T_start_nodes);
  visit(checkpoint.neighbours);
  visit(checkpoint.loops);
  visit(checkpoint.refused_loops);
  visit(checkpoint.fixes);
  visit(checkpoint.unconfirmed_count);
  visit(checkpoint.accepted_fix_count);
  visit(checkpoint.findings);
}

bool RefersToNodes(const SurveyCheckpoint& checkpoint, std::size_t node_count) {
  const auto joins_nodes = [&](const std::vector<SurveyEdge>& edges) {
    return std::ranges::all_of(edges, [&](const SurveyEdge& edge) {
      return edge.from < node_count && edge.to < node_count;
    });
  };
  return joins_nodes(checkpoint.neighbours) && joins_nodes(checkpoint.loops) &&
         joins_nodes(checkpoint.refused_loops) &&
         std::ranges::all_of(checkpoint.fixes,
                             [&](const NodeFix& fix) { return fix.node < node_count; });
}

}  // namespace

std::uint32_t InputOf(std::span<const DriveTrack* const> tracks, std::span<const NodeFix> fixes) {
  Writer writer;
  for (const DriveTrack* const track : tracks) {
    writer.Put(track->name);
    writer.Put(std::uint64_t{track->scans.size()});
    for (const SurveyNode& node : track->nodes) {
      writer.Put(std::int64_t{node.stamp.time_since_epoch().count()});
      writer.Put(node.T_odometry_node);
      writer.Put(std::uint64_t{node.landmarks.size()});
      writer.Put(node.centre_m);
    }
  }
  for (const NodeFix& fix : fixes) writer.Put(fix);
  return Crc32(writer.bytes());
}

std::vector<std::byte> ToBytes(const SurveyCheckpoint& checkpoint, std::uint32_t input) {
  Writer writer;
  for (const char c : kMagic) writer.Put(c);
  writer.Put(kVersion);
  writer.Put(input);
  ForEachPart(checkpoint, [&](const auto& part) { writer.Put(part); });
  writer.Put(Crc32(writer.bytes()));
  return writer.bytes();
}

absl::StatusOr<SurveyCheckpoint> CheckpointFromBytes(std::span<const std::byte> bytes,
                                                     std::uint32_t input, std::size_t node_count,
                                                     std::size_t drive_count) {
  if (bytes.size() < kMagic.size() ||
      std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    return DataLoss("no checkpoint of a survey: the magic bytes differ");
  }
  std::uint32_t crc32 = 0;
  if (bytes.size() < kMagic.size() + sizeof(crc32)) return DataLoss("the checkpoint is cut short");
  const std::span<const std::byte> checked = bytes.first(bytes.size() - sizeof(crc32));
  std::memcpy(&crc32, checked.data() + checked.size(), sizeof(crc32));
  if (crc32 != Crc32(checked)) {
    return DataLoss("checkpoint: checksum is %08x; its bytes give %08x", crc32, Crc32(checked));
  }
  Reader reader(checked.subspan(kMagic.size()));
  std::uint32_t version = 0;
  std::uint32_t its_input = 0;
  reader.Get(version);
  reader.Get(its_input);
  if (version != kVersion || its_input != input) {
    return absl::FailedPreconditionError(
        "the checkpoint is of other drives or fixes, or of another version of this program; "
        "without the file the survey begins anew");
  }
  SurveyCheckpoint checkpoint;
  ForEachPart(checkpoint, [&](auto& part) { reader.Get(part); });
  if (!reader.is_whole() || checkpoint.T_map_nodes.size() != node_count ||
      checkpoint.T_start_nodes.size() != node_count ||
      (!checkpoint.findings.empty() && checkpoint.findings.size() != drive_count) ||
      !RefersToNodes(checkpoint, node_count)) {
    return DataLoss("checkpoint: its content is not that of %d nodes", node_count);
  }
  return checkpoint;
}

}  // namespace dcloc
