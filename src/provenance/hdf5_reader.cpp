// SPDX-License-Identifier: Apache-2.0
#include "provenance/hdf5_reader.hpp"

#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/digest.hpp"
#include "provenance/record_content.hpp"
#include "provenance/trial_reading.hpp"

namespace scanmill::provenance {
namespace {

/// Larger datasets than any record of this machine could hold: a file that claims them is damaged. So is one that
/// claims more than deflate could have made so small.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40, kMostInflated = 1100;

/// An id of the library and the function that gives it back.
class Handle {
 public:
  Handle(hid_t id, herr_t (*release)(hid_t)) : id_(id), close_(release) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  bool valid() const { return id_ >= 0; }
  hid_t get() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// A dataset or attribute as it lies in the file.
struct Stored {
  std::string type;  // as identities name it
  std::vector<std::uint64_t> shape;
  std::size_t element_bytes = 0;
  std::string bytes;
};

std::string word_of(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_STRING:
      return H5Tis_variable_str(type) > 0 ? "" : "text" + std::to_string(size);
    case H5T_FLOAT:
      return "float" + std::to_string(8 * size);
    case H5T_INTEGER:
      return (H5Tget_sign(type) == H5T_SGN_NONE ? "uint" : "int") + std::to_string(8 * size);
    default:
      return "";
  }
}

/// `read` fills a buffer in the file's own type.
template <class Read>
bool fill(hid_t type, hid_t space, std::uint64_t stored_bytes, Stored& out, Read read) {
  if (type < 0 || space < 0) return false;
  out.type = word_of(type);
  const int rank = H5Sget_simple_extent_ndims(space);
  if (out.type.empty() || rank < 0 || rank > 8) return false;
  hsize_t extents[8] = {};
  if (rank > 0) H5Sget_simple_extent_dims(space, extents, nullptr);
  out.shape.assign(extents, extents + rank);
  out.element_bytes = H5Tget_size(type);
  std::uint64_t bytes = out.element_bytes;
  for (const std::uint64_t extent : out.shape) {
    if (extent > 0 && bytes > kMostBytes / extent) return false;
    bytes *= extent;
  }
  if (bytes / kMostInflated > stored_bytes) return false;
  out.bytes.assign(bytes, '\0');
  return bytes == 0 || read(type, out.bytes.data()) >= 0;
}

bool read_dataset(hid_t file, const std::string& path, Stored& out) {
  const Handle item(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!item.valid()) return false;
  const Handle type(H5Dget_type(item.get()), H5Tclose), space(H5Dget_space(item.get()), H5Sclose);
  return fill(type.get(), space.get(), H5Dget_storage_size(item.get()), out,
              [&](hid_t as, void* to) { return H5Dread(item.get(), as, H5S_ALL, H5S_ALL, H5P_DEFAULT, to); });
}

bool read_attribute(hid_t file, const std::string& object, const std::string& name, Stored& out) {
  const Handle item(H5Aopen_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!item.valid()) return false;
  const Handle type(H5Aget_type(item.get()), H5Tclose), space(H5Aget_space(item.get()), H5Sclose);
  return fill(type.get(), space.get(), H5Aget_storage_size(item.get()), out,
              [&](hid_t as, void* to) { return H5Aread(item.get(), as, to); });
}

std::vector<std::string> texts_of(const Stored& stored) {
  std::vector<std::string> list;
  for (std::size_t at = 0; stored.element_bytes > 0 && at + stored.element_bytes <= stored.bytes.size();
       at += stored.element_bytes) {
    std::string text = stored.bytes.substr(at, stored.element_bytes);
    text.resize(std::min(text.find('\0'), text.size()));
    list.push_back(std::move(text));
  }
  return list;
}

struct Visited {
  std::string path;
  H5O_type_t type;
};

std::vector<std::string> attributes_of(hid_t file, const std::string& path) {
  std::vector<std::string> names;
  hsize_t at = 0;
  H5Aiterate_by_name(
      file, path.c_str(), H5_INDEX_NAME, H5_ITER_INC, &at,
      [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->push_back(name);
        return 0;
      },
      &names, H5P_DEFAULT);
  return names;
}

}  // namespace

struct RecordReader::Impl {
  std::string path;
  Handle file;
  Error damaged(const std::string& what) const {
    H5Eclear2(H5E_DEFAULT);
    return fail(Code::BadInput, what + " cannot be read; the record is damaged, or was not written by scanmill", path);
  }
};

RecordReader::RecordReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RecordReader::RecordReader(RecordReader&&) noexcept = default;
RecordReader::~RecordReader() = default;

Result<RecordReader> RecordReader::open(const std::string& path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  if (::access(path.c_str(), R_OK) != 0)
    return fail(errno == ENOENT || errno == ENOTDIR ? Code::BadInput : Code::IoFailed,
                std::string("the record cannot be read: ") + std::strerror(errno), path);
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode))
    return fail(Code::BadInput, "is no file; a record.h5 was expected", path);
  const auto bytes = static_cast<std::uint64_t>(status.st_size);
  if (const auto tried = try_in_child(path, bytes, [&] { return comes_to_an_end(path); }); !tried.ok())
    return tried.error();
  return open_here(path);
}

/// Whatever can be read is read, so that nothing else in the file crashes later. True also when HDF5 says no: that is
/// an answer.
bool RecordReader::comes_to_an_end(const std::string& path) {
  if (const auto record = open_here(path); record.ok()) {
    (void)record->content();
    (void)record->children("/stages");
  }
  return true;
}

