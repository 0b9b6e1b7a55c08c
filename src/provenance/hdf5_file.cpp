// SPDX-License-Identifier: Apache-2.0
// HDF5 through its C API with owned handles. The default file differs from run to run by the times of its objects; with
// time tracking off on the file, every group and every dataset, and one order of writing, two runs give the same bytes.
#include "provenance/hdf5_file.hpp"

#include <fcntl.h>
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/digest.hpp"
#include "provenance/record_content.hpp"

namespace scanmill::provenance {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written and digested as they lie in memory");

/// Below this a dataset is one piece; above it is cut in chunks, shuffled and deflated.
constexpr std::uint64_t kContiguousBytes = 1024;
/// Deflate works on pieces of this size; four of them fit the library's own chunk cache.
constexpr std::uint64_t kChunkBytes = 256 * 1024;
/// Level 1: level 4 gains 1-2 % on meshes and costs twice the time.
constexpr unsigned kDeflateLevel = 1;

/// An id of the library and the function that gives it back.
class Handle {
 public:
  Handle(hid_t id, herr_t (*release)(hid_t)) : id_(id), close_(release) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() { close(); }
  bool valid() const { return id_ >= 0; }
  hid_t get() const { return id_; }
  bool close() { return id_ < 0 || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Nothing printed by the library, and no second attempt to flush a file at exit after a close that failed.
void quiet_library() {
  static const bool at_exit_off = H5dont_atexit() >= 0;
  (void)at_exit_off;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// The innermost sentence of the library's error stack.
std::string innermost_sentence() {
  std::string sentence;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* entry, void* out) -> herr_t {
        if (n == 0 && entry->desc != nullptr) *static_cast<std::string*>(out) = entry->desc;
        return 0;
      },
      &sentence);
  return sentence.empty() ? "no reason given" : sentence;
}

/// The library reports system calls as "... errno = 28, error message = 'No space left on device', buf = 0x...";
/// addresses and clock times in it are of no use to anybody.
Error hdf5_error(const std::string& file, const std::string& doing) {
  std::string reason = innermost_sentence();
  Code code = Code::IoFailed;
  if (const auto at = reason.find("errno = "); at != std::string::npos) {
    const int number = std::atoi(reason.c_str() + at + 8);
    if (number == ENOSPC || number == EDQUOT) code = Code::NoSpace;
    reason = std::strerror(number);
  }
  H5Eclear2(H5E_DEFAULT);
  const char* advice = code == Code::NoSpace ? "; make room there and run again" : "";
  return fail(code, "HDF5 could not " + doing + ": " + reason + advice, file);
}

hid_t stored_type(Element element) {
  switch (element) {
    case Element::Float64:
      return H5T_IEEE_F64LE;
    case Element::Float32:
      return H5T_IEEE_F32LE;
    case Element::UInt8:
      return H5T_STD_U8LE;
    case Element::UInt32:
      return H5T_STD_U32LE;
    case Element::UInt64:
      return H5T_STD_U64LE;
    case Element::Int64:
      return H5T_STD_I64LE;
  }
  return H5I_INVALID_HID;
}

std::uint64_t product(std::span<const std::uint64_t> shape) {
  std::uint64_t n = 1;
  for (const std::uint64_t extent : shape) n *= extent;
  return n;
}

Handle space_of(const std::vector<std::uint64_t>& shape) {
  if (shape.empty()) return {H5Screate(H5S_SCALAR), H5Sclose};
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  return {H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), H5Sclose};
}

/// How a dataset lies in the file; invalid when the library refuses.
Handle layout_of(const std::vector<std::uint64_t>& shape, std::uint64_t element_bytes) {
  Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  if (!list.valid() || H5Pset_obj_track_times(list.get(), false) < 0) return {H5I_INVALID_HID, H5Pclose};
  if (shape.empty() || product(shape) * element_bytes <= kContiguousBytes) return list;
  std::vector<hsize_t> chunk(shape.begin(), shape.end());
  const std::uint64_t row_bytes = product(shape) / shape[0] * element_bytes;
  chunk[0] = std::clamp<std::uint64_t>(kChunkBytes / row_bytes, 1, shape[0]);
  const bool set = H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data()) >= 0 &&
                   H5Pset_shuffle(list.get()) >= 0 && H5Pset_deflate(list.get(), kDeflateLevel) >= 0;
  return set ? std::move(list) : Handle(H5I_INVALID_HID, H5Pclose);
}

Handle text_type(std::uint64_t length, bool ascii) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  const bool set = type.valid() && H5Tset_size(type.get(), length) >= 0 &&
                   H5Tset_strpad(type.get(), H5T_STR_NULLPAD) >= 0 &&
                   H5Tset_cset(type.get(), ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8) >= 0;
  return set ? std::move(type) : Handle(H5I_INVALID_HID, H5Tclose);
}

