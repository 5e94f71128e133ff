#include "ident/stabilisation_file.hpp"

#include <gtest/gtest.h>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::ident {
namespace {

TEST(StabilisationFile, HasARowForEveryPole) {
  const tests::Folder folder;
  Stabilisation found;
  found.poles = {{1, {99.5, 0.03}, {}, Stability::fresh, -1}, {2, {100.25, 0.02}, {}, Stability::all, 0}};
  write_stabilisation(found, (folder / "poles.csv").string());
  EXPECT_EQ(tests::read_text(folder / "poles.csv"),
            "order [-],natural_frequency [Hz],loss_factor [-],stability,column\n"
            "1,99.5,0.03,new,\n"
            "2,100.25,0.02,all,1\n");
}

TEST(StabilisationFile, CannotBeWrittenIntoAFolderThatIsNotThere) {
  const tests::Folder folder;
  EXPECT_THROW(write_stabilisation({}, (folder / "no/poles.csv").string()), Error);
}

}  // namespace
}  // namespace struna::ident
