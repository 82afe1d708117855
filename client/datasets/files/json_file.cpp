#include "client/datasets/files/json_file.h"

#include <fstream>

#include "absl/strings/str_cat.h"
#include "client/datasets/files/file_error.h"

namespace dcloc {

absl::StatusOr<nlohmann::json> ReadJson(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return CannotOpen(path);
  try {
    return nlohmann::json::parse(file);
  } catch (const nlohmann::json::exception& error) {  // the library says where only by throwing
    return FileError(path, absl::StrCat("is not valid JSON: ", error.what()));
  }
}

}  // namespace dcloc
