// Scenes run in time, through the program itself: the wire in its band against its records, a random run
// against the harmonic response, faults of input, interruption.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/scene_file.hpp"
#include "fem/harmonic.hpp"
#include "ident/record.hpp"
#include "ident/record_comparison.hpp"
#include "ident/transfer_function_file.hpp"
#include "tests/flow/program.hpp"

namespace struna::tests {
namespace {

/// The banded scene with another duration and another record.
std::string banded_scene(const std::string& duration, const std::string& record, const std::string& column) {
  std::string text = read_text(sample_data("wire_in_band/scene.toml"));
  text = replaced(text, "duration = 7.99", "duration = " + duration);
  text = replaced(text, "\"in_band.csv\"", "\"" + record + "\"");
  return replaced(text, "column = \"displacement\"", "column = \"" + column + "\"");
}

TEST(Simulate, WireInItsBandFollowsItsRecords) {
  const Folder folder;
  const auto record = sample_data("wire_in_band/in_band.csv").string();
  folder.write("scene.toml", banded_scene("7.99", record, "displacement"));
  const auto run = run_struna("simulate scene.toml -o out.csv --contacts contacts.csv", folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("starts with a jump"), std::string::npos) << run.err;
  const auto simulated = ident::read_record((folder / "out.csv").string(), {"displacement", "force_y"});
  const auto measured = ident::read_record(record, {"displacement", "force_y"});
  const long count = simulated.samples.rows();
  ASSERT_EQ(count, 39950);
  // The motion is the record's own, as written with 9 digits, but for its reconstructed start.
  EXPECT_LT(
      (simulated.samples.col(0) - measured.samples.col(0).head(count)).tail(count - 16).cwiseAbs().maxCoeff(),
      1e-11);
  // Sensor noise alone leaves 0.995; twice the step of the independent simulation 0.993.
  const auto force = ident::compare_records(measured, simulated).signals.at(0);
  ASSERT_EQ(force.correlation.size(), 8);
  for (int second = 0; second < 8; ++second) EXPECT_GT(force.correlation[second], 0.985) << second;
  EXPECT_GT(std::filesystem::file_size(folder / "contacts.csv"), 10000u);
}

TEST(Simulate, RandomRunHasTheHarmonicTransferFunctionWithinThreeSigma) {
  const Folder folder;
  std::string text = read_text(sample_data("paper_gap/no_band.toml"));
  text = replaced(text, "duration = 4.0", "duration = 20.0");
  text = replaced(text, "sample_rate = 10000", "sample_rate = 4000");
  folder.write("scene.toml", text);
  ASSERT_EQ(run_struna("simulate scene.toml -o records.csv", folder).exit_code, 0);
  const auto path = fem::linear_path(apps::read_scene((folder / "scene.toml").string()));
  const auto estimated = [&](const std::string& options) {
    const auto frf = run_struna(
        "frf records.csv --input displacement --output force_x --output force_y --output force_z "
        "--band 20:950 --resolution 0.5 -o trfam.csv " +
            options,
        folder);
    EXPECT_EQ(frf.exit_code, 0) << frf.err;
    return ident::read_transfer_function((folder / "trfam.csv").string());
  };
  const auto exact = [&](const ident::TransferFunction& tf) {
    return fem::harmonic_response(fem::assemble(path.body), path.drive, path.measurement, tf.frequency_hz,
                                  {fem::Damping::viscous, false})
        .response;
  };
  const auto welch = estimated("--estimator h1");
  const Eigen::MatrixXcd truth = exact(welch);
  int beyond = 0, lines = 0;
  for (std::size_t k = 0; k < welch.outputs.size(); ++k) {
    const Eigen::VectorXcd error = welch.outputs[k].value - truth.col(static_cast<long>(k));
    for (long i = 0; i < error.size(); ++i, lines += 2) {
      beyond += std::abs(error[i].real()) > 3.0 * welch.outputs[k].sigma[i];
      beyond += std::abs(error[i].imag()) > 3.0 * welch.outputs[k].sigma[i];
    }
  }
  // 0.3 % of normal deviates lie beyond; sigma itself comes from some 20 averages, and leakage biases sharp
  // peaks.
  EXPECT_LT(beyond, 0.03 * lines) << beyond << " of " << lines;

  // An estimator that does not leak shows what the simulation itself misses: 1.2e-4 at worst, from the modes
  // that follow statically.
  const auto local = estimated("--estimator local");
  const Eigen::MatrixXcd there = exact(local);
  for (std::size_t k = 0; k < local.outputs.size(); ++k) {
    const Eigen::VectorXcd column = there.col(static_cast<long>(k));
    const Eigen::ArrayXd error =
        (local.outputs[k].value - column).cwiseAbs().array() / column.cwiseAbs().array();
    EXPECT_LT(error.maxCoeff(), 1e-3) << local.outputs[k].name;
  }
}

TEST(Simulate, TellsWhatIsWrongWithARecordInOneLine) {
  const Folder folder;
  std::string good = "time [s],displacement [m],force [N],velocity [m/s]\n";
  for (int i = 0; i < 200; ++i) good += std::to_string(i) + "e-3,1e-6,1,2\n";
  folder.write("good.csv", good);
  folder.write("nan.csv", replaced(good, "100e-3,1e-6", "100e-3,nan"));
  struct Fault {
    const char* duration;
    const char* file;
    const char* column;
    const char* message;
  };
  for (const auto& fault :
       {Fault{"0.1", "nan.csv", "displacement", "nan.csv:102"}, Fault{"0.1", "good.csv", "motion", "motion"},
        Fault{"0.1", "good.csv", "velocity", "needs a displacement"},
        Fault{"0.1", "absent.csv", "displacement", "absent.csv"},
        Fault{"5.0", "good.csv", "displacement", "less than the scene's duration"}}) {
    folder.write("scene.toml", banded_scene(fault.duration, fault.file, fault.column));
    const auto run = run_struna("simulate scene.toml -o out.csv", folder);
    EXPECT_EQ(run.exit_code, 1) << fault.message;
    EXPECT_NE(run.err.find(fault.message), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv")) << fault.message;
  }
  EXPECT_EQ(run_struna("simulate scene.toml -o out.csv --method euler", folder).exit_code, 2);
}

TEST(Simulate, InterruptionKeepsWhatWasComputed) {
  const Folder folder;
  std::string text = read_text(sample_data("paper_filter/case_2.toml"));
  folder.write("scene.toml", replaced(text, "duration = 10.0", "duration = 1000.0"));
  const std::string line = "cd '" + folder.path().string() +
                           "' && timeout --foreground --preserve-status -s INT 4 '" STRUNA_PROGRAM
                           "' --quiet simulate scene.toml -o out.csv 2>err.txt";
  const int status = std::system(line.c_str());
  const std::string err = read_text(folder / "err.txt");
  EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 1) << err;
  EXPECT_NE(err.find("interrupted"), std::string::npos) << err;
  const auto record = ident::read_record((folder / "out.csv").string(), {"displacement", "force_y"});
  EXPECT_GT(record.samples.rows(), 1);
  EXPECT_LT(record.samples.rows(), 1000 * 10000);
}

}  // namespace
}  // namespace struna::tests
