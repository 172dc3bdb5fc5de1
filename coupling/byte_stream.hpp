#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "coupling/message.hpp"
#include "fluid/errors.hpp"

namespace bedload {

/// Plain records, texts and lists one behind the other.
class ByteWriter {
 public:
  template <Record T>
  void put(const T& value) {
    const auto* const bytes = reinterpret_cast<const char*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof(T));
  }
  template <Record T>
  void put_list(std::span<const T> values) {
    put(static_cast<std::uint64_t>(values.size()));
    const auto* const bytes = reinterpret_cast<const char*>(values.data());
    bytes_.insert(bytes_.end(), bytes, bytes + values.size_bytes());
  }
  void put_text(const std::string& text) { put_list(std::span<const char>(text)); }
  const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::vector<char> bytes_;
};

/// Reads them again in the same order. Throws UserError where the bytes end too early.
class ByteReader {
 public:
  explicit ByteReader(std::span<const char> bytes) : left_(bytes) {}

  template <Record T>
  T get() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  template <Record T>
  std::vector<T> get_list() {
    const auto count = get<std::uint64_t>();
    if (count > left_.size() / sizeof(T)) fail();
    std::vector<T> values(count);
    if (count > 0) std::memcpy(values.data(), take(count * sizeof(T)).data(), count * sizeof(T));
    return values;
  }
  std::string get_text() {
    const std::vector<char> text = get_list<char>();
    return {text.begin(), text.end()};
  }

 private:
  std::span<const char> take(std::size_t size) {
    if (size > left_.size()) fail();
    const auto taken = left_.first(size);
    left_ = left_.subspan(size);
    return taken;
  }
  [[noreturn]] static void fail() { throw UserError("it ends in the middle of its content"); }

  std::span<const char> left_;
};

}  // namespace bedload
