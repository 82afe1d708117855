#pragma once

#include <initializer_list>
#include <string>

#include "absl/strings/string_view.h"

namespace dcloc::server {

/// A name for what `parts` name: the first 128 bits of their HMAC-SHA256 under `key`, in
/// hexadecimal. The same parts have the same pseudonym. Without the key nobody can find the parts,
/// not even by trying all that there may be. `key` has 32 bytes at least.
std::string Pseudonym(absl::string_view key, std::initializer_list<absl::string_view> parts);

}  // namespace dcloc::server
