#include "client/cli/common/written_file.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"

namespace dcloc::cli {

void PrintWritten(const std::string& file, const std::string& what, std::size_t count,
                  bool as_json) {
  using nlohmann::ordered_json;
  if (as_json) {
    const ordered_json json = {{"file", file}, {what + "_count", count}};
    absl::PrintF("%s\n", json.dump(2, ' ', false, ordered_json::error_handler_t::replace));
  } else {
    absl::PrintF("%s: %d %s%s\n", Visible(file), count, what, count == 1 ? "" : "s");
  }
}

}  // namespace dcloc::cli