Result<void> sync_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = fd >= 0 && ::fsync(fd) == 0;
  const int reason = errno;
  if (fd >= 0) ::close(fd);
  if (synced) return {};
  return fail(reason == ENOSPC || reason == EDQUOT ? Code::NoSpace : Code::IoFailed,
              std::string("the file could not be synced to the disk: ") + std::strerror(reason), path);
}

}  // namespace

const char* type_word(Element element) {
  switch (element) {
    case Element::Float64:
      return "float64";
    case Element::Float32:
      return "float32";
    case Element::UInt8:
      return "uint8";
    case Element::UInt32:
      return "uint32";
    case Element::UInt64:
      return "uint64";
    case Element::Int64:
      return "int64";
  }
  return "";
}

struct Hdf5File::Impl {
  std::string path;
  Handle file;
  Sha256 digest;
  std::vector<std::string> items;  // content_item() of everything but second names
  bool closed = false;

  Impl(std::string name, Handle handle) : path(std::move(name)), file(std::move(handle)) {}

  void digest_item(const std::string& kind, const std::string& at, const std::string& attribute,
                   const std::string& type, const std::vector<std::uint64_t>& shape, std::span<const char> bytes) {
    std::string head = kind + " " + at;
    if (!attribute.empty()) head += " @" + attribute;
    head += " " + type + " [";
    for (const std::uint64_t extent : shape) head += std::to_string(extent) += ',';
    digest.add(std::string_view(head += "]\n"));
    digest.add(bytes);
  }
  void note_item(const std::string& at, const std::string& attribute, const std::string& type,
                 const std::vector<std::uint64_t>& shape, std::string_view bytes) {
    items.push_back(content_item(at, attribute, type, shape, sha256_hex(bytes)));
  }

  /// The one place where a dataset or attribute is made and filled.
  Result<void> put(const std::string& at, const std::string& attribute, hid_t type, std::uint64_t element_bytes,
                   const std::vector<std::uint64_t>& shape, const void* data) {
    const std::string doing = "write " + at + (attribute.empty() ? "" : " @" + attribute);
    const Handle space = space_of(shape);
    if (!space.valid() || type < 0) return hdf5_error(path, doing);
    if (!attribute.empty()) {
      Handle item(H5Acreate_by_name(file.get(), at.c_str(), attribute.c_str(), type, space.get(), H5P_DEFAULT,
                                    H5P_DEFAULT, H5P_DEFAULT),
                  H5Aclose);
      if (!item.valid() || H5Awrite(item.get(), type, data) < 0 || !item.close()) return hdf5_error(path, doing);
      return {};
    }
    const Handle layout = layout_of(shape, element_bytes);
    if (!layout.valid()) return hdf5_error(path, doing);
    Handle item(H5Dcreate2(file.get(), at.c_str(), type, space.get(), H5P_DEFAULT, layout.get(), H5P_DEFAULT),
                H5Dclose);
    if (!item.valid()) return hdf5_error(path, doing);
    if (product(shape) > 0 && H5Dwrite(item.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) {
      return hdf5_error(path, doing);
    }
    if (!item.close()) return hdf5_error(path, doing);
    return {};
  }
};

Hdf5File::Hdf5File(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;

Hdf5File::~Hdf5File() {
  if (!impl_ || impl_->closed) return;
  // On a full disk the library keeps the file open when it cannot flush; cutting it first gives the space back anyway.
  impl_->file.close();
  if (::truncate(impl_->path.c_str(), 0) == 0) ::unlink(impl_->path.c_str());
  H5Eclear2(H5E_DEFAULT);
}

Result<Hdf5File> Hdf5File::create(const std::string& path) {
  quiet_library();
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose), access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // Locks fail on some cluster file systems; nobody else knows the file yet, so they are best effort.
  if (!creation.valid() || !access.valid() || H5Pset_obj_track_times(creation.get(), false) < 0 ||
      H5Pset_file_locking(access.get(), true, true) < 0) {
    return hdf5_error(path, "prepare the file");
  }
  Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose);
  if (!file.valid()) return hdf5_error(path, "create the file");
  return Hdf5File(std::make_unique<Impl>(path, std::move(file)));
}

