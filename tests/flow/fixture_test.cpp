// What stands between wire and force cell, through the program.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ident/transfer_function_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

ident::TransferFunction frf(const Folder& folder, const std::string& options, const std::string& to) {
  const auto run = run_struna("frf '" + sample_data("curved_wire/records.csv").string() +
                                  "' --input displacement --output force_y --output force_z --band 20:200 " +
                                  options + " -o " + to,
                              folder);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return ident::read_transfer_function((folder / to).string());
}

TEST(Fixture, AMassOrAnEmptyRunIsTakenOutOfTheForces) {
  const Folder folder;
  const ident::TransferFunction all = frf(folder, "", "all.csv");
  const ident::TransferFunction lighter = frf(folder, "--clamp-mass force_y:0.02", "lighter.csv");
  for (long i = 0; i < all.lines(); i += 100) {
    const double omega = 2.0 * std::numbers::pi * all.frequency_hz[i];
    const std::complex<double> h = all.outputs[0].value[i];
    EXPECT_NEAR(std::abs(lighter.outputs[0].value[i] - h - 0.02 * omega * omega), 0.0,
                1e-9 * std::abs(h) + 1e-6);
    EXPECT_EQ(lighter.outputs[1].value[i], all.outputs[1].value[i]);
  }
  // The run itself as the empty one leaves nothing.
  const ident::TransferFunction nothing =
      frf(folder, "--fixture all.csv --form apparent-mass", "nothing.csv");
  for (const auto& output : nothing.outputs) EXPECT_LT(output.value.cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Fixture, WrongNamesAndMissingBandsAreTold) {
  const Folder folder;
  frf(folder, "", "all.csv");
  const std::string command = "frf '" + sample_data("curved_wire/records.csv").string() +
                              "' --input displacement --output force_y -o out.csv ";
  const auto refused = [&](const std::string& options, int exit_code, const std::string& said) {
    const auto run = run_struna(command + options, folder);
    EXPECT_EQ(run.exit_code, exit_code) << options;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv")) << options;
  };
  refused("--clamp-mass force_z:0.02", 1, "no such output");
  refused("--clamp-mass force_y", 2, "write NAME:KG");
  refused("--fixture all.csv --band 20:300", 1, "the empty run has lines from 20 to 200 Hz");
  refused("--drive-signal voltage", 1, "no column 'voltage'");
  refused("--drive-signal force_z --estimator h2", 1, "leave the drive signal out");
}

}  // namespace
}  // namespace struna::tests
