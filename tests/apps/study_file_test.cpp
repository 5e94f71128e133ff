#include "apps/study_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::apps {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string least = R"(scene = "scene.toml"
records = ["a.csv", "../b.csv"]
input = "displacement"
outputs = ["force_x", "force_y"]
)";

std::string fault_of(const std::string& text) {
  const tests::Folder folder;
  try {
    read_study(folder.write("s.toml", text));
  } catch (const Error& error) {
    const std::string message = error.what();
    return message.substr(message.find("s.toml"));
  }
  return "no error";
}

TEST(StudyFile, PathsAreRelativeToTheStudy) {
  const tests::Folder folder;
  const Study study = read_study(folder.write("s.toml", least));
  EXPECT_EQ(study.scene, (folder / "scene.toml").string());
  EXPECT_THAT(study.records,
              ElementsAre((folder / "a.csv").string(), (folder.path().parent_path() / "b.csv").string()));
  EXPECT_EQ(study.input, "displacement");
  EXPECT_THAT(study.outputs, ElementsAre("force_x", "force_y"));
}

TEST(StudyFile, WhatIsLeftOutHasItsDefault) {
  const tests::Folder folder;
  const Study study = read_study(folder.write("s.toml", least));
  EXPECT_EQ(study.transfer.estimator, ident::Estimator::h1);
  EXPECT_FALSE(study.transfer.form.has_value());
  EXPECT_FALSE(study.transfer.band.has_value());
  EXPECT_EQ(study.transfer.welch.resolution_hz, 0.0);
  EXPECT_EQ(study.modes.method, ident::ModeMethod::automatic);
  EXPECT_EQ(study.modes.damping, fem::Damping::structural);
  EXPECT_EQ(study.fit.modulus_law, "");
  EXPECT_EQ(study.compare.hi_hz, 0.0);
  EXPECT_TRUE(study.corrections.empty());
}

TEST(StudyFile, ReadsEveryOption) {
  const tests::Folder folder;
  const Study study = read_study(folder.write("s.toml", least + R"([channel.force_x]
sensitivity = 0.98
sign = -1
delay = 1e-4
unit = "kN"
[transfer]
estimator = "h2"
form = "apparent-mass"
resolution = 0.5
overlap = 0.75
window = "exponential"
exponential_end = 0.05
impact = true
band = [10, 900]
[modes]
method = "circle"
damping = "viscous"
band = "20:800"
frequencies = [100, 200]
[fit]
band = [30, 700]
modulus_law = "power"
loss_factor_law = "constant"
modulus_range = [5e10, 2e11]
[compare]
band = [40, 600]
)"));
  const ident::ChannelCorrection& force = study.corrections.at("force_x");
  EXPECT_EQ(force.sensitivity, 0.98);
  EXPECT_EQ(force.sign, -1.0);
  EXPECT_EQ(force.delay, 1e-4);
  EXPECT_EQ(force.unit, "kN");
  EXPECT_EQ(study.transfer.estimator, ident::Estimator::h2);
  EXPECT_EQ(study.transfer.form, ident::FrfKind::apparent_mass);
  EXPECT_EQ(study.transfer.welch.resolution_hz, 0.5);
  EXPECT_EQ(study.transfer.welch.overlap, 0.75);
  EXPECT_EQ(study.transfer.welch.window, ident::Window::exponential);
  EXPECT_EQ(study.transfer.welch.exponential_end, 0.05);
  EXPECT_TRUE(study.transfer.welch.impact);
  EXPECT_EQ(study.transfer.band->hi_hz, 900.0);
  EXPECT_EQ(study.modes.method, ident::ModeMethod::circle);
  EXPECT_EQ(study.modes.damping, fem::Damping::viscous);
  EXPECT_EQ(study.modes.band_lo_hz, 20.0);
  EXPECT_EQ(study.modes.band_hi_hz, 800.0);
  EXPECT_THAT(study.modes.frequencies_hz, ElementsAre(100.0, 200.0));
  EXPECT_EQ(study.fit.band_lo_hz, 30.0);
  EXPECT_EQ(study.fit.band_hi_hz, 700.0);
  EXPECT_EQ(study.fit.modulus_law, "power");
  EXPECT_EQ(study.fit.loss_factor_law, "constant");
  EXPECT_EQ(study.fit.pairing.modulus_lo, 5e10);
  EXPECT_EQ(study.fit.pairing.modulus_hi, 2e11);
  EXPECT_EQ(study.compare.lo_hz, 40.0);
  EXPECT_EQ(study.compare.hi_hz, 600.0);
  const Study extra = read_study(folder.write("e.toml", least + "[modes]\nadd = [50]\n"));
  EXPECT_THAT(extra.modes.extra_hz, ElementsAre(50.0));
  const Study plain = read_study(folder.write("p.toml", least + "[transfer]\nform = \"as-measured\"\n"));
  EXPECT_FALSE(plain.transfer.form.has_value());
}

TEST(StudyFile, RefusesWhatIsWrongWithFileAndLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "s.toml: scene is missing and must be given"},
      {"scene = \"s\"\nrecords = []\ninput = \"a\"\noutputs = [\"b\"]\n",
       "s.toml:2: records must name at least one"},
      {"scene = \"s\"\nrecords = \"r.csv\"\n", "s.toml:2: records must be an array of texts"},
      {"scene = \"s\"\nrecords = [\"r\"]\ninput = \"a\"\noutputs = []\n",
       "s.toml:4: outputs must name at least one"},
      {"scene = \"s\"\nrecords = [\"r\"]\ninput = \"a\"\noutputs = [\"a\"]\n",
       "s.toml:4: outputs must not hold the in"},
      {"scene = \"s\"\nrecords = [\"r\"]\ninput = \"a\"\noutputs = [\"b\", \"b\"]\n",
       "s.toml:4: outputs names 'b'"},
      {least + "[transfers]\n", "s.toml:5: transfers is not a known key; did you mean 'transfer'?"},
      {least + "[transfer]\nresolution = 0\n", "s.toml:6: transfer.resolution must be > 0"},
      {least + "[transfer]\nestimator = \"h3\"\n", "s.toml:6: transfer.estimator is not understood"},
      {least + "[transfer]\nform = \"stiffness\"\n", "s.toml:6: transfer.form is not understood"},
      {least + "[transfer]\noverlap = 1\n", "s.toml:6: transfer.overlap must be a fraction"},
      {least + "[transfer]\nwindow = \"flat\"\n", "s.toml:6: transfer.window is not understood"},
      {least + "[transfer]\nexponential_end = 0.1\n", "s.toml:6: transfer.exponential_end goes with window"},
      {least + "[transfer]\nwindow = \"exponential\"\nexponential_end = 1\n",
       "transfer.exponential_end must be below"},
      {least + "[transfer]\nimpact = 1\n", "s.toml:6: transfer.impact must be true or false"},
      {least + "[transfer]\nband = [10]\n", "s.toml:6: transfer.band needs [lo, hi]"},
      {least + "[modes]\nmethod = \"best\"\n", "s.toml:6: modes.method is not understood"},
      {least + "[modes]\ndamping = \"dry\"\n", "s.toml:6: modes.damping is not understood"},
      {least + "[modes]\nfrequencies = [0]\n", "s.toml:6: modes.frequencies must hold frequencies above 0"},
      {least + "[modes]\nfrequencies = [1]\nadd = [2]\n", "s.toml:7: modes.add contradicts"},
      {least + "[modes]\nband = \"10-20\"\n", "s.toml:6: modes.band is no band"},
      {least + "[fit]\nmodulus_law = \"linear\"\n",
       "s.toml:6: fit.modulus_law must be one of constant, power"},
      {least + "[fit]\nmodulus_range = [2, 1]\n", "s.toml:6: fit.modulus_range needs [lo, hi] in Pa"},
      {least + "[compare]\nbands = [1, 2]\n",
       "s.toml:6: compare.bands is not a known key; did you mean 'band'?"},
      {least + "[channel.force]\nsign = -1\n", "s.toml:5: channel.force corrects a column that is neither"},
      {least + "[channel.force_x]\nsign = 2\n", "s.toml:6: channel.force_x.sign must be 1 or -1, got 2"},
      {least + "[channel.force_x]\nsensitivity = 0\n",
       "s.toml:6: channel.force_x.sensitivity must not be zero"},
      {least + "[channel.force_x]\nunit = \"stone\"\n", "s.toml:6: channel.force_x.unit is not understood"},
      {least + "[channel.force_x]\ngain = 1\n", "s.toml:6: channel.force_x.gain is not a known key"},
      {least + "[channel]\nforce_x = 1\n", "s.toml:6: channel.force_x must be a table"},
  };
  for (const auto& [text, expected] : cases) EXPECT_THAT(fault_of(text), HasSubstr(expected)) << text;
}

