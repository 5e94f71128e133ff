#pragma once

#include <string>
#include <vector>

namespace struna::apps {

/// Throws Error when two of the files hold the same bytes: a record averaged with itself tells nothing new,
/// and every sigma would be too small by a factor of sqrt(2).
void refuse_repeated_records(const std::vector<std::string>& files);

}  // namespace struna::apps
