#pragma once

#include <filesystem>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dcloc {

/// A picture as gnuplot commands that draw it, for any terminal.
struct Picture {
  std::string commands;
  int width_px = 1200;
  int height_px = 900;
};

/// Draws with the gnuplot program. Errors: NotFound without that program, Internal with its error
/// message.
absl::StatusOr<std::string> RenderSvg(const Picture& picture);
absl::Status RenderPng(const Picture& picture, const std::filesystem::path& png);

}  // namespace dcloc
