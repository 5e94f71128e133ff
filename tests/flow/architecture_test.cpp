// Dependencies point one way, apps -> ident -> fem -> Eigen, and every other library has its home in .cpp
// files. CMake lists stand in data order: a header includes only those of stems above its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>

#include "tests/folder.hpp"

namespace struna::tests {
namespace {

namespace fs = std::filesystem;

const fs::path root = STRUNA_SOURCE_DIR;

/// Sources of a room, as "ident/csv.cpp".
std::vector<std::string> sources_of(const std::string& room) {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(root / room)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".cpp" || extension == ".hpp")
      files.push_back(room + "/" + entry.path().filename().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> includes_of(const std::string& file) {
  static const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  std::vector<std::string> names;
  std::ifstream in(root / file);
  for (std::string line; std::getline(in, line);) {
    std::smatch match;
    if (std::regex_search(line, match, include)) names.push_back(match[1]);
  }
  return names;
}

bool begins_with(const std::string& text, const std::string& start) {
  return text.rfind(start, 0) == 0;
}

TEST(Architecture, DependenciesPointOneWay) {
  const std::map<std::string, std::vector<std::string>> forbidden = {
      {"fem", {"ident/", "apps/", "tests/"}}, {"ident", {"apps/", "tests/"}}, {"apps", {"tests/"}}};
  for (const auto& [room, rooms] : forbidden) {
    const auto files = sources_of(room);
    EXPECT_GT(files.size(), 10U) << room;
    for (const auto& file : files) {
      for (const auto& include : includes_of(file)) {
        for (const auto& other : rooms)
          EXPECT_FALSE(begins_with(include, other)) << file << " includes " << include;
      }
    }
  }
}

/// Which files may include a library's headers.
struct Home {
  std::string header;  ///< how the include begins
  std::vector<std::string> rooms;
  bool in_headers = false;
};

TEST(Architecture, EveryLibraryHasItsHome) {
  const std::vector<Home> homes = {{"ceres/", {"ident"}},
                                   {"nlopt", {"ident"}},
                                   {"fftw3", {"ident"}},
                                   {"libfccp/", {"ident"}},
                                   {"toml++/", {"ident", "apps"}},
                                   {"nlohmann/json.hpp", {"apps"}},
                                   {"fmt/", {"fem", "ident", "apps"}},
                                   {"CLI/", {"apps"}, true}};
  // The one header that hands TOML nodes on; it belongs to the command line, not to a library.
  const std::set<std::string> excepted = {"apps/toml_table.hpp"};
  std::map<std::string, int> uses;
  for (const std::string room : {"fem", "ident", "apps"}) {
    for (const auto& file : sources_of(room)) {
      for (const auto& include : includes_of(file)) {
        for (const auto& home : homes) {
          if (!begins_with(include, home.header)) continue;
          ++uses[home.header];
          const bool at_home = std::count(home.rooms.begin(), home.rooms.end(), room) > 0;
          EXPECT_TRUE(at_home) << file << " includes " << include;
          const bool in_header = file.back() == 'p' && file[file.size() - 3] == 'h';
          EXPECT_TRUE(!in_header || home.in_headers || excepted.count(file) > 0)
              << file << " includes " << include;
        }
      }
    }
  }
  for (const auto& home : homes) {
    EXPECT_GT(uses[home.header], 0) << home.header << " is not used: drop it";
  }
}

TEST(Architecture, HeadersOfTheLibrariesHoldNoDecompositions) {
  for (const std::string room : {"fem", "ident"}) {
    for (const auto& file : sources_of(room)) {
      if (file.substr(file.size() - 4) != ".hpp") continue;
      for (const auto& include : includes_of(file)) {
        for (const char* heavy : {"Eigen/Dense", "Eigen/Eigenvalues", "Eigen/SVD", "Eigen/QR", "Eigen/LU",
                                  "Eigen/Cholesky", "Eigen/Sparse"}) {
          EXPECT_NE(include, heavy) << file;
        }
      }
    }
  }
}

/// The .cpp files of a room's library, in the order of its CMake list.
std::vector<std::string> listed_in_cmake(const std::string& room) {
  const std::string text = read_text(root / room / "CMakeLists.txt");
  const std::size_t begin = text.find("add_library(");
  const std::string list = text.substr(begin, text.find(')', begin) - begin);
  static const std::regex source(R"((\w+)\.cpp)");
  std::vector<std::string> stems;
  for (std::sregex_iterator match(list.begin(), list.end(), source), end; match != end; ++match) {
    stems.push_back((*match)[1]);
  }
  return stems;
}

TEST(Architecture, ListsInCMakeStandInDataOrder) {
  for (const std::string room : {"fem", "ident"}) {
    const auto stems = listed_in_cmake(room);
    EXPECT_GT(stems.size(), 8U) << room;
    for (const auto& file : sources_of(room)) {
      const auto own = std::find(stems.begin(), stems.end(), fs::path(file).stem().string());
      if (own == stems.end()) {  // a header without a .cpp
        EXPECT_EQ(fs::path(file).extension(), ".hpp") << file << " is not in " << room << "/CMakeLists.txt";
        continue;
      }
      if (fs::path(file).extension() != ".hpp") continue;
      for (const auto& include : includes_of(file)) {
        if (!begins_with(include, room + "/")) continue;
        const auto used = std::find(stems.begin(), stems.end(), fs::path(include).stem().string());
        EXPECT_TRUE(used == stems.end() || used <= own)
            << file << " includes " << include << ", which is listed below it";
      }
    }
  }
}

}  // namespace
}  // namespace struna::tests
