#include "server/tickets/ticket_cipher.h"

#include <openssl/evp.h>
#include <openssl/rand.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>

namespace dcloc::server {
namespace {

struct FreeContext {
  void operator()(EVP_CIPHER_CTX* context) const { EVP_CIPHER_CTX_free(context); }
};
using Context = std::unique_ptr<EVP_CIPHER_CTX, FreeContext>;

const unsigned char* BytesOf(absl::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}
unsigned char* BytesOf(std::string& text) { return reinterpret_cast<unsigned char*>(text.data()); }

absl::string_view TextOf(const unsigned char* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

int SizeOf(absl::string_view text) { return static_cast<int>(text.size()); }

}  // namespace

absl::StatusOr<std::shared_ptr<const TicketCipher>> TicketCipher::Create(
    std::vector<TicketKey> keys) {
  Salt salt;
  if (RAND_bytes(salt.data(), static_cast<int>(salt.size())) != 1) {
    return absl::InternalError("no random bytes for tickets");
  }
  return std::shared_ptr<const TicketCipher>(new TicketCipher(std::move(keys), salt));
}

TicketCipher::TicketCipher(std::vector<TicketKey> keys, const Salt& salt)
    : keys_(std::move(keys)),
      salt_(salt),
      sealing_key_(Derive(keys_.front(), TextOf(salt_.data(), salt_.size()))) {}

const TicketKey* TicketCipher::Find(absl::string_view id) const {
  const auto found = std::ranges::find(keys_, id, &TicketKey::id);
  return found == keys_.end() ? nullptr : &*found;
}

TicketCipher::Secret TicketCipher::Derive(const TicketKey& key, absl::string_view salt) {
  const std::string label = "dcloc ticket 1" + std::string(salt);
  Secret secret{};
  std::size_t size = 0;
  const bool done =
      EVP_Q_mac(nullptr, "HMAC", nullptr, "SHA256", nullptr, key.secret.data(), key.secret.size(),
                BytesOf(label), label.size(), secret.data(), secret.size(), &size) != nullptr;
  // Only where memory or OpenSSL itself is gone. A key of zeros would be everybody's.
  if (!done || size != secret.size()) std::abort();
  return secret;
}

absl::StatusOr<std::string> TicketCipher::Seal(absl::string_view content,
                                               absl::string_view associated) const {
  const std::uint64_t count = sealed_count_.fetch_add(1);
  std::array<unsigned char, kNonceSize> nonce{};
  for (std::size_t i = 0; i < sizeof(count); ++i) {
    nonce[i] = static_cast<unsigned char>(count >> (8 * i));
  }
  std::string sealed(TextOf(salt_.data(), salt_.size()));
  sealed.append(nonce.begin(), nonce.end());
  const std::size_t begin = sealed.size();
  sealed.resize(begin + content.size() + kTagSize);
  unsigned char* const out = BytesOf(sealed) + begin;
  const Context context(EVP_CIPHER_CTX_new());
  int size = 0;
  const bool done =
      context != nullptr &&
      EVP_EncryptInit_ex(context.get(), EVP_aes_256_gcm(), nullptr, sealing_key_.data(),
                         nonce.data()) == 1 &&
      EVP_EncryptUpdate(context.get(), nullptr, &size, BytesOf(associated), SizeOf(associated)) ==
          1 &&
      EVP_EncryptUpdate(context.get(), out, &size, BytesOf(content), SizeOf(content)) == 1 &&
      EVP_EncryptFinal_ex(context.get(), out + size, &size) == 1 &&
      EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_GCM_GET_TAG, static_cast<int>(kTagSize),
                          out + content.size()) == 1;
  if (!done) return absl::InternalError("OpenSSL cannot seal a ticket");
  return sealed;
}

std::optional<std::string> TicketCipher::Open(absl::string_view key_id, absl::string_view sealed,
                                              absl::string_view associated) const {
  const TicketKey* const key = Find(key_id);
  if (key == nullptr || sealed.size() < kOverhead) return std::nullopt;
  const Secret secret = Derive(*key, sealed.substr(0, kSaltSize));
  const absl::string_view nonce = sealed.substr(kSaltSize, kNonceSize);
  const absl::string_view body = sealed.substr(kSaltSize + kNonceSize, sealed.size() - kOverhead);
  std::string tag(sealed.substr(sealed.size() - kTagSize));
  std::string content(body.size(), '\0');
  const Context context(EVP_CIPHER_CTX_new());
  int size = 0;
  const bool is_authentic =
      context != nullptr &&
      EVP_DecryptInit_ex(context.get(), EVP_aes_256_gcm(), nullptr, secret.data(),
                         BytesOf(nonce)) == 1 &&
      EVP_DecryptUpdate(context.get(), nullptr, &size, BytesOf(associated), SizeOf(associated)) ==
          1 &&
      EVP_DecryptUpdate(context.get(), BytesOf(content), &size, BytesOf(body), SizeOf(body)) == 1 &&
      EVP_CIPHER_CTX_ctrl(context.get(), EVP_CTRL_GCM_SET_TAG, static_cast<int>(kTagSize),
                          tag.data()) == 1 &&
      EVP_DecryptFinal_ex(context.get(), BytesOf(content) + size, &size) == 1;
  if (!is_authentic) return std::nullopt;
  return content;
}

}  // namespace dcloc::server
