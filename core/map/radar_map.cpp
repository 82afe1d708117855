#include "core/map/radar_map.h"

#include <cassert>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "core/map/keyframe_index.h"
#include "core/map/map_content.h"
#include "core/map/map_file.h"
#include "core/map/mapped_file.h"

namespace dcloc {

// Owns the bytes. Moving it does not move them, so views into them stay valid.
class RadarMap::Storage {
 public:
  explicit Storage(MappedFile file) : owner_(std::move(file)) {}
  explicit Storage(std::vector<std::byte> bytes) : owner_(std::move(bytes)) {}

  std::span<const std::byte> bytes() const {
    if (const auto* file = std::get_if<MappedFile>(&owner_)) return file->bytes();
    return std::get<std::vector<std::byte>>(owner_);
  }

  void ExpectRandomReadsFrom(const void* address) const {
    const auto* file = std::get_if<MappedFile>(&owner_);
    if (file == nullptr) return;
    const auto offset = static_cast<const std::byte*>(address) - file->bytes().data();
    file->ExpectRandomReadsFrom(static_cast<std::size_t>(offset));
  }

 private:
  std::variant<MappedFile, std::vector<std::byte>> owner_;
};

struct RadarMap::Layout {
  MapFileView view;
  KeyframeIndex index;
  MapInfo info;
};

namespace {

Eigen::Vector3d OriginOf(const MapFileView& view) {
  return Eigen::Vector3d::Map(view.info.local_origin_m.data());
}

MapInfo InfoOf(const MapFileView& view, std::size_t size_bytes) {
  MapInfo info{.name = std::string(view.name),
               .description = std::string(view.description),
               .keyframe_count = view.keyframes.size(),
               .point_count = view.points.size(),
               .size_bytes = size_bytes,
               .length_m = view.info.length_m,
               .has_elevation = (view.info.flags & kHasElevationFlag) != 0,
               .has_heights = (view.info.flags & kHasHeightsFlag) != 0,
               .stamp_delay_s = StampDelayOf(view.info),
               .anchor = AnchorOf(view.info)};
  for (std::size_t i = 0; i < view.keyframes.size(); ++i) {
    const Eigen::Vector3d p_map =
        OriginOf(view) + Eigen::Vector3d::Map(view.keyframes[i].translation_local_m.data());
    info.min_map_m = i == 0 ? p_map : info.min_map_m.cwiseMin(p_map);
    info.max_map_m = i == 0 ? p_map : info.max_map_m.cwiseMax(p_map);
  }
  return info;
}

}  // namespace

RadarMap::RadarMap(std::unique_ptr<Storage> storage, std::unique_ptr<Layout> layout)
    : storage_(std::move(storage)), layout_(std::move(layout)) {}

RadarMap::~RadarMap() = default;

absl::StatusOr<std::shared_ptr<const RadarMap>> RadarMap::Load(std::unique_ptr<Storage> storage) {
  const std::span<const std::byte> bytes = storage->bytes();
  const absl::StatusOr<MapFileView> view = ParseMapFile(bytes);
  if (!view.ok()) return view.status();
  storage->ExpectRandomReadsFrom(view->points.data());
  auto layout = std::make_unique<Layout>(
      Layout{*view, KeyframeIndex(view->index, view->keyframes, view->info.index_cell_m),
             InfoOf(*view, bytes.size())});
  return std::shared_ptr<const RadarMap>(new RadarMap(std::move(storage), std::move(layout)));
}

absl::StatusOr<std::shared_ptr<const RadarMap>> RadarMap::Open(const std::filesystem::path& path) {
  absl::StatusOr<MappedFile> file = MappedFile::Open(path);
  if (!file.ok()) return file.status();
  auto map = Load(std::make_unique<Storage>(*std::move(file)));
  if (map.ok()) return map;
  return absl::Status(map.status().code(),
                      absl::StrCat(path.string(), ": ", map.status().message()));
}

absl::StatusOr<std::shared_ptr<const RadarMap>> RadarMap::FromBytes(std::vector<std::byte> bytes) {
  return Load(std::make_unique<Storage>(std::move(bytes)));
}

const MapInfo& RadarMap::info() const { return layout_->info; }

std::span<const std::byte> RadarMap::bytes() const { return storage_->bytes(); }

absl::Status RadarMap::Verify() const { return VerifyMapFile(storage_->bytes(), layout_->view); }

Keyframe RadarMap::keyframe(std::size_t index) const {
  const MapFileView& view = layout_->view;
  assert(index < view.keyframes.size());
  const KeyframeRecord& record = view.keyframes[index];
  const auto& q = record.rotation_wxyz;
  return {
      .T_map_keyframe = {.translation_m = OriginOf(view) +
                                          Eigen::Vector3d::Map(record.translation_local_m.data()),
                         .rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3])},
      .points = view.points.subspan(record.first_point, record.point_count)};
}

std::optional<KeyframeAccuracy> RadarMap::accuracy(std::size_t index) const {
  assert(index < layout_->view.keyframes.size());
  return UnpackAccuracy(layout_->view.keyframes[index].accuracy);
}

std::vector<std::size_t> RadarMap::KeyframesWithin(const Eigen::Vector3d& p_map,
                                                   double radius_m) const {
  return layout_->index.Within((p_map - OriginOf(layout_->view)).head<2>(), radius_m);
}

void RadarMap::KeyframesWithin(const Eigen::Vector3d& p_map, double radius_m,
                               std::vector<std::size_t>& indices) const {
  layout_->index.Within((p_map - OriginOf(layout_->view)).head<2>(), radius_m, indices);
}

std::optional<std::size_t> RadarMap::NearestKeyframe(const Eigen::Vector3d& p_map,
                                                     double max_distance_m) const {
  return layout_->index.Nearest((p_map - OriginOf(layout_->view)).head<2>(), max_distance_m);
}

}  // namespace dcloc
