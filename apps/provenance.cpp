#include "apps/provenance.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <ctime>
#include <fstream>
#include <memory>
#include <sstream>

#include "fem/error.hpp"

namespace struna::apps {
namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }

  void add(std::string_view text) { EVP_DigestUpdate(context_.get(), text.data(), text.size()); }

  /// Ends the sum.
  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &size);
    return fmt::format("{:02x}", fmt::join(digest.data(), digest.data() + size, ""));
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

}  // namespace

std::string sha256(std::string_view content) {
  Sha256 sum;
  sum.add(content);
  return sum.hex();
}

std::string sha256_of_file(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  Sha256 sum;
  std::array<char, 65536> buffer{};
  while (in) {
    in.read(buffer.data(), buffer.size());
    sum.add(std::string_view(buffer.data(), static_cast<std::size_t>(in.gcount())));
  }
  if (!in.eof()) throw Error(file, 0, "cannot be read; an existing, readable file is needed");
  return sum.hex();
}

std::string text_of_file(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

ident::Provenance provenance(const std::vector<std::string>& files, double band_lo_hz, double band_hi_hz) {
  ident::Provenance result;
  result.program_version = STRUNA_VERSION;
  result.date = utc_now();
  for (const auto& file : files) result.inputs.emplace_back(file, sha256_of_file(file));
  result.band_lo_hz = band_lo_hz;
  result.band_hi_hz = band_hi_hz;
  return result;
}

}  // namespace struna::apps
