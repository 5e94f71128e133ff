#include "apps/body_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "apps/scene_file.hpp"
#include "fem/eigenmodes.hpp"
#include "tests/folder.hpp"

namespace struna::apps {
namespace {

const std::string head = "[[body]]\nname = \"wire\"\npoints = [[0,0,0], [0.68,0,0]]\n";
const std::string round_wire = "diameter = 0.0032\ndensity = 7650\n";

fem::Body body_of(const std::string& lines) {
  const tests::Folder folder;
  return read_scene(folder.write("s.toml", head + lines)).bodies.at(0);
}

std::string fault_of(const std::string& lines) {
  try {
    body_of(lines);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

const fem::BodyNumber& stated(const fem::Body& body, const std::string& name) {
  for (const fem::BodyNumber& number : body.stated) {
    if (number.name == name) return number;
  }
  throw Error("not stated: " + name);
}

TEST(BodyTable, SigmasStandBesideTheirNumbers) {
  const fem::Body body = body_of(round_wire +
                                 "diameter_sigma = 1e-5\nlength_sigma = 1e-3\ndensity_sigma = 40\n"
                                 "poisson_sigma = 0.02\n");
  EXPECT_EQ(stated(body, "diameter").sigma, 1e-5);
  EXPECT_EQ(stated(body, "length").sigma, 1e-3);
  EXPECT_NEAR(stated(body, "length").value, 0.68, 1e-12);
  EXPECT_EQ(stated(body, "density").sigma, 40.0);
  EXPECT_EQ(stated(body, "poisson").sigma, 0.02);
  // A solid circle: dA = 2 A/d, dI = 4 I/d, dJ = 4 J/d.
  const fem::Section& slope = stated(body, "diameter").section;
  EXPECT_NEAR(slope.area * 0.0032 / body.section.area, 2.0, 1e-8);
  EXPECT_NEAR(slope.second_moment * 0.0032 / body.section.second_moment, 4.0, 1e-8);
  EXPECT_NEAR(slope.torsion_constant * 0.0032 / body.section.torsion_constant, 4.0, 1e-8);
  EXPECT_EQ(stated(body_of(round_wire), "diameter").sigma, 0.0);
}

TEST(BodyTable, WhatIsStatedItselfDoesNotFollowTheDiameter) {
  const fem::Body body = body_of(round_wire +
                                 "second_moment = 3.1083e-12\nsecond_moment_sigma = 1e-13\n"
                                 "torsion_constant = 5e-12\ntorsion_constant_sigma = 1e-12\n");
  EXPECT_EQ(stated(body, "diameter").section.second_moment, 0.0);
  EXPECT_NEAR(stated(body, "second_moment").section.second_moment, 1.0, 1e-9);
  EXPECT_EQ(stated(body, "second_moment").section.torsion_constant, 0.0);
  EXPECT_NEAR(stated(body, "torsion_constant").section.torsion_constant, 1.0, 1e-9);
  const fem::Body strand = body_of(round_wire + "second_moment = 3.1083e-12\n");
  EXPECT_NEAR(stated(strand, "second_moment").section.torsion_constant, 2.0, 1e-9);
  const fem::Body tube = body_of(
      "outer_diameter = 0.0095\ninner_diameter = 0.0035\ndensity = 4535\ninner_diameter_sigma = 1e-5\n");
  EXPECT_NEAR(stated(tube, "inner_diameter").section.area, -M_PI / 2.0 * 0.0035, 1e-9);
}

TEST(BodyTable, EndsMayGive) {
  const std::string steel = "[body.material]\nyoungs_modulus = 1e11\n";
  const fem::Body body = body_of(
      round_wire +
      "start = { rotation = 40, rotation_sigma = 4, mass = 0.01 }\nend = { translation = 1e5 }\n" + steel);
  EXPECT_EQ(body.start, fem::EndCondition::clamped);
  EXPECT_EQ(body.start_support.rotation, 40.0);
  EXPECT_EQ(body.start_support.mass, 0.01);
  EXPECT_TRUE(std::isinf(body.start_support.translation));
  EXPECT_EQ(body.end_support.translation, 1e5);
  EXPECT_TRUE(std::isinf(body.end_support.rotation));
  EXPECT_EQ(stated(body, "start.rotation").sigma, 4.0);
  EXPECT_EQ(stated(body, "end.translation").sigma, 0.0);
  const fem::Body pinned = body_of(
      round_wire + "start = { rotation = 0 }\nend = { translation = 0, rotation = 0, mass = 0.02 }\n");
  EXPECT_EQ(pinned.start, fem::EndCondition::pinned);
  EXPECT_FALSE(pinned.start_support.gives());
  EXPECT_EQ(pinned.end, fem::EndCondition::free);
  EXPECT_EQ(pinned.end_support.mass, 0.02);
  EXPECT_EQ(body_of(round_wire + "start = {}\n").start, fem::EndCondition::clamped);
}

TEST(BodyTable, RefusesWhatContradicts) {
  const struct {
    std::string lines, part;
  } cases[] = {
      {"diameter_sigma = 0.002\n", "s.toml:6: body.diameter_sigma must be below half"},
      {"diameter_sigma = -1\n", "diameter_sigma"},
      {"second_moment_sigma = 1e-14\n", "needs second_moment beside it"},
      {"torsion_constant_sigma = 1e-14\n", "needs torsion_constant beside it"},
      {"outer_diameter_sigma = 1e-5\n", "needs outer_diameter beside it"},
      {"densty_sigma = 1\n", "densty_sigma"},
      {"start = { rotation_sigma = 1 }\n", "needs rotation beside it"},
      {"start = { rotatoin = 1 }\n", "rotatoin"},
      {"start = { rotation = -1 }\n", "rotation"},
      {"start = { translation = 0 }\n", "rotation = 0 too"},
      {"start = { translation = 0, rotation = 3 }\n", "rotation = 0 too"},
      {"start = \"loose\"\n", "loose"},
  };
  for (const auto& c : cases)
    EXPECT_NE(fault_of(round_wire + c.lines).find(c.part), std::string::npos)
        << c.lines << fault_of(round_wire + c.lines);
}

}  // namespace
}  // namespace struna::apps
