#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include "absl/strings/string_view.h"

struct evp_md_ctx_st;

namespace dcloc::server {

/// SHA-256 of bytes that come in parts.
class Sha256 {
 public:
  Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  ~Sha256();

  void Update(std::span<const std::byte> bytes);

  /// The hash as 64 lower-case hexadecimal digits; to be called last.
  std::string Finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// Whether `text` is 64 lower-case hexadecimal digits.
bool IsSha256(absl::string_view text);

}  // namespace dcloc::server
