// SPDX-License-Identifier: Apache-2.0
#include "formats/fringe_set.hpp"

#include <algorithm>

#include "base/digest.hpp"
#include "base/text.hpp"
#include "document/read_fields.hpp"
#include "formats/png.hpp"

namespace scanmill::formats {
namespace {

using document::Node;
using document::Problems;

constexpr std::uint64_t kLongest = 1 << 20;
constexpr std::string_view kKeys[] = {"scanmill_fringes", "gratings", "quality", "sha256"};
constexpr std::string_view kGratingKeys[] = {"period_mm", "object", "plate"};

std::vector<std::string> read_names(const Node* list, const Node& owner, const std::string& key, Problems& problems) {
  std::vector<std::string> names;
  if (list == nullptr || !list->is_sequence() || list->items().size() < 3) {
    problems.add(list != nullptr ? list->mark : owner.mark, key,
                 "wanted a list of at least 3 pictures, in the order of their shifts");
    return names;
  }
  for (const Node& item : list->items()) {
    const std::string name = item.is_string() ? item.as_string() : item.text;
    if (name.empty() || !is_inside(name))
      problems.add(item.mark, key, "found " + document::shown(item) + "; wanted a file in the folder of this text");
    names.push_back(name);
  }
  return names;
}

void read_grating(const Node& node, const std::string& key, FringeSet& set, Problems& problems) {
  if (!node.is_map()) return problems.add(node.mark, key, "wanted period_mm, object and plate");
  for (const Node::Entry& entry : node.entries())
    if (std::find(std::begin(kGratingKeys), std::end(kGratingKeys), entry.key) == std::end(kGratingKeys))
      problems.add_unknown(entry, key, kGratingKeys);
  FringeGrating grating;
  const Node* period = node.find("period_mm");
  if (period == nullptr || !period->is_number() || !(period->as_number() > 0))
    problems.add(node.mark, key + ".period_mm", "wanted the period on the plate, above 0");
  else
    grating.period_mm = period->as_number();
  grating.object = read_names(node.find("object"), node, key + ".object", problems);
  grating.plate = read_names(node.find("plate"), node, key + ".plate", problems);
  set.gratings.push_back(std::move(grating));
}

void read_hashes(const Node& map, FringeSet& set, Problems& problems) {
  if (!map.is_map()) return problems.add(map.mark, "sha256", "wanted a map from picture to SHA-256");
  for (const Node::Entry& entry : map.entries())
    set.sha256.push_back({entry.key, entry.value.is_string() ? entry.value.as_string() : entry.value.text});
}

Result<fringe::Picture> read_picture(const FringeSet& set, const std::string& name, const OpenBeside& open,
                                     const std::string& place, int& bits) {
  const auto opened = open(name);
  if (!opened.ok()) return Error(opened.error()).at(place);
  const auto& source = *opened;
  const auto expected =
      std::find_if(set.sha256.begin(), set.sha256.end(), [&](const auto& row) { return row.first == name; });
  if (expected != set.sha256.end()) {
    TRY_ASSIGN(const std::string digest, sha256_of(*source));
    if (digest != expected->second)
      return fail(Code::BadInput,
                  "the picture " + name + " has SHA-256 " + digest + ", the text names " + expected->second +
                      "; it was changed or exchanged",
                  place);
  }
  TRY_ASSIGN(const PngFile file, open_png(*source, true));
  if (bits == 0) bits = file.bits;
  if (bits != file.bits)
    return fail(Code::BadInput,
                "the picture has " + std::to_string(file.bits) + " bits a pixel, the first has " + std::to_string(bits),
                source->name());
  fringe::Picture picture{file.width, file.height, {}};
  TRY(read_png(*source, file, picture.pixels));
  return picture;
}

}  // namespace

Result<FringeSet> read_fringe_set(const ByteSource& source) {
  TRY_ASSIGN(const std::string text, read_all(source, kLongest));
  auto tree = document::parse_yaml(text, source.name());
  if (!tree.ok()) return fail(Code::BadInput, tree.error().message, tree.error().where);
  const Node& root = *tree;
  FringeSet set;
  Problems problems(source.name());
  if (!root.is_map() || root.find("scanmill_fringes") == nullptr || !root.find("scanmill_fringes")->is_integer() ||
      root.find("scanmill_fringes")->as_integer() != 1)
    return fail(Code::BadInput, "wanted scanmill_fringes: 1 and gratings", source.name());
  document::read_fields(root, "", fringe::Optics::fields(), &set.optics, kKeys, problems);
  if (const Node* quality = root.find("quality"))
    document::read_fields(*quality, "quality", fringe::Quality::fields(), &set.quality, {}, problems);
  const Node* gratings = root.find("gratings");
  if (gratings == nullptr || !gratings->is_sequence() || gratings->items().empty())
    problems.add(root.mark, "gratings", "wanted a list of gratings, the coarsest first");
  else
    for (std::size_t g = 0; g < gratings->items().size(); ++g)
      read_grating(gratings->items()[g], "gratings[" + std::to_string(g) + "]", set, problems);
  if (const Node* hashes = root.find("sha256")) read_hashes(*hashes, set, problems);
  if (problems.empty()) return set;
  Error error = problems.error();
  error.code = Code::BadInput;
  return error;
}

std::string fringe_set_text(const FringeSet& set) {
  Node root = Node::map();
  root.set("scanmill_fringes", 1);
  for (const Field& field : fringe::Optics::fields()) root.set(field.name, document::field_value(field, &set.optics));
  Node gratings = Node::sequence();
  for (const FringeGrating& grating : set.gratings) {
    Node row = Node::map();
    row.set("period_mm", grating.period_mm);
    for (const auto& [key, names] : {std::pair{"object", &grating.object}, std::pair{"plate", &grating.plate}}) {
      Node list = Node::sequence();
      for (const std::string& name : *names) list.push(name);
      row.set(key, std::move(list));
    }
    gratings.push(std::move(row));
  }
  root.set("gratings", std::move(gratings));
  root.set("quality", document::fields_to_document(fringe::Quality::fields(), &set.quality));
  Node hashes = Node::map();
  for (const auto& [name, digest] : set.sha256) hashes.set(name, digest);
  if (!set.sha256.empty()) root.set("sha256", std::move(hashes));
  return document::to_yaml(root);
}

Result<std::pair<std::int64_t, std::int64_t>> fringe_size(const FringeSet& set, const OpenBeside& open) {
  TRY_ASSIGN(const auto source, open(set.gratings.front().object.front()));
  TRY_ASSIGN(const PngFile file, open_png(*source, true));
  return std::pair<std::int64_t, std::int64_t>{file.width, file.height};
}

Result<fringe::RangeMap> decode_fringes(const FringeSet& set, const OpenBeside& open, const std::string& place) {
  std::vector<fringe::Shifted> gratings;
  int bits = 0;
  for (const FringeGrating& named : set.gratings) {
    fringe::Shifted& grating = gratings.emplace_back();
    grating.period_mm = named.period_mm;
    for (const std::string& name : named.object) {
      TRY_ASSIGN(fringe::Picture picture, read_picture(set, name, open, place, bits));
      grating.object.push_back(std::move(picture));
    }
    for (const std::string& name : named.plate) {
      TRY_ASSIGN(fringe::Picture picture, read_picture(set, name, open, place, bits));
      grating.plate.push_back(std::move(picture));
    }
  }
  auto map = fringe::range_map(set.optics, gratings, bits == 16 ? 65535 : 255, set.quality);
  if (!map.ok()) return fail(Code::BadInput, map.error().message, place);
  return std::move(map).value();
}

}  // namespace scanmill::formats
