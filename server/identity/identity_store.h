#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/sqlite.h"
#include "server/identity/principal.h"
#include "server/maps/catalogue/catalogue.h"

namespace dcloc::server {

/// What proves an identity.
enum class Proof {
  kToken,        ///< a bearer token
  kCertificate,  ///< a client certificate whose common name is the principal's name
};

/// An identity as it is kept; of a token only its hash is.
struct IdentityRecord {
  std::int64_t id = 0;
  Proof proof = Proof::kToken;
  Principal principal;
  SystemTime create_time;
  std::optional<SystemTime> expire_time;  ///< none: never
  std::optional<SystemTime> revoke_time;  ///< none: not revoked
};

/// Where the identities of a store lie.
inline std::filesystem::path IdentityFile(const std::filesystem::path& store) {
  return store / "identities.sqlite";
}

/// The identities, in an SQLite file beside the catalogue. Several processes may have it open: what
/// `dcloc-server token` changes holds for the next call to a running server. Thread-safe; calls
/// take microseconds, as they find what they need by an index.
class IdentityStore {
 public:
  /// Opens or creates it.
  static absl::StatusOr<std::unique_ptr<IdentityStore>> Open(const std::filesystem::path& path);

  /// Adds an identity and gives a token's text, which is shown this once. InvalidArgument names
  /// what of the principal is not well-formed; AlreadyExists: a certificate's name is taken.
  absl::StatusOr<std::string> Create(Proof proof, const Principal& principal,
                                     std::optional<SystemTime> expire_time);

  /// By ascending id.
  absl::StatusOr<std::vector<IdentityRecord>> List();

  /// NotFound: no such id. Revoking twice keeps the first time.
  absl::Status Revoke(std::int64_t id);

  /// Whose token that is. Unauthenticated says what is wrong with it, never the token.
  absl::StatusOr<Principal> FindToken(absl::string_view token);

  /// Whose certificate has this common name. Unauthenticated when there is none.
  absl::StatusOr<Principal> FindCertificate(absl::string_view common_name);

  /// Whether there ever was an identity: revoking the last one opens nothing.
  absl::StatusOr<bool> HasAny();

 private:
  explicit IdentityStore(SqliteDatabase database);
  absl::StatusOr<Principal> Find(const char* sql, absl::string_view key, absl::string_view what);

  std::mutex mutex_;
  SqliteDatabase database_;
  bool has_any_ = false;
};

}  // namespace dcloc::server
