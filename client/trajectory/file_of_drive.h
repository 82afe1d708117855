#pragma once

#include <filesystem>
#include <string>

namespace dcloc {

/// The file of one of several drives, beside `file`: "way.tum" and drive "a/b" give "way-a_b.tum".
std::filesystem::path FileOfDrive(const std::filesystem::path& file, const std::string& drive);

}  // namespace dcloc
