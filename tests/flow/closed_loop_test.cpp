// The point of the whole: what was identified on the bare wire predicts the wire rattling in its band.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "ident/comparison.hpp"
#include "ident/record.hpp"
#include "ident/record_comparison.hpp"
#include "ident/transfer_function_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

using testing::HasSubstr;

TEST(ClosedLoop, IdentifiedBareWirePredictsTheRecordsOfTheWireInItsBand) {
  const Folder folder;
  const std::string data = sample_data("wire_in_band").string();
  const auto identified = run_struna("identify '" + data + "/study.toml' -o id", folder);
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  const auto run =
      run_struna("simulate '" + data + "/scene.toml' --parameters id/identified.toml -o out.csv" +
                     " --against '" + data + "/in_band.csv' --report page.html",
                 folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("correlation per second"));

  const std::vector<std::string> columns = {"displacement", "force_y"};
  const auto measured = ident::read_record(data + "/in_band.csv", columns);
  const auto simulated = ident::read_record((folder / "out.csv").string(), columns);
  const auto comparison = ident::compare_records(measured, simulated);
  const auto& force = comparison.signals.at(0);
  ASSERT_EQ(force.correlation.size(), 8);
  // Sensor noise alone leaves 0.995; the deviations of the identified parameters shift instants of contact.
  for (int second = 0; second < 8; ++second) EXPECT_GT(force.correlation[second], 0.97) << second;
  // 20 to 905 Hz, in eleven bands.
  ASSERT_EQ(force.level_db.size(), 11);
  EXPECT_LT(force.level_db.cwiseAbs().maxCoeff(), 0.5);

  // The transfer functions that `frf` estimates from both. Contact leaves little coherence: coarse lines,
  // Welch's averages.
  for (const std::string& record : {data + "/in_band.csv", std::string("out.csv")}) {
    const std::string to = record == "out.csv" ? "simulated.csv" : "measured.csv";
    const auto frf = run_struna("frf '" + record + "' --input displacement --output force_y --band 20:900" +
                                    " --resolution 4 --estimator h1 -o " + to,
                                folder);
    ASSERT_EQ(frf.exit_code, 0) << frf.err;
  }
  const auto compare = run_struna("compare measured.csv simulated.csv -o comparison.csv", folder);
  ASSERT_EQ(compare.exit_code, 0) << compare.err;
  const auto both = ident::compare(ident::read_transfer_function((folder / "measured.csv").string()),
                                   ident::read_transfer_function((folder / "simulated.csv").string()));
  EXPECT_GT(both.outputs.at(0).frac, 0.99);

  const std::string page = read_text(folder / "page.html");
  for (const char* part : {"\"comparison\":{", "\"penetration\":[[", "\"levelsLinear\":[", "\"energy\":{"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_LT(page.size(), 4u << 20);
}

TEST(ClosedLoop, RefusesARecordThatCannotBeComparedBeforeTheRunInOneLine) {
  const Folder folder;
  std::string slow = "time [s],displacement [m],force_x [N],force_y [N],force_z [N]\n";
  for (int i = 0; i < 3000; ++i) slow += std::to_string(i) + "e-3,0,1,2,3\n";
  folder.write("slow.csv", slow);
  folder.write("less.csv", "time [s],displacement [m]\n0,0\n1e-3,0\n2e-3,0\n");
  const std::string scene = sample_data("paper_gap/no_band.toml").string();
  for (const auto& [file, message] :
       {std::pair{"slow.csv", "same sampling interval"}, std::pair{"less.csv", "force_x"},
        std::pair{"absent.csv", "absent.csv"}}) {
    const auto run = run_struna("simulate '" + scene + "' -o out.csv --against " + file, folder);
    EXPECT_EQ(run.exit_code, 1) << file;
    EXPECT_THAT(run.err, HasSubstr(message));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

}  // namespace
}  // namespace struna::tests
