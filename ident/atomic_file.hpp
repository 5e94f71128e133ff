#pragma once

#include <string>
#include <string_view>

namespace struna::ident {

/// Writes `content` to a file beside `path` and renames it over `path`: a failed run leaves no half file.
/// Throws Error naming the path and the system's reason.
void write_atomically(const std::string& path, std::string_view content);

}  // namespace struna::ident
