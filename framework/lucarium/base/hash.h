// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lucarium {

/// 128-bit content hash (XXH3), used for cache keys and scene identity; not cryptographic.
struct Hash128 {
  uint64_t low = 0;
  uint64_t high = 0;
  bool operator==(const Hash128&) const = default;
  std::string hex() const;  ///< 32 lower-case digits, high part first
};

Hash128 hash_bytes(const void* data, size_t bytes);

/// Streaming form. Strings and vectors are prefixed by their length, so that {"ab","c"} and {"a","bc"} differ.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;

  Hasher& add_bytes(const void* data, size_t bytes);
  Hasher& add(std::string_view text);
  template <class T>
  requires std::is_trivially_copyable_v<T> &&(!std::is_convertible_v<T, std::string_view>)Hasher& add(const T& value) {
    return add_bytes(&value, sizeof value);
  }
  template <class T>
  requires std::is_trivially_copyable_v<T> Hasher& add(const std::vector<T>& values) {
    add(static_cast<uint64_t>(values.size()));
    return add_bytes(values.data(), values.size() * sizeof(T));
  }
  Hash128 finish() const;

 private:
  void* state_;
};

}  // namespace lucarium