Result<RecordReader> RecordReader::open_here(const std::string& path) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (!access.valid() || H5Pset_file_locking(access.get(), false, true) < 0)
    return fail(Code::Internal, "HDF5 could not prepare to read", path);
  Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
  if (!file.valid()) {
    H5Eclear2(H5E_DEFAULT);
    return fail(Code::BadInput, "not a complete HDF5 file; a record.h5 was expected", path);
  }
  return RecordReader(std::unique_ptr<Impl>(new Impl{path, std::move(file)}));
}

Result<std::vector<std::string>> RecordReader::texts(const std::string& dataset) const {
  Stored stored;
  if (!read_dataset(impl_->file.get(), dataset, stored) || stored.type.substr(0, 4) != "text")
    return impl_->damaged(dataset);
  return texts_of(stored);
}

bool RecordReader::has_attribute(const std::string& object, const std::string& name) const {
  return H5Aexists_by_name(impl_->file.get(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

Result<std::vector<std::string>> RecordReader::attribute_texts(const std::string& object,
                                                               const std::string& name) const {
  Stored stored;
  if (!read_attribute(impl_->file.get(), object, name, stored) || stored.type.substr(0, 4) != "text")
    return impl_->damaged(object + " @" + name);
  return texts_of(stored);
}

Result<std::string> RecordReader::attribute(const std::string& object, const std::string& name) const {
  TRY_ASSIGN(const std::vector<std::string> texts, attribute_texts(object, name));
  return texts.empty() ? std::string() : texts[0];
}

Result<std::uint64_t> RecordReader::rows(const std::string& dataset) const {
  const Handle item(H5Dopen2(impl_->file.get(), dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (!item.valid()) return impl_->damaged(dataset);
  const Handle space(H5Dget_space(item.get()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  hsize_t extents[8] = {};
  if (rank < 0 || rank > 8) return impl_->damaged(dataset);
  if (rank > 0) H5Sget_simple_extent_dims(space.get(), extents, nullptr);
  return rank > 0 ? extents[0] : 1;
}

bool RecordReader::has(const std::string& object) const {
  return H5Lexists(impl_->file.get(), object.c_str(), H5P_DEFAULT) > 0;
}

Result<std::string> RecordReader::raw(const std::string& path, const std::string& attribute, Element element) const {
  Stored stored;
  const bool read = attribute.empty() ? read_dataset(impl_->file.get(), path, stored)
                                      : read_attribute(impl_->file.get(), path, attribute, stored);
  if (!read || stored.type != type_word(element))
    return impl_->damaged(path + (attribute.empty() ? "" : " @" + attribute));
  return std::move(stored.bytes);
}

Result<double> RecordReader::number(const std::string& object, const std::string& attribute, bool& whole) const {
  Stored stored;
  if (!read_attribute(impl_->file.get(), object, attribute, stored) || stored.bytes.size() != sizeof(double))
    return impl_->damaged(object + " @" + attribute);
  whole = stored.type == type_word(Element::Int64);
  if (!whole && stored.type != type_word(Element::Float64)) return impl_->damaged(object + " @" + attribute);
  std::int64_t integer = 0;
  double value = 0;
  std::memcpy(&integer, stored.bytes.data(), sizeof integer);
  std::memcpy(&value, stored.bytes.data(), sizeof value);
  return whole ? static_cast<double>(integer) : value;
}

std::vector<std::string> RecordReader::attributes(const std::string& object) const {
  std::vector<std::string> names = attributes_of(impl_->file.get(), object);
  std::sort(names.begin(), names.end());
  return names;
}

Result<std::vector<std::string>> RecordReader::children(const std::string& group) const {
  std::vector<std::string> names;
  hsize_t at = 0;
  const herr_t done = H5Literate_by_name(
      impl_->file.get(), group.c_str(), H5_INDEX_NAME, H5_ITER_INC, &at,
      [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->push_back(name);
        return 0;
      },
      &names, H5P_DEFAULT);
  if (done < 0) return impl_->damaged(group);
  std::sort(names.begin(), names.end());
  return names;
}

Result<std::vector<std::string>> RecordReader::content() const {
  const hid_t file = impl_->file.get();
  std::vector<Visited> objects;
  const herr_t done = H5Ovisit2(
      file, H5_INDEX_NAME, H5_ITER_INC,
      [](hid_t, const char* name, const H5O_info_t* info, void* out) -> herr_t {
        const std::string path = std::strcmp(name, ".") == 0 ? "/" : "/" + std::string(name);
        static_cast<std::vector<Visited>*>(out)->push_back({path, info->type});
        return 0;
      },
      &objects, H5O_INFO_BASIC);
  if (done < 0) return impl_->damaged("the list of objects");
  std::vector<std::string> items;
  for (const Visited& object : objects) {
    Stored stored;
    if (object.type == H5O_TYPE_DATASET) {
      if (!read_dataset(file, object.path, stored)) return impl_->damaged(object.path);
      items.push_back(content_item(object.path, "", stored.type, stored.shape, sha256_hex(stored.bytes)));
    } else if (object.path != "/") {
      items.push_back(content_item(object.path, "", "group", {}, sha256_hex("")));
    }
    for (const std::string& name : attributes_of(file, object.path)) {
      if (object.path == "/" && name == "content") continue;
      Stored value;
      if (!read_attribute(file, object.path, name, value)) return impl_->damaged(object.path + " @" + name);
      items.push_back(content_item(object.path, name, value.type, value.shape, sha256_hex(value.bytes)));
    }
  }
  return items;
}

}  // namespace scanmill::provenance
