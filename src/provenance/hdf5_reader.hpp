// SPDX-License-Identifier: Apache-2.0
// Records read again: texts by path, and the digest of everything. Nothing of the library shows here.
#pragma once
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "provenance/hdf5_file.hpp"

namespace scanmill::provenance {

/// Every member fails with BadInput naming the file when something is not as scanmill writes it. Not for use by several
/// threads at once.
class RecordReader {
 public:
  /// The file is read as a whole in a child process first: HDF5 crashes on some damaged files.
  /// errors  IoFailed when the file cannot be opened; BadInput when it is not there, no complete HDF5 file, or damaged
  ///         so that HDF5 crashes
  /// cost    reads the file twice
  static Result<RecordReader> open(const std::string& path);
  RecordReader(RecordReader&&) noexcept;
  RecordReader& operator=(RecordReader&&) = delete;
  ~RecordReader();

  /// A text dataset: one text, or a list of them.
  Result<std::vector<std::string>> texts(const std::string& dataset) const;
  Result<std::string> attribute(const std::string& object, const std::string& name) const;
  Result<std::vector<std::string>> attribute_texts(const std::string& object, const std::string& name) const;
  bool has_attribute(const std::string& object, const std::string& name) const;
  /// First extent of a dataset; 1 for a single value.
  Result<std::uint64_t> rows(const std::string& dataset) const;
  bool has(const std::string& object) const;
  /// All values of a dataset, or of an attribute of it, in the file's own type: one of those that Hdf5File writes.
  template <class T>
  Result<std::vector<T>> numbers(const std::string& dataset, const std::string& attribute = {}) const {
    TRY_ASSIGN(const std::string bytes, raw(dataset, attribute, element_of<T>()));
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
  }
  /// A number attribute of either kind; `whole` tells which it is.
  Result<double> number(const std::string& object, const std::string& attribute, bool& whole) const;
  /// Names of an object's attributes, in the order of their bytes.
  std::vector<std::string> attributes(const std::string& object) const;
  /// Names in a group, in the order of their bytes.
  Result<std::vector<std::string>> children(const std::string& group) const;
  /// Lines of record_content.hpp for everything but the root attribute `content`.
  Result<std::vector<std::string>> content() const;

 private:
  struct Impl;
  Result<std::string> raw(const std::string& path, const std::string& attribute, Element element) const;
  explicit RecordReader(std::unique_ptr<Impl> impl);
  static Result<RecordReader> open_here(const std::string& path);
  static bool comes_to_an_end(const std::string& path);
  std::unique_ptr<Impl> impl_;
};

}  // namespace scanmill::provenance
