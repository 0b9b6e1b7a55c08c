// SPDX-License-Identifier: Apache-2.0
// A folder of its own for one test case, removed afterwards; and the place of the development data.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace scanmill::support {

class TempFolder {
 public:
  TempFolder() {
    static int counter = 0;
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = testing::TempDir() + "scanmill-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) +
            (info != nullptr ? std::string("-") + info->name() : "");
    std::filesystem::create_directories(path_);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  void write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories(std::filesystem::path(file(name)).parent_path());
    std::ofstream(file(name), std::ios::binary) << bytes;
  }
  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(file(name), std::ios::binary).rdbuf();
    return text.str();
  }

 private:
  std::string path_;
};

/// Folder of the development data, or empty when it is not there.
inline std::string data_folder() {
  const char* given = std::getenv("SCANMILL_DATA");
  for (const std::string& candidate :
       {std::string(given != nullptr ? given : ""), std::string(SCANMILL_SOURCE_DIR "/../shared/data")})
    if (!candidate.empty() && std::filesystem::is_directory(candidate)) return candidate;
  return {};
}

}  // namespace scanmill::support
