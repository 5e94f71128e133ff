#include "apps/provenance.hpp"

#include <gtest/gtest.h>

#include <regex>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::apps {
namespace {

// FIPS 180-4 examples (NIST CSRC, "SHA-256"), and the text of a million letters a.
TEST(Provenance, Sha256MeetsThePublishedExamples) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Provenance, Sha256OfAFileIsThatOfItsContentForEveryLengthAroundABlock) {
  const tests::Folder folder;
  for (std::size_t length : {0U, 1U, 55U, 56U, 57U, 63U, 64U, 65U, 119U, 120U, 65535U, 65536U, 65537U}) {
    const std::string content(length, 'x');
    EXPECT_EQ(sha256_of_file(folder.write("file", content)), sha256(content)) << length;
  }
}

TEST(Provenance, RefusesWhatCannotBeRead) {
  const tests::Folder folder;
  EXPECT_THROW(sha256_of_file((folder / "absent").string()), Error);
  EXPECT_THROW(sha256_of_file(folder.path().string()), Error);
}

TEST(Provenance, TellsVersionDateAndInputs) {
  const tests::Folder folder;
  const std::string file = folder.write("a.csv", "abc");
  const ident::Provenance told = provenance({file}, 10.0, 900.0);
  EXPECT_EQ(told.program_version, STRUNA_VERSION);
  EXPECT_TRUE(std::regex_match(told.date, std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ)"))) << told.date;
  ASSERT_EQ(told.inputs.size(), 1U);
  EXPECT_EQ(told.inputs[0], std::make_pair(file, sha256("abc")));
  EXPECT_EQ(told.band_lo_hz, 10.0);
  EXPECT_EQ(told.band_hi_hz, 900.0);
}

}  // namespace
}  // namespace struna::apps
