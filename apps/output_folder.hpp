#pragma once

#include <functional>
#include <string>

namespace struna::apps {

/// Fills `folder` (made when missing) all or nothing: `write` gets the name of an empty folder inside it and
/// writes its files there; when it has returned they are renamed into place over files of the same name. When
/// it throws, or `folder` cannot be made, nothing is left behind. Signals that end the program (SIGINT,
/// SIGTERM, SIGHUP) wait until it is done.
void fill_folder(const std::string& folder, const std::function<void(const std::string& staging)>& write);

/// Throws Error when `folder` cannot become a folder because a file has its name: told before the work, not
/// after.
void check_folder(const std::string& folder);

}  // namespace struna::apps
