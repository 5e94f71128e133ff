#include "apps/repeated_records.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fem/error.hpp"

namespace struna::apps {
namespace {

namespace fs = std::filesystem;

/// Compares sizes first, then bytes up to the first that differs: different records cost next to nothing.
bool same_content(const std::string& a, const std::string& b) {
  std::error_code fault;
  const bool files = fs::is_regular_file(a, fault) && fs::is_regular_file(b, fault);
  if (!files || fs::file_size(a, fault) != fs::file_size(b, fault)) return false;
  if (fs::equivalent(a, b, fault)) return true;
  std::ifstream in_a(a, std::ios::binary);
  std::ifstream in_b(b, std::ios::binary);
  using Bytes = std::istreambuf_iterator<char>;
  return in_a && in_b && std::equal(Bytes(in_a), Bytes(), Bytes(in_b));
}

}  // namespace

void refuse_repeated_records(const std::vector<std::string>& files) {
  for (std::size_t i = 1; i < files.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (files[i] == files[j]) throw Error(files[i], 0, "is named twice: repeats must be measured anew");
      if (same_content(files[i], files[j]))
        throw Error(
            files[i], 0,
            "holds the same record as " + files[j] + ": repeats must be measured anew; name each once");
    }
  }
}

}  // namespace struna::apps