Result<void> Hdf5File::group(const std::string& path) {
  const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  if (!creation.valid() || H5Pset_obj_track_times(creation.get(), false) < 0) {
    return hdf5_error(impl_->path, "make group " + path);
  }
  Handle group(H5Gcreate2(impl_->file.get(), path.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Gclose);
  if (!group.valid() || !group.close()) return hdf5_error(impl_->path, "make group " + path);
  impl_->digest_item("group", path, "", "-", {}, {});
  impl_->note_item(path, "", "group", {}, {});
  return {};
}

Result<void> Hdf5File::link(const std::string& existing, const std::string& path) {
  const hid_t file = impl_->file.get();
  if (H5Lcreate_hard(file, existing.c_str(), file, path.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0) {
    return hdf5_error(impl_->path, "link " + path);
  }
  impl_->digest_item("link", path, "", existing, {}, {});
  return {};
}

Result<void> Hdf5File::write_numbers(const std::string& path, const std::string& attribute, Element element,
                                     const std::vector<std::uint64_t>& shape, const void* data) {
  const std::uint64_t bytes = element_bytes(element);
  TRY(impl_->put(path, attribute, stored_type(element), bytes, shape, data));
  impl_->digest_item(attribute.empty() ? "dataset" : "attribute", path, attribute, type_word(element), shape,
                     {static_cast<const char*>(data), static_cast<std::size_t>(product(shape) * bytes)});
  impl_->note_item(path, attribute, type_word(element), shape,
                   {static_cast<const char*>(data), static_cast<std::size_t>(product(shape) * bytes)});
  return {};
}

Result<void> Hdf5File::write_texts(const std::string& path, const std::string& attribute,
                                   std::span<const std::string> list, bool scalar, bool digested) {
  std::size_t length = 1;  // the library knows no empty text type
  bool ascii = true;
  for (const std::string& text : list) {
    length = std::max(length, text.size());
    ascii = ascii && std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  }
  std::string padded(length * list.size(), '\0');
  for (std::size_t i = 0; i < list.size(); ++i) list[i].copy(padded.data() + i * length, length);
  const std::vector<std::uint64_t> shape =
      scalar ? std::vector<std::uint64_t>{} : std::vector<std::uint64_t>{list.size()};
  const Handle type = text_type(length, ascii);
  TRY(impl_->put(path, attribute, type.get(), length, shape, padded.data()));
  impl_->note_item(path, attribute, "text" + std::to_string(length), shape, padded);
  if (digested) {
    impl_->digest_item(attribute.empty() ? "dataset" : "attribute", path, attribute, "text" + std::to_string(length),
                       shape, padded);
  }
  return {};
}

Result<void> Hdf5File::text(const std::string& path, const std::string& text) {
  return write_texts(path, {}, {&text, 1}, true, true);
}

Result<void> Hdf5File::texts(const std::string& path, std::span<const std::string> list) {
  return write_texts(path, {}, list, false, true);
}

Result<void> Hdf5File::attribute(const std::string& object, const std::string& name, const std::string& text,
                                 bool digested) {
  return write_texts(object, name, {&text, 1}, true, digested);
}

Result<void> Hdf5File::attribute(const std::string& object, const std::string& name,
                                 std::span<const std::string> texts) {
  return write_texts(object, name, texts, false, true);
}

std::string Hdf5File::identity() { return impl_->digest.hex(); }

std::string Hdf5File::content() const { return content_digest(impl_->items); }

Result<void> Hdf5File::close() {
  if (H5Fflush(impl_->file.get(), H5F_SCOPE_GLOBAL) < 0) return hdf5_error(impl_->path, "flush the file");
  if (!impl_->file.close()) return hdf5_error(impl_->path, "close the file");
  TRY(sync_file(impl_->path));
  impl_->closed = true;
  return {};
}

Result<std::string> Hdf5File::read_root_text(const std::string& path, const std::string& name) {
  quiet_library();
  if (::access(path.c_str(), R_OK) != 0) {
    return fail(Code::IoFailed, std::string("the record cannot be read: ") + std::strerror(errno), path);
  }
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (!access.valid() || H5Pset_file_locking(access.get(), false, true) < 0)
    return hdf5_error(path, "prepare the file");
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
  if (!file.valid()) {
    H5Eclear2(H5E_DEFAULT);
    return fail(Code::BadInput, "not a complete HDF5 file; a record.h5 was expected", path);
  }
  const auto unknown = [&] {
    H5Eclear2(H5E_DEFAULT);
    return fail(Code::BadInput,
                "no text attribute '" + name + "' at the root; a record written by scanmill was expected", path);
  };
  const Handle attribute(H5Aopen(file.get(), name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.valid()) return unknown();
  const Handle type(H5Aget_type(attribute.get()), H5Tclose), space(H5Aget_space(attribute.get()), H5Sclose);
  if (!type.valid() || !space.valid() || H5Tget_class(type.get()) != H5T_STRING ||
      H5Tis_variable_str(type.get()) != 0 || H5Sget_simple_extent_npoints(space.get()) != 1) {
    return unknown();
  }
  std::string text(H5Tget_size(type.get()), '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return unknown();
  text.resize(std::strlen(text.c_str()));
  return text;
}

}  // namespace scanmill::provenance
