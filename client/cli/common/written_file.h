#pragma once

#include <cstddef>
#include <string>

namespace dcloc::cli {

/// Says on stdout that `file` was written, with so many of `what` ("pose"): for people, or for
/// scripts as {"file": ..., "pose_count": ...}.
void PrintWritten(const std::string& file, const std::string& what, std::size_t count,
                  bool as_json);

}  // namespace dcloc::cli
