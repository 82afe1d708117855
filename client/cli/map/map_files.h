#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/map/editable_map.h"

namespace dcloc::cli {

/// OK where each of `files` may be put, as far as folders tell: NotFound names one whose folder is
/// not there, InvalidArgument one that is a folder. Empty names are none. Before a command works.
absl::Status CheckFolders(const std::vector<std::string>& files);

/// A map file, verified whole. Errors name the file.
absl::StatusOr<EditableMap> ReadMapParts(const std::string& file);

/// Writes the map whole and gives what it is. Errors name the file.
absl::StatusOr<MapInfo> WriteMapParts(const EditableMap& map, const std::string& file);

/// A file that is made and not written yet.
struct MadeFile {
  std::string file;
  std::vector<std::byte> bytes;
};

/// The map's file, and what it is. Errors name the file.
absl::StatusOr<MapInfo> MakeMapFile(const EditableMap& map, MadeFile& made);

/// Writes all files, or none where one of them cannot be: AlreadyExists for one that is there
/// without `force`, NotFound for one whose folder is not, InvalidArgument for a folder.
absl::Status WriteMadeFiles(const std::vector<MadeFile>& files, bool force);

}  // namespace dcloc::cli
