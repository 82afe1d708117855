#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/versions/update_builder.h"

namespace dcloc::cli {

/// An update with all that is told of it.
struct UpdateReport {
  std::string base;
  JudgedUpdate judged;
  std::string out;  ///< the file that was written; empty where none was
};

/// What came, what went, where and since when; how the passes fared; how each street was judged and
/// when it was last driven.
nlohmann::ordered_json UpdateJson(const UpdateReport& report);
std::string UpdateText(const UpdateReport& report);

/// The same as a page with a drawing.
std::string UpdateHtml(const UpdateReport& report);

}  // namespace dcloc::cli
