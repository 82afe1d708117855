#include "client/datasets/files/paths_below.h"

#include <algorithm>
#include <system_error>

namespace dcloc {
namespace fs = std::filesystem;

std::vector<fs::path> PathsBelow(const fs::path& root,
                                 const std::function<bool(const fs::path&)>& is_wanted) {
  constexpr int kMaxDepth = 3;
  std::vector<fs::path> paths;
  std::error_code error;
  auto entry =
      fs::recursive_directory_iterator(root, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (entry.depth() >= kMaxDepth) entry.disable_recursion_pending();
    if (!is_wanted(entry->path())) continue;
    paths.push_back(entry->path().lexically_relative(root));
    entry.disable_recursion_pending();
  }
  std::ranges::sort(paths);
  return paths;
}

}  // namespace dcloc
