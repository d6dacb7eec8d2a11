// SPDX-License-Identifier: Apache-2.0
// What a technique has computed, in named chunks: how it writes them and reads them again (Technique::save_state,
// load_state). docs/state_files.md says what a file of them looks like.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "lucarium/compute/device/buffer.h"

namespace lucarium {

/// Takes the chunks of a state, one after the other. Names consist of a-z, 0-9, '_' and '.', at most 64 of them, each
/// once.
class StateWriter {
 public:
  virtual ~StateWriter();
  template <class T>
  void put(const std::string& name, const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes(name, values.data(), sizeof(T), values.size());
  }
  template <class T>
  void put(const std::string& name, const TypedBuffer<T>& buffer) {
    put(name, buffer.download());
  }
  template <class T>
  void put_value(const std::string& name, const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes(name, &value, sizeof(T), 1);
  }

 protected:
  virtual void put_bytes(const std::string& name, const void* data, size_t element_bytes, uint64_t elements) = 0;
};

/// Gives the chunks of a state by name, in any order, each as often as wanted. What is not as expected (no such chunk,
/// elements of another size, another number of them) is Error{input} that names the file, the chunk and the reason.
/// Bytes are what was written; whether their values make sense is for the technique to see.
class StateReader {
 public:
  virtual ~StateReader();
  virtual bool has(const std::string& name) const = 0;
  /// All elements.
  template <class T>
  std::vector<T> get(const std::string& name) const {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> values(checked_count(name, sizeof(T)));
    get_bytes(name, values.data());
    return values;
  }
  /// All elements, of which there must be `count`.
  template <class T>
  std::vector<T> get(const std::string& name, uint64_t count) const {
    require_count(name, sizeof(T), count);
    return get<T>(name);
  }
  template <class T>
  T get_value(const std::string& name) const {
    return get<T>(name, 1).front();
  }
  /// The same for elements that consist of floats, none of which may be NaN or infinite.
  template <class T>
  std::vector<T> get_finite(const std::string& name, uint64_t count) const {
    static_assert(sizeof(T) % sizeof(float) == 0);
    std::vector<T> values = get<T>(name, count);
    require_finite(name, reinterpret_cast<const float*>(values.data()), values.size() * (sizeof(T) / sizeof(float)));
    return values;
  }
  /// Into a buffer of as many elements.
  template <class T>
  void get_buffer(const std::string& name, TypedBuffer<T>& buffer) const {
    buffer.upload(get<T>(name, buffer.count()));
  }
  template <class T>
  void get_finite_buffer(const std::string& name, TypedBuffer<T>& buffer) const {
    buffer.upload(get_finite<T>(name, buffer.count()));
  }
  /// The same, with all floats from 0 to `largest`: light.
  template <class T>
  void get_light_buffer(const std::string& name, TypedBuffer<T>& buffer, double largest) const {
    const std::vector<T> values = get_finite<T>(name, buffer.count());
    require_range(name, reinterpret_cast<const float*>(values.data()), values.size() * (sizeof(T) / sizeof(float)),
                  largest);
    buffer.upload(values);
  }
  /// Throws Error{input}: the chunk holds `what` ("the index 9 of 4 tiles").
  [[noreturn]] void fail(const std::string& name, const std::string& what) const;

 protected:
  virtual size_t element_bytes(const std::string& name) const = 0;  ///< of a chunk that is there
  virtual uint64_t count(const std::string& name) const = 0;
  virtual void get_bytes(const std::string& name, void* target) const = 0;
  virtual std::string source() const = 0;  ///< for messages: the file

 private:
  uint64_t checked_count(const std::string& name, size_t bytes) const;
  void require_count(const std::string& name, size_t bytes, uint64_t expected) const;
  void require_finite(const std::string& name, const float* values, size_t number) const;
  void require_range(const std::string& name, const float* values, size_t number, double largest) const;
};

/// The chunk "texels": texels of the atlas that saved light belongs to. Throws Error{input} where there can be no such
/// atlas.
uint64_t saved_texels(const StateReader& state);

}  // namespace lucarium
