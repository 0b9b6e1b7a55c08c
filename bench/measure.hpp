// SPDX-License-Identifier: Apache-2.0
// What the bench programs share: clocks, medians, their command lines, the files they read.
#pragma once
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cloud/cloud.hpp"
#include "formats/mesh_reader.hpp"
#include "formats/view_reader.hpp"
#include "store/files.hpp"

namespace scanmill::bench {

inline double cpu_seconds(const rusage& use) {
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(use.ru_utime) + seconds(use.ru_stime);
}

inline rusage own_use() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return use;
}

inline double cpu_seconds() { return cpu_seconds(own_use()); }
inline double peak_mib() { return static_cast<double>(own_use().ru_maxrss) / 1024; }
inline double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 2];
}

/// CPU and wall seconds of the rounds of one step.
class Timing {
 public:
  void start() {
    cpu_ = cpu_seconds();
    wall_ = wall_seconds();
  }
  void stop() {
    cpu_rounds_.push_back(cpu_seconds() - cpu_);
    wall_rounds_.push_back(wall_seconds() - wall_);
  }
  double cpu() const { return median(cpu_rounds_); }
  double wall() const { return median(wall_rounds_); }

 private:
  double cpu_ = 0, wall_ = 0;
  std::vector<double> cpu_rounds_, wall_rounds_;
};

/// The words of a bench's command line. An option takes the value after it when `takes` gives a function for it; the
/// one word without dashes is the file. --threads, --repeat and --json are everybody's.
struct CommandLine {
  std::string file;
  int threads = 1, repeat = 5;
  bool json = false;

  using Options = std::map<std::string, std::function<bool(const std::string&)>>;
  bool parse(int argc, char** argv, const Options& takes) {
    const auto count = [](int& to, const std::string& value) {
      to = std::max(1, std::atoi(value.c_str()));
      return true;
    };
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word == "--json") {
        json = true;
        continue;
      }
      if (!word.starts_with("--")) {
        file = word;
        continue;
      }
      if (i + 1 == argc) return false;
      const std::string value = argv[++i];
      const auto option = takes.find(word);
      const bool understood = word == "--threads"     ? count(threads, value)
                              : word == "--repeat"    ? count(repeat, value)
                              : option != takes.end() ? option->second(value)
                                                      : false;
      if (!understood) return false;
    }
    return true;
  }
};

/// For CommandLine: the value as it stands, and as a number.
inline auto text_into(std::string& to) {
  return [&to](const std::string& value) {
    to = value;
    return true;
  };
}
/// Refuses what is not above zero.
template <class Number>
auto number_into(Number& to) {
  return [&to](const std::string& value) {
    const double number = std::atof(value.c_str());
    if constexpr (std::is_integral_v<Number>)
      to = static_cast<Number>(number);
    else
      to = number;
    return number > 0;
  };
}

/// The end of every bench's main.
inline int exit_code(const char* program, const Result<void>& done) {
  if (!done.ok()) std::fprintf(stderr, "%s: %s\n", program, done.error().text().c_str());
  return done.ok() ? 0 : 1;
}

inline Result<std::vector<Vec3>> read_points(const std::string& file) {
  TRY_ASSIGN(std::shared_ptr<const ByteSource> source, store::open_file(file, file));
  TRY_ASSIGN(const auto reader, formats::open_view(source));
  std::vector<Vec3> points;
  PointBlock block;
  for (std::size_t b = 0; b < reader->block_count(); ++b) {
    block.clear();
    TRY(reader->read_block(b, block));
    points.insert(points.end(), block.positions.begin(), block.positions.end());
  }
  return points;
}

inline Result<Mesh> read_mesh(const std::string& file) {
  TRY_ASSIGN(std::shared_ptr<const ByteSource> source, store::open_file(file, file));
  TRY_ASSIGN(auto read, formats::read_mesh(source));
  Mesh mesh;
  mesh.positions = std::move(read.positions);
  mesh.triangles = std::move(read.triangles);
  return mesh;
}

}  // namespace scanmill::bench