TEST(StudyFile, ReferencesHaveTheirOwnRecordsAndDirections) {
  const tests::Folder folder;
  const Study study = read_study(folder.write("s.toml", R"(scene = "scene.toml"
input = "displacement"
outputs = ["force_x"]
[[reference]]
direction = "y"
records = ["y.csv"]
[[reference]]
direction = [0, 3, 4]
name = "oblique"
input = "displacement_2"
records = ["a.csv", "b.csv"]
[channel.displacement_2]
sign = -1
)"));
  ASSERT_EQ(study.references.size(), 2u);
  EXPECT_EQ(study.references[0].name, "y");
  EXPECT_EQ(study.references[0].input, "displacement");
  EXPECT_EQ(*study.references[0].direction, Eigen::Vector3d::UnitY());
  EXPECT_EQ(study.references[1].name, "oblique");
  EXPECT_EQ(study.references[1].input, "displacement_2");
  EXPECT_LT((*study.references[1].direction - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 1e-12);
  EXPECT_EQ(study.records.size(), 3u);
  EXPECT_EQ(study.input, "displacement");
  EXPECT_EQ(study.corrections.size(), 1u);
}

TEST(StudyFile, FaultyReferencesAreRefused) {
  const std::string head = "scene = \"s\"\noutputs = [\"a\"]\ninput = \"b\"\n[[reference]]\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {head + "records = [\"r\"]\n", "s.toml:4: reference.direction"},
      {head + "direction = \"y\"\n", "s.toml:4: reference.records"},
      {head + "direction = \"y\"\nrecords = []\n", "s.toml:6: reference.records must name at least one"},
      {head + "direction = \"w\"\nrecords = [\"r\"]\n", "s.toml:5: reference.direction must be \"x\""},
      {head + "direction = [0, 1, 1]\nrecords = [\"r\"]\n", "reference.name is needed where"},
      {head + "direction = \"y\"\nrecords = [\"r\"]\nrecord = 1\n",
       "s.toml:7: reference.record is not a known"},
      {"records = [\"r\"]\n" + head + "direction = \"y\"\nrecords = [\"r\"]\n",
       "s.toml:1: records contradicts [[reference]]"},
      {head + "direction = \"y\"\nrecords = [\"r\"]\ninput = \"a\"\n", "outputs must not hold the input 'a'"},
  };
  for (const auto& [text, expected] : cases) EXPECT_THAT(fault_of(text), HasSubstr(expected)) << text;
}

}  // namespace
}  // namespace struna::apps
