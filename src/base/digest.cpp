// SPDX-License-Identifier: Apache-2.0
#include "base/digest.hpp"

#include <openssl/evp.h>

#include <stdexcept>
#include <vector>

namespace scanmill {

struct Sha256::Impl {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  Impl() {
    if (context == nullptr || EVP_DigestInit_ex(context, EVP_sha256(), nullptr) != 1)
      throw std::runtime_error("SHA-256 is not available from the system's libcrypto");
  }
  ~Impl() { EVP_MD_CTX_free(context); }
};

Sha256::Sha256() : impl_(new Impl) {}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::add(std::span<const char> bytes) { EVP_DigestUpdate(impl_->context, bytes.data(), bytes.size()); }

std::string Sha256::hex() {
  unsigned char raw[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  EVP_DigestFinal_ex(impl_->context, raw, &size);
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kDigits[raw[i] >> 4];
    text += kDigits[raw[i] & 15];
  }
  return text;
}

std::string sha256_hex(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hash.hex();
}

Result<std::string> sha256_of(const ByteSource& source) {
  Sha256 hash;
  std::vector<char> buffer(1 << 20);
  for (std::uint64_t offset = 0; offset < source.size();) {
    TRY_ASSIGN(const std::size_t got, source.read_at(offset, buffer));
    if (got == 0) return fail(Code::IoFailed, "the file became shorter while it was read", source.name());
    hash.add(std::span<const char>(buffer.data(), got));
    offset += got;
  }
  return hash.hex();
}

}  // namespace scanmill
