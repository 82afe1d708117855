#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/tickets/ticket_keys.h"

namespace dcloc::server {

/// Seals and opens bytes under the fleet's keys by AES-256-GCM.
///
/// Random nonces under one key would repeat after some 2^32 tickets of a fleet. So each process
/// seals under a key of its own, HMAC-SHA256 of the fleet's key over a random salt, and counts its
/// nonces. Salt and nonce stand in the sealed bytes, and any server of the fleet derives the key
/// again. Thread-safe; waits for nothing.
class TicketCipher {
 public:
  /// `keys` is not empty. Internal where OpenSSL has no random bytes.
  static absl::StatusOr<std::shared_ptr<const TicketCipher>> Create(std::vector<TicketKey> keys);

  /// What is in front of the sealed content.
  static constexpr std::size_t kSaltSize = 16;
  static constexpr std::size_t kNonceSize = 12;
  static constexpr std::size_t kTagSize = 16;
  /// By which the sealed bytes are longer than the content.
  static constexpr std::size_t kOverhead = kSaltSize + kNonceSize + kTagSize;

  /// The key that seals.
  const std::string& key_id() const { return keys_.front().id; }
  bool has_key(absl::string_view id) const { return Find(id) != nullptr; }
  const std::vector<TicketKey>& keys() const { return keys_; }

  /// `content` sealed, with `associated` data that `Open` must be given too.
  absl::StatusOr<std::string> Seal(absl::string_view content, absl::string_view associated) const;

  /// Nothing where the bytes were altered, or sealed under another key or with other data.
  std::optional<std::string> Open(absl::string_view key_id, absl::string_view sealed,
                                  absl::string_view associated) const;

 private:
  using Secret = std::array<unsigned char, 32>;
  using Salt = std::array<unsigned char, kSaltSize>;

  explicit TicketCipher(std::vector<TicketKey> keys, const Salt& salt);

  const TicketKey* Find(absl::string_view id) const;
  static Secret Derive(const TicketKey& key, absl::string_view salt);

  const std::vector<TicketKey> keys_;
  const Salt salt_;
  const Secret sealing_key_;
  mutable std::atomic<std::uint64_t> sealed_count_ = 0;
};

}  // namespace dcloc::server
