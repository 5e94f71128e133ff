#include "apps/output_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::apps {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> entries(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  return names;
}

void write(const std::string& file, const std::string& text) {
  std::ofstream(file) << text;
}

TEST(OutputFolder, MakesTheFolderAndPutsTheFilesIntoIt) {
  const tests::Folder folder;
  fill_folder((folder / "a/b").string(), [](const std::string& staging) {
    write(staging + "/one", "1");
    write(staging + "/two", "2");
  });
  EXPECT_THAT(entries(folder / "a/b"), testing::UnorderedElementsAre("one", "two"));
  EXPECT_EQ(tests::read_text(folder / "a/b/one"), "1");
}

TEST(OutputFolder, ReplacesItsOwnFilesAndLeavesOthersAlone) {
  const tests::Folder folder;
  folder.write("one", "old");
  folder.write("other", "kept");
  fill_folder(folder.path().string(), [](const std::string& staging) { write(staging + "/one", "new"); });
  EXPECT_THAT(entries(folder.path()), testing::UnorderedElementsAre("one", "other"));
  EXPECT_EQ(tests::read_text(folder / "one"), "new");
  EXPECT_EQ(tests::read_text(folder / "other"), "kept");
}

TEST(OutputFolder, LeavesNothingBehindWhenTheWriterFails) {
  const tests::Folder folder;
  folder.write("one", "old");
  const auto failing = [](const std::string& staging) {
    write(staging + "/one", "half");
    throw Error("no room");
  };
  EXPECT_THROW(fill_folder(folder.path().string(), failing), Error);
  EXPECT_THAT(entries(folder.path()), testing::ElementsAre("one"));
  EXPECT_EQ(tests::read_text(folder / "one"), "old");
  EXPECT_THROW(fill_folder((folder / "new/deep").string(), failing), Error);
  EXPECT_FALSE(fs::exists(folder / "new"));
}

TEST(OutputFolder, RefusesAPathThroughAFile) {
  const tests::Folder folder;
  const std::string file = folder.write("file", "text");
  EXPECT_THROW(check_folder(file), Error);
  EXPECT_NO_THROW(check_folder((folder / "new").string()));
  EXPECT_NO_THROW(check_folder(folder.path().string()));
  const auto nothing = [](const std::string&) {};
  EXPECT_THROW(fill_folder(file + "/inside", nothing), Error);
  EXPECT_EQ(tests::read_text(file), "text");
}

volatile std::sig_atomic_t interrupted = 0;

TEST(OutputFolder, HoldsAnInterruptBackUntilTheFilesAreInPlace) {
  const tests::Folder folder;
  interrupted = 0;
  auto* before = std::signal(SIGINT, [](int) { interrupted = 1; });
  fill_folder((folder / "out").string(), [](const std::string& staging) {
    std::raise(SIGINT);
    EXPECT_EQ(interrupted, 0);
    write(staging + "/one", "1");
  });
  EXPECT_EQ(interrupted, 1);
  std::signal(SIGINT, before);
  EXPECT_THAT(entries(folder / "out"), testing::ElementsAre("one"));
}

}  // namespace
}  // namespace struna::apps
