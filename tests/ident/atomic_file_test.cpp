#include "ident/atomic_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::ident {
namespace {

long files_in(const tests::Folder& folder) {
  return std::distance(std::filesystem::directory_iterator(folder.path()),
                       std::filesystem::directory_iterator());
}

TEST(AtomicFile, ReplacesTheContentAndLeavesNothingElse) {
  const tests::Folder folder;
  const std::string path = folder.write("out.csv", "old");
  write_atomically(path, "new");
  EXPECT_EQ(tests::read_text(path), "new");
  EXPECT_EQ(files_in(folder), 1);
}

TEST(AtomicFile, WritesThroughALink) {
  const tests::Folder folder;
  const std::string path = folder.write("target.csv", "old");
  std::filesystem::create_symlink("target.csv", folder / "link.csv");
  write_atomically((folder / "link.csv").string(), "new");
  EXPECT_EQ(tests::read_text(path), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.csv"));
}

TEST(AtomicFile, AFailedWriteNamesThePathAndLeavesNoHalfFile) {
  const tests::Folder folder;
  std::filesystem::create_directory(folder / "sub");
  for (const std::string& path :
       {(folder / "none" / "out.csv").string(), (folder / "sub").string(), std::string()}) {
    try {
      write_atomically(path, "content");
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(path + ": cannot be written: "));
    }
  }
  EXPECT_EQ(files_in(folder), 1);
}

}  // namespace
}  // namespace struna::ident
