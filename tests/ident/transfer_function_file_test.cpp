#include "ident/transfer_function_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::ident {
namespace {

using testing::HasSubstr;

TransferFunction example(bool with_statistics) {
  TransferFunction tf;
  tf.frequency_hz = Eigen::VectorXd::LinSpaced(200, 0.3, 61.7);
  for (const char* name : {"force_x", "force_re"}) {
    TransferFunction::Output output;
    output.name = name;
    output.kind = FrfKind::dynamic_stiffness;
    output.unit = "N/m";
    output.value = 1e4 * Eigen::VectorXcd::Random(200);
    if (with_statistics) output.coherence = Eigen::VectorXd::Random(200).cwiseAbs();
    if (with_statistics) output.sigma = Eigen::VectorXd::Random(200).cwiseAbs();
    tf.outputs.push_back(output);
  }
  return tf;
}

TEST(TransferFunctionFile, WhatIsWrittenIsReadAgain) {
  const tests::Folder folder;
  const std::string file = (folder / "t.csv").string();
  for (const bool statistics : {false, true}) {
    for (const double decay : {0.0, 4.605170185988091}) {
      TransferFunction tf = example(statistics);
      tf.exponential_decay = decay;
      if (decay > 0.0) tf.leakage_hz = statistics ? 1.0 / 3.0 : 0.0;  // else unknown, without a column
      write_transfer_function(tf, file);
      std::vector<std::string> warnings;
      const TransferFunction again = read_transfer_function(file, &warnings);
      EXPECT_TRUE(warnings.empty());
      EXPECT_EQ(again.exponential_decay, decay);
      EXPECT_EQ(std::isnan(again.leakage_hz), decay == 0.0);
      if (decay > 0.0) {
        EXPECT_EQ(again.leakage_hz, tf.leakage_hz);
      }
      ASSERT_EQ(again.outputs.size(), 2U);
      EXPECT_TRUE(again.frequency_hz.isApprox(tf.frequency_hz, 1e-12));  // thirteen digits
      for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(again.outputs[k].name, tf.outputs[k].name);
        EXPECT_EQ(again.outputs[k].kind, FrfKind::dynamic_stiffness);
        EXPECT_EQ(again.outputs[k].unit, "N/m");
        EXPECT_TRUE(again.outputs[k].value.isApprox(tf.outputs[k].value, 1e-12));
        EXPECT_EQ(again.outputs[k].coherence.size(), tf.outputs[k].coherence.size());
        if (!statistics) continue;
        EXPECT_TRUE(again.outputs[k].coherence.isApprox(tf.outputs[k].coherence, 1e-8));  // nine digits
        EXPECT_TRUE(again.outputs[k].sigma.isApprox(tf.outputs[k].sigma, 1e-8));
      }
    }
  }
}

TEST(TransferFunctionFile, HeadersAreThoseOfTheInterface) {
  const tests::Folder folder;
  const std::string file = (folder / "t.csv").string();
  TransferFunction tf = example(true);
  tf.outputs.resize(1);
  write_transfer_function(tf, file);
  const std::string text = tests::read_text(file);
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "frequency [Hz],force_x_re [N/m],force_x_im [N/m],force_x_coherence [-],force_x_sigma [N/m]");
}

TEST(TransferFunctionFile, AnUnknownUnitIsCarriedThroughWithAWarning) {
  // The analyser's export: bare columns, a unit of its own, and a column that is none of ours.
  const std::string file = std::string(STRUNA_SOURCE_DIR) + "/sample_data/slater/case1_frf.csv";
  std::vector<std::string> warnings;
  const TransferFunction tf = read_transfer_function(file, &warnings);
  ASSERT_EQ(tf.outputs.size(), 1U);
  EXPECT_EQ(tf.outputs[0].name, "output");
  EXPECT_EQ(tf.outputs[0].kind, FrfKind::unknown);
  EXPECT_EQ(tf.outputs[0].unit, "chan2/chan1");
  EXPECT_EQ(tf.outputs[0].coherence.size(), 0);
  EXPECT_EQ(tf.lines(), 1600);
  EXPECT_EQ(tf.outputs[0].value[0], std::complex<double>(-64.263557, -37.058292));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr("chan2/chan1"));
  const tests::Folder folder;
  write_transfer_function(tf, (folder / "copy.csv").string());
  EXPECT_EQ(read_transfer_function((folder / "copy.csv").string()).outputs[0].unit, "chan2/chan1");
}

