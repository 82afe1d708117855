#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/base/clock.h"
#include "server/identity/principal.h"

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

/// The identities. Several processes may use one store: a change by one is seen by the others
/// within a second. Thread-safe; calls may block on storage. Errors beyond those named are the
/// storage's own: Internal, ResourceExhausted, Unavailable, and DataLoss for an identity that
/// cannot be read, such as one with an unknown role.
class IdentityStore {
 public:
  virtual ~IdentityStore() = default;

  /// Adds an identity and returns a token's text, which cannot be read again. InvalidArgument names
  /// what of the principal is not well-formed; AlreadyExists: a certificate's name is taken.
  virtual absl::StatusOr<std::string> Create(Proof proof, const Principal& principal,
                                             std::optional<SystemTime> expire_time) = 0;

  /// Those with an id above `after`, by ascending id, at most `limit`. An identity that cannot be
  /// read is an error of its page alone.
  virtual absl::StatusOr<std::vector<IdentityRecord>> List(std::int64_t after, int limit) = 0;

  /// NotFound: no such id. Revoking twice keeps the first time.
  virtual absl::Status Revoke(std::int64_t id) = 0;

  /// The principal that a token belongs to. Unauthenticated says what is wrong with the token, but
  /// does not contain it.
  virtual absl::StatusOr<Principal> FindToken(absl::string_view token) = 0;

  /// The principal of a certificate with this common name. Unauthenticated if there is none.
  virtual absl::StatusOr<Principal> FindCertificate(absl::string_view common_name) = 0;

  /// Whether any identity was ever created. Revoking the last one does not make everyone an admin
  /// again.
  virtual absl::StatusOr<bool> HasAny() = 0;
};

}  // namespace dcloc::server
