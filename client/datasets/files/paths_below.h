#pragma once

#include <filesystem>
#include <functional>
#include <vector>

namespace dcloc {

/// The files and folders below `root`, at most four levels down, for which `is_wanted` holds:
/// relative to `root`, sorted. What lies in a wanted folder, or in one that may not be read, is
/// passed over.
std::vector<std::filesystem::path> PathsBelow(
    const std::filesystem::path& root,
    const std::function<bool(const std::filesystem::path&)>& is_wanted);

}  // namespace dcloc
