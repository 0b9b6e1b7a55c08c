// SPDX-License-Identifier: Apache-2.0
// The wall around HDF5: a file written once, in one order, without times, that digests what it writes. Nothing of the
// library shows here, and none of its errors passes.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "base/result.hpp"
#include "geom/vec3.hpp"

namespace scanmill::provenance {

/// Element types of datasets and attributes; little-endian in the file.
enum class Element { Float64, Float32, UInt8, UInt32, UInt64, Int64 };

/// As identities and readers name them: "float64".
const char* type_word(Element element);

template <class T>
constexpr Element element_of() {
  if constexpr (std::is_same_v<T, double> || std::is_same_v<T, Vec3>)
    return Element::Float64;
  else if constexpr (std::is_same_v<T, float>)
    return Element::Float32;
  else if constexpr (std::is_same_v<T, std::uint8_t>)
    return Element::UInt8;
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return Element::UInt32;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return Element::UInt64;
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return Element::Int64;
  else
    return element_of<typename T::value_type>();  // std::array
}

/// Paths inside the file are absolute ("/mesh/triangles"); a group is made before what it holds. Every member fails
/// with IoFailed or NoSpace at the file's path. Not for use by several threads at once.
class Hdf5File {
 public:
  /// A new file; an older one of that name is replaced.
  static Result<Hdf5File> create(const std::string& path);
  Hdf5File(Hdf5File&&) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;
  /// A file that was not closed successfully is removed.
  ~Hdf5File();

  Result<void> group(const std::string& path);
  /// A second name for a dataset that is already there.
  Result<void> link(const std::string& existing, const std::string& path);

  /// Rows of scalars, Vec3 or std::array; shape is rows x width (rows alone for scalars), or as given.
  template <class T>
  Result<void> dataset(const std::string& path, std::span<const T> rows, std::vector<std::uint64_t> inner_shape = {}) {
    constexpr std::size_t kWidth = sizeof(T) / element_bytes(element_of<T>());
    std::vector<std::uint64_t> shape{rows.size()};
    if (!inner_shape.empty())
      shape.insert(shape.end(), inner_shape.begin(), inner_shape.end());
    else if (kWidth > 1)
      shape.push_back(kWidth);
    return write_numbers(path, {}, element_of<T>(), shape, rows.data());
  }
  template <class T>
  Result<void> dataset(const std::string& path, const std::vector<T>& rows,
                       std::vector<std::uint64_t> inner_shape = {}) {
    return dataset(path, std::span<const T>(rows), std::move(inner_shape));
  }
  /// One text; a list of texts (UTF-8, padded with NUL to the longest).
  Result<void> text(const std::string& path, const std::string& text);
  Result<void> texts(const std::string& path, std::span<const std::string> list);

  /// `digested` false keeps an attribute out of the identity.
  Result<void> attribute(const std::string& object, const std::string& name, const std::string& text,
                         bool digested = true);
  Result<void> attribute(const std::string& object, const std::string& name, std::span<const std::string> texts);
  Result<void> attribute(const std::string& object, const std::string& name, double value) {
    return write_numbers(object, name, Element::Float64, {}, &value);
  }
  Result<void> attribute(const std::string& object, const std::string& name, std::int64_t value) {
    return write_numbers(object, name, Element::Int64, {}, &value);
  }
  Result<void> attribute(const std::string& object, const std::string& name, Vec3 value) {
    return write_numbers(object, name, Element::Float64, {3}, &value);
  }
  template <std::size_t N>
  Result<void> attribute(const std::string& object, const std::string& name,
                         const std::array<std::int64_t, N>& values) {
    return write_numbers(object, name, Element::Int64, {N}, values.data());
  }

  /// SHA-256 over everything written so far, in writing order: kind, path, type, shape and little-endian bytes of each
  /// dataset and attribute. To be asked once, at the end.
  std::string identity();

  /// SHA-256 over the same items, those kept out of the identity too, in the order of their texts: what any reader can
  /// work out again (RecordReader::content). Second names of datasets are left out.
  std::string content() const;

  /// Flush, close, sync to the disk. Only now is the file complete.
  Result<void> close();

  /// The text attribute `name` of the root of an existing file.
  /// errors  IoFailed when it cannot be opened; BadInput when it is not HDF5 or has no such attribute
  static Result<std::string> read_root_text(const std::string& path, const std::string& name);

  static constexpr std::size_t element_bytes(Element element) {
    switch (element) {
      case Element::UInt8:
        return 1;
      case Element::Float32:
      case Element::UInt32:
        return 4;
      default:
        return 8;
    }
  }

 private:
  struct Impl;
  explicit Hdf5File(std::unique_ptr<Impl> impl);
  /// `attribute` empty: a dataset at `path`; else an attribute of the object at `path`. Empty shape: a scalar.
  Result<void> write_numbers(const std::string& path, const std::string& attribute, Element element,
                             const std::vector<std::uint64_t>& shape, const void* data);
  Result<void> write_texts(const std::string& path, const std::string& attribute, std::span<const std::string> list,
                           bool scalar, bool digested);

  std::unique_ptr<Impl> impl_;
};

}  // namespace scanmill::provenance
