#include "apps/output_folder.hpp"

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "fem/error.hpp"
#include "ident/signals_held.hpp"

namespace struna::apps {
namespace {

namespace fs = std::filesystem;

/// A folder of a name that nobody has, inside `folder`; gone with all its content at the end of the scope.
class StagingFolder {
 public:
  explicit StagingFolder(const fs::path& folder) : path_((folder / ".struna-XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr)
      throw Error(folder.string(), 0, "cannot be written to; a writable folder is needed");
  }
  ~StagingFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// The folders on the way to `folder` that do not exist yet, deepest first.
std::vector<fs::path> missing_folders(fs::path folder) {
  std::vector<fs::path> missing;
  for (; !folder.empty() && !fs::exists(folder); folder = folder.parent_path()) missing.push_back(folder);
  return missing;
}

void remove_empty(const std::vector<fs::path>& folders) {
  std::error_code ignored;
  for (const auto& folder : folders) fs::remove(folder, ignored);
}

}  // namespace

void fill_folder(const std::string& folder, const std::function<void(const std::string& staging)>& write) {
  const ident::SignalsHeld held;
  const fs::path target = fs::path(folder).lexically_normal();
  const std::vector<fs::path> made = missing_folders(target);
  try {
    fs::create_directories(target);
    const StagingFolder staging(target);
    write(staging.path());
    for (const auto& entry : fs::directory_iterator(staging.path())) {
      fs::rename(entry.path(), target / entry.path().filename());
    }
  } catch (const fs::filesystem_error& fault) {
    remove_empty(made);
    throw Error(folder, 0,
                "cannot be written to: " + fault.code().message() + "; a writable folder is needed");
  } catch (...) {
    remove_empty(made);
    throw;
  }
}

void check_folder(const std::string& folder) {
  std::error_code ignored;
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored)) {
    throw Error(folder, 0, "is a file; a folder, or the name of a new one, is needed");
  }
}

}  // namespace struna::apps
