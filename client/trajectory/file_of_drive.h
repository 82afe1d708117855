#pragma once

#include <filesystem>
#include <string>

namespace dcloc {

/// The file of one of several drives, beside `file`: "way.tum" and drive "a" give "way-a.tum". What
/// a name of a file may not hold is written as in a URL, "a/b" as "a%2Fb", so that two drives never
/// have one file.
std::filesystem::path FileOfDrive(const std::filesystem::path& file, const std::string& drive);

}  // namespace dcloc
