#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// A key of the fleet, which all of its servers have.
struct TicketKey {
  std::string id;  ///< 1 to 16 of A-Z, a-z, 0-9, ".", "_" and "-"
  std::array<unsigned char, 32> secret{};

  friend bool operator==(const TicketKey&, const TicketKey&) = default;
};

inline constexpr std::size_t kMaxTicketKeys = 16;

/// Keys, one a line: "ID SECRET", the secret as 64 hexadecimal digits. Empty lines and those that
/// begin with "#" are skipped. The first key seals, all open. InvalidArgument names the line and
/// what is wrong there, but no secret.
absl::StatusOr<std::vector<TicketKey>> ParseTicketKeys(absl::string_view text);

/// Those of a file that nobody but its owner and group may use. InvalidArgument names the file.
absl::StatusOr<std::vector<TicketKey>> ReadTicketKeys(const std::filesystem::path& file);

}  // namespace dcloc::server
