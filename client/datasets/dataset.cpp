#include "client/datasets/dataset.h"

#include "client/datasets/nuscenes.h"
#include "client/datasets/radarscenes.h"

namespace dcloc {

absl::StatusOr<Drive> ReadDrive(const Dataset& dataset, const DriveRequest& request) {
  if (dataset.format == DatasetFormat::kRadarScenes) {
    return ReadRadarScenesDrive(dataset.root, request);
  }
  NuScenesOptions options;
  options.version = dataset.version;
  return ReadNuScenesDrive(dataset.root, request, options);
}

}  // namespace dcloc
