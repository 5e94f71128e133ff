#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ident/parameter_identification.hpp"

namespace struna::apps {

/// SHA-256 of a text as 64 hexadecimal digits (FIPS 180-4).
std::string sha256(std::string_view content);
/// The same of a file's content, streamed. Throws Error when it cannot be read.
std::string sha256_of_file(const std::string& file);

/// A file's content, as it is.
std::string text_of_file(const std::string& file);

/// This program, now, and these input files with their checksums.
ident::Provenance provenance(const std::vector<std::string>& files, double band_lo_hz, double band_hi_hz);

}  // namespace struna::apps