TEST(TransferFunctionFile, FaultsAreNamedWithFileAndLine) {
  const tests::Folder folder;
  struct Fault {
    const char* content;
    const char* message;
  };
  const Fault faults[] = {
      {"", "f.csv:1: no header row"},
      {"frequency [Hz],x\n1,2\n", "f.csv:1: no transfer function"},
      {"frequency [Hz],re [N/m]\n1,2\n", "f.csv:1: no column 'im'"},
      {"frequency [Hz],a_re [N/m]\n1,2\n", "f.csv:1: no column 'a_im'"},
      {"re [N/m],im [N/m]\n1,2\n", "f.csv:1: no column 'frequency'"},
      {"frequency [rad/s],re [N/m],im [N/m]\n1,2,3\n", "f.csv:1: the unit of frequency is 'rad/s'"},
      {"frequency [Hz],re [N/m],im [kg]\n1,2,3\n", "f.csv:1: column 'im' has the unit 'kg'"},
      {"frequency [Hz],re [N/m],im [N/m],sigma [kg]\n1,2,3,4\n", "f.csv:1: column 'sigma' has the unit 'kg'"},
      {"frequency [Hz],re [N/m],im [N/m]\n", "f.csv: has no lines"},
      {"frequency [Hz],re [N/m],im [N/m]\n1,2,3\n1,2,3\n", "f.csv:3: frequency 1 Hz follows 1 Hz"},
      {"frequency [Hz],re [N/m],im [N/m]\n-1,2,3\n", "f.csv:2: frequency -1 Hz is negative"},
      {"frequency [Hz],re [N/m],im [N/m]\n1,2,nan\n", "f.csv:2: column 'im' holds 'nan'"},
      {"frequency [Hz],re [N/m],im [N/m]\n1,2\n", "f.csv:2: 2 fields"},
      {"frequency [Hz],re [N/m],im [N/m],coherence [-]\n1,2,3,1.22\n", "f.csv:2: coherence is 1.22"},
      {"frequency [Hz],re [N/m],im [N/m],sigma [N/m]\n1,2,3,-1\n", "f.csv:2: sigma is -1"},
      {"frequency [Hz],re [N/m],im [N/m],exponential_decay [1/s]\n1,2,3,4\n2,2,3,5\n",
       "f.csv:3: exponential_decay is 5"},
      {"frequency [Hz],re [N/m],im [N/m],leakage [Hz]\n1,2,3,0\n2,2,3,5\n", "f.csv:3: leakage is 5"},
      {"frequency [Hz],re [N/m],im [N/m],leakage [Hz]\n1,2,3,-1\n", "f.csv:2: leakage is -1"},
      {"frequency [Hz],re [N/m],im [N/m],leakage [mHz]\n1,2,3,1\n",
       "f.csv:1: the unit of leakage is 'mHz': it must be Hz"},
  };
  for (const Fault& fault : faults) {
    try {
      read_transfer_function(folder.write("f.csv", fault.content));
      ADD_FAILURE() << fault.content;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(fault.message)) << fault.content;
    }
  }
}

TEST(TransferFunctionFile, WhatIsNotFiniteIsNotWritten) {
  const tests::Folder folder;
  TransferFunction tf = example(true);
  tf.outputs[1].value[7] = NAN;
  EXPECT_THROW(write_transfer_function(tf, (folder / "t.csv").string()), Error);
  tf = example(true);
  tf.outputs[0].sigma[7] = INFINITY;
  EXPECT_THROW(write_transfer_function(tf, (folder / "t.csv").string()), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv"));
}

}  // namespace
}  // namespace struna::ident
