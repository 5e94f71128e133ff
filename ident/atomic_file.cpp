#include "ident/atomic_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "fem/error.hpp"
#include "ident/signals_held.hpp"

namespace struna::ident {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw Error(path, 0, "cannot be written: " + reason);
}

void write_plainly(const fs::path& path, const std::string& shown, std::string_view content) {
  errno = 0;
  std::ofstream stream(path, std::ios::binary);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (!stream) fail(shown, errno ? std::strerror(errno) : "the stream failed");
}

}  // namespace

void write_atomically(const std::string& path, std::string_view content) {
  std::error_code fault;
  const fs::path target = fs::weakly_canonical(path, fault);  // through a link to the file behind it
  if (fault || path.empty()) fail(path, path.empty() ? "the name is empty" : fault.message());
  const fs::file_status status = fs::status(target, fault);
  if (fs::is_directory(status)) fail(path, "is a folder");
  if (fs::exists(status) && !fs::is_regular_file(status))
    return write_plainly(target, path, content);  // a pipe or terminal

  const fs::path part =
      target.parent_path() / fmt::format(".{}.{}.part", target.filename().string(), ::getpid());
  const SignalsHeld held;
  try {
    write_plainly(part, path, content);
  } catch (...) {
    fs::remove(part, fault);
    throw;
  }
  fs::rename(part, target, fault);
  if (fault) {
    const std::string reason = fault.message();
    fs::remove(part, fault);
    fail(path, reason);
  }
}

}  // namespace struna::ident
