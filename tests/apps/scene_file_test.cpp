#include "apps/scene_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "fem/error.hpp"
#include "tests/folder.hpp"

namespace struna::apps {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string body_text = R"([[body]]
name = "wire"
points = [[0,0,0], [0.3,0,0]]
diameter = 0.0032
density = 7650
)";
const std::string band_text = R"([[body]]
name = "band"
points = [[0.1,0,0], [0.2,0,0]]
outer_diameter = 0.0095
inner_diameter = 0.0035
density = 4535
end = "free"
)";

fem::Scene scene_of(const std::string& text) {
  const tests::Folder folder;
  return read_scene(folder.write("s.toml", text));
}

/// The message after the folder's name: "s.toml:7: …".
std::string fault_of(const std::string& text) {
  try {
    scene_of(text);
  } catch (const Error& error) {
    const std::string message = error.what();
    return message.substr(message.find("s.toml"));
  }
  return "no error";
}

/// The body's text with one line put in the place of the key's own (or added at the end).
std::string with(const std::string& key, const std::string& line) {
  const std::size_t at = body_text.find("\n" + key + " ");
  if (at == std::string::npos) return body_text + line + "\n";
  const std::size_t end = body_text.find('\n', at + 1);
  return body_text.substr(0, at + 1) + line + body_text.substr(end);
}

TEST(SceneFile, ReadsEveryKeyOfABody) {
  const fem::Scene scene = scene_of(R"([[body]]
name = "wire"
points = [[0,0,0],[0.18,0.06,0.01],[0.36,0.02,0.09]]
length = 0.68
diameter = 0.0032
second_moment = 3.1083e-12
density = 7650
poisson = 0.25
elements = 30
start = "pinned"
end = "free"
  [body.material]
  youngs_modulus = { frequency = [10, 1000], value = [100e9, 110e9] }
  loss_factor = 0.03
  rayleigh = { alpha = 43.1, beta = 2e-6 }
  damping = "viscous"
)");
  ASSERT_EQ(scene.bodies.size(), 1U);
  const fem::Body& body = scene.bodies[0];
  EXPECT_EQ(body.name, "wire");
  EXPECT_NEAR(body.centreline.length(), 0.68, 1e-9);  // quadrature of the spline's arc length
  EXPECT_DOUBLE_EQ(body.section.area, std::numbers::pi / 4 * 0.0032 * 0.0032);
  EXPECT_EQ(body.section.second_moment, 3.1083e-12);
  EXPECT_EQ(body.section.torsion_constant, 2 * 3.1083e-12);
  EXPECT_EQ(body.density, 7650);
  EXPECT_EQ(body.poisson, 0.25);
  EXPECT_EQ(body.elements, 30);
  EXPECT_EQ(body.start, fem::EndCondition::pinned);
  EXPECT_EQ(body.end, fem::EndCondition::free);
  EXPECT_DOUBLE_EQ(body.material.youngs_modulus.at(505), 105e9);
  EXPECT_EQ(body.material.loss_factor.at(50), 0.03);
  EXPECT_EQ(body.material.rayleigh.alpha, 43.1);
  EXPECT_EQ(body.material.rayleigh.beta, 2e-6);
  EXPECT_EQ(body.material.damping, fem::Damping::viscous);
}

TEST(SceneFile, WhatIsLeftOutHasItsDefault) {
  const fem::Body body = scene_of(body_text).bodies.at(0);
  EXPECT_EQ(body.poisson, 0.3);
  EXPECT_EQ(body.elements, 0);
  EXPECT_EQ(body.start, fem::EndCondition::clamped);
  EXPECT_EQ(body.end, fem::EndCondition::clamped);
  EXPECT_EQ(body.material.damping, fem::Damping::structural);
  EXPECT_EQ(body.material.loss_factor.at(10), 0.0);
  EXPECT_FALSE(has_modulus(body));
  EXPECT_THROW(require_modulus(body, "s.toml"), Error);
  EXPECT_EQ(scene_of(body_text + "[body.material]\nrayleigh = { alpha = 1 }\n").bodies[0].material.damping,
            fem::Damping::viscous);
  const fem::Body known = scene_of(body_text + "[body.material]\nyoungs_modulus = 1e11\n").bodies[0];
  EXPECT_TRUE(has_modulus(known));
  EXPECT_NO_THROW(require_modulus(known, "s.toml"));
}

TEST(SceneFile, DampingMayActThatIsStillToBeIdentified) {
  for (const auto damping : {fem::Damping::structural, fem::Damping::viscous}) {
    const std::string text = body_text + "[body.material]\ndamping = \"" + fem::to_string(damping) + "\"\n";
    EXPECT_EQ(scene_of(text).bodies[0].material.damping, damping);
  }
}

TEST(SceneFile, CrossSectionIsGivenInThreeWays) {
  const auto section = [](const std::string& lines) {
    return scene_of(with("diameter", lines)).bodies.at(0).section;
  };
  const double pi = std::numbers::pi;
  EXPECT_DOUBLE_EQ(section("diameter = 0.002").second_moment, pi / 64 * std::pow(0.002, 4));
  EXPECT_DOUBLE_EQ(section("outer_diameter = 0.0095\ninner_diameter = 0.0035").second_moment,
                   pi / 64 * (std::pow(0.0095, 4) - std::pow(0.0035, 4)));
  const fem::Section own = section("area = 8e-6\nsecond_moment = 3e-12\ntorsion_constant = 5e-12");
  EXPECT_EQ(own.area, 8e-6);
  EXPECT_EQ(own.second_moment, 3e-12);
  EXPECT_EQ(own.torsion_constant, 5e-12);
  EXPECT_EQ(section("area = 8e-6\nsecond_moment = 3e-12").torsion_constant, 6e-12);
}

TEST(SceneFile, ReadsDriveAndMeasurementAtSupports) {
  const fem::Scene scene = scene_of(body_text + band_text + R"([drive]
support = "wire.start"
direction = [0, 3, 4]
also = ["band.start"]
[measure]
support = "wire.end"
directions = ["x", [0, 0, 2], [1, 1, 0]]
)");
  EXPECT_EQ(std::get<fem::Support>(scene.drive->at).body, "wire");
  EXPECT_EQ(std::get<fem::Support>(scene.drive->at).end, fem::End::start);
  EXPECT_TRUE(scene.drive->direction.isApprox(Eigen::Vector3d(0, 0.6, 0.8)));
  ASSERT_EQ(scene.drive->also.size(), 1U);
  EXPECT_EQ(scene.drive->also[0].body, "band");
  EXPECT_THAT(scene.measurement->names, ElementsAre("force_x", "force_z", "force_3"));
  EXPECT_DOUBLE_EQ(scene.measurement->directions[2].norm(), 1.0);
}

TEST(SceneFile, ReadsDriveAndMeasurementAtPoints) {
  const fem::Scene scene = scene_of(body_text + R"([drive]
point = "wire@0.25"
direction = "z"
[measure]
point = "wire@1"
quantity = "velocity"
directions = ["y"]
)");
  EXPECT_EQ(std::get<fem::BodyPoint>(scene.drive->at).fraction, 0.25);
  EXPECT_EQ(std::get<fem::BodyPoint>(scene.measurement->at).fraction, 1.0);
  EXPECT_EQ(scene.measurement->quantity, fem::MotionQuantity::velocity);
  EXPECT_THAT(scene.measurement->names, ElementsAre("velocity_y"));
}

TEST(SceneFile, ReadsEveryContactLaw) {
  const std::pair<std::string, fem::ContactLaw> laws[] = {{"approach", fem::ContactLaw::approach},
                                                          {"no_adhesion", fem::ContactLaw::no_adhesion},
                                                          {"hunt_crossley", fem::ContactLaw::hunt_crossley},
                                                          {"hard_stop", fem::ContactLaw::hard_stop}};
  const std::string contact =
      "[[contact]]\ninside = \"wire\"\noutside = \"band\"\ngap = 1e-4\nstiffness = 1e5\n";
  for (const auto& [word, law] : laws) {
    EXPECT_EQ(scene_of(body_text + band_text + contact + "law = \"" + word + "\"\n").contacts[0].law, law);
  }
  const fem::Scene stop =
      scene_of(body_text + band_text + contact + "law = \"hard_stop\"\nrestitution = 0.4\n");
  EXPECT_EQ(stop.contacts[0].restitution, 0.4);
}

TEST(SceneFile, ReadsContactAndSimulation) {
  const fem::Scene scene = scene_of(body_text + band_text + R"([[contact]]
inside = "wire"
outside = "band"
gap = 1.5e-4
stiffness = 1e5
damping = 100
law = "hunt_crossley"
[simulation]
duration = 2.0
excitation = { kind = "random", band = [10, 1000], rms_acceleration = 20, seed = 7 }
gravity = [0, 0, -9.81]
tolerance = 1e-4
step = 1e-5
contact_substeps = 8
method = "newmark"
sample_rate = 5000
)");
  ASSERT_EQ(scene.contacts.size(), 1U);
  EXPECT_EQ(scene.contacts[0].inside, "wire");
  EXPECT_EQ(scene.contacts[0].outside, "band");
  EXPECT_EQ(scene.contacts[0].gap, 1.5e-4);
  EXPECT_EQ(scene.contacts[0].stiffness, 1e5);
  EXPECT_EQ(scene.contacts[0].damping, 100);
  EXPECT_EQ(scene.contacts[0].law, fem::ContactLaw::hunt_crossley);
  const fem::Simulation& run = *scene.simulation;
  EXPECT_EQ(run.duration, 2.0);
  EXPECT_EQ(run.excitation.kind, fem::Excitation::Kind::random);
  EXPECT_EQ(run.excitation.band_lo_hz, 10.0);
  EXPECT_EQ(run.excitation.band_hi_hz, 1000.0);
  EXPECT_EQ(run.excitation.rms_acceleration, 20.0);
  EXPECT_EQ(run.excitation.seed, 7U);
  EXPECT_EQ(run.gravity, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(run.tolerance, 1e-4);
  EXPECT_EQ(run.step, 1e-5);
  EXPECT_EQ(run.contact_substeps, 8);
  EXPECT_EQ(run.method, fem::IntegrationMethod::newmark);
  EXPECT_EQ(run.sample_rate, 5000);
}

TEST(SceneFile, ReadsEveryKindOfExcitation) {
  const auto excitation = [](const std::string& text) {
    return scene_of(body_text + "[simulation]\nduration = 1\nexcitation = " + text + "\n")
        .simulation->excitation;
  };
  using Kind = fem::Excitation::Kind;
  EXPECT_EQ(excitation("{ kind = \"multisine\", band = [10, 20], rms_acceleration = 2 }").kind,
            Kind::multisine);
  const auto chirp = excitation("{ kind = \"chirp\", band = [10, 1000], acceleration = 100 }");
  EXPECT_EQ(chirp.kind, Kind::chirp);
  EXPECT_EQ(chirp.acceleration, 100);
  const auto sine = excitation("{ kind = \"sine\", frequency = 200, acceleration = 100 }");
  EXPECT_EQ(sine.kind, Kind::sine);
  EXPECT_EQ(sine.frequency_hz, 200);
  const auto record = excitation("{ kind = \"record\", file = \"r.csv\", column = \"displacement\" }");
  EXPECT_EQ(record.kind, Kind::record);
  EXPECT_THAT(record.file, testing::EndsWith("/r.csv"));  // beside the scene file
  EXPECT_EQ(record.column, "displacement");
}

TEST(SceneFile, RefusesWhatIsWrongInABodyWithFileAndLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "s.toml: has no [[body]]"},
      {"[body]\nname = \"wire\"\n", "s.toml:1: body must be written [[body]]"},
      {"bodie = 1\n" + body_text, "s.toml:1: bodie is not a known key; did you mean 'body'?"},
      {body_text + "[measur]\n", "s.toml:6: measur is not a known key; did you mean 'measure'?"},
      {with("name", "nmae = \"wire\""),
       "s.toml:1: body.name is missing and must be given (is that what 'nmae'"},
      {with("name", "name = 3"), "s.toml:2: body.name must be text in quotes"},
      {with("name", "name = \"a.b\""), "s.toml:2: body.name must not contain '.'"},
      {body_text + body_text, "s.toml:7: body.name 'wire' is taken"},
      {with("points", "points = [[0,0,0]]"), "s.toml:3: body.points give no body of positive length"},
      {with("points", "points = [[1,2,3],[1,2,3]]"), "s.toml:3: body.points give no body of positive length"},
      {with("points", "points = [[0,0,0],[1,2]]"), "s.toml:3: body.points needs three numbers"},
      {with("points", "points = [0,0,0]"), "s.toml:3: body.points needs three numbers"},
      {with("points", "points = [[0,0,0],[1,0,\"0\"]]"), "s.toml:3: body.points needs three finite numbers"},
      {with("length", "length = 0"), "s.toml:6: body.length must be > 0, got 0"},
      {with("diameter", ""), "s.toml:1: body: has no cross-section"},
      {with("diameter", "diametr = 1"), "(is that what 'diametr' stands for?)"},
      {with("diameter", "diameter = -0.001"), "s.toml:4: body.diameter must be > 0, got -0.001"},
      {with("diameter", "diameter = \"3.2 mm\""), "s.toml:4: body.diameter must be a number, got text"},
      {with("area", "area = 1e-6"), "s.toml:6: body.area contradicts diameter"},
      {with("outer_diameter", "outer_diameter = 0.01"), "s.toml:6: body.outer_diameter contradicts diameter"},
      {with("inner_diameter", "inner_diameter = 0.01"), "s.toml:6: body.inner_diameter contradicts diameter"},
      {with("diameter", "inner_diameter = 0.01"), "s.toml:4: body.inner_diameter needs outer_diameter"},
      {with("diameter", "outer_diameter = 0.01"), "s.toml:1: body.inner_diameter is missing"},
      {with("diameter", "outer_diameter = 1\ninner_diameter = 2"),
       "s.toml:5: body.inner_diameter must be below"},
      {with("diameter", "area = 1e-6"), "s.toml:1: body.second_moment is missing"},
      {with("second_moment", "second_moment = 0"), "s.toml:6: body.second_moment must be > 0"},
      {with("torsion_constant", "torsion_constant = 0"), "s.toml:6: body.torsion_constant must be > 0"},
      {with("density", "density = 0"), "s.toml:5: body.density must be > 0, got 0"},
      {with("density", "density = nan"), "s.toml:5: body.density must be a finite number"},
      {with("density", ""), "s.toml:1: body.density is missing"},
      {with("poisson", "poisson = -1"), "s.toml:6: body.poisson must lie above -1"},
      {with("poisson", "poisson = 0.51"),
       "s.toml:6: body.poisson must lie above -1 and not above 0.5, got 0.51"},
      {with("elements", "elements = 0"), "s.toml:6: body.elements must be from 1 to 1000"},
      {with("elements", "elements = 2.5"), "s.toml:6: body.elements must be an integer"},
      {with("start", "start = \"fixed\""),
       "s.toml:6: body.start must be one of clamped, pinned, free, got 'fixed'"},
      {with("colour", "colour = \"red\""), "s.toml:6: body.colour is not a known key"},
      {with("material", "material = 3"), "s.toml:6: body.material must be a table"},
  };
  for (const auto& [text, expected] : cases) EXPECT_THAT(fault_of(text), HasSubstr(expected)) << text;
}

TEST(SceneFile, RefusesWhatIsWrongInAMaterial) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"youngs_modulus = 0", "s.toml:7: body.material.youngs_modulus must be > 0"},
      {"youngs_modulus = { frequency = [1, 2], value = [1] }",
       "s.toml:7: body.material.youngs_modulus cannot be used"},
      {"youngs_modulus = { frequency = [2, 1], value = [1, 1] }",
       "s.toml:7: body.material.youngs_modulus cannot"},
      {"youngs_modulus = { frequency = [1], value = [1], unit = \"Pa\" }",
       "youngs_modulus.unit is not a known key"},
      {"youngs_modulus = { frequency = [1] }", "body.material.youngs_modulus.value is missing"},
      {"loss_factor = -0.1", "s.toml:7: body.material.loss_factor must be >= 0"},
      {"rayleigh = { alpha = -1, beta = 0 }", "s.toml:7: body.material.rayleigh.alpha must be >= 0"},
      {"rayleigh = { gamma = 1 }", "body.material.rayleigh.gamma is not a known key"},
      {"rayleigh = 3", "s.toml:7: body.material.rayleigh must be a table"},
      {"damping = \"both\"", "s.toml:7: body.material.damping must be one of structural, viscous"},
      {"modulus = 1e9", "s.toml:7: body.material.modulus is not a known key"},
      {"loss_factor = 0.1\nrayleigh = { alpha = 1 }\n[simulation]\nduration = 1\n",
       "s.toml:6: body.material.damping is missing"},
      {"damping = \"viscous\"\nloss_factor = 0.02",
       "s.toml:7: body.material.damping = \"viscous\" needs rayleigh, but only loss_factor is given"},
      {"damping = \"structural\"\nrayleigh = { alpha = 1 }",
       "s.toml:7: body.material.damping = \"structural\" needs loss_factor, but only rayleigh is given: give "
       "loss_factor, or damping = \"viscous\""},
  };
  for (const auto& [line, expected] : cases) {
    EXPECT_THAT(fault_of(body_text + "[body.material]\n" + line + "\n"), HasSubstr(expected)) << line;
  }
}

TEST(SceneFile, RefusesWhatIsWrongInDriveMeasurementAndContact) {
  const std::string drive = "[drive]\nsupport = \"wire.start\"\n";
  const std::string measure = "[measure]\nsupport = \"wire.end\"\n";
  const std::string contact = "[[contact]]\ninside = \"wire\"\noutside = \"band\"\nstiffness = 1e5\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[drive]\ndirection = \"y\"\n", "s.toml:13: drive: needs support"},
      {drive, "s.toml:13: drive.direction is missing"},
      {drive + "point = \"wire@0.5\"\ndirection = \"y\"\n", "s.toml:15: drive.point contradicts support"},
      {drive + "direction = \"up\"\n",
       "s.toml:15: drive.direction must be \"x\", \"y\", \"z\" or a vector, got 'up'"},
      {drive + "direction = [0, 0, 0]\n", "s.toml:15: drive.direction must not be the zero vector"},
      {drive + "direction = [0, 1]\n", "s.toml:15: drive.direction needs three numbers"},
      {drive + "direction = \"y\"\nalso = [\"band.end\"]\n",
       "s.toml:16: drive.also 'band.end' is a free end"},
      {drive + "direction = \"y\"\nalso = [\"wire.start\"]\n",
       "s.toml:16: drive.also names 'wire.start' a second"},
      {drive + "direction = \"y\"\nforce = 1\n", "s.toml:16: drive.force is not a known key"},
      {"[drive]\nsupport = \"rope.start\"\ndirection = \"y\"\n", "there is: wire, band"},
      {"[drive]\nsupport = \"wire\"\ndirection = \"y\"\n",
       "s.toml:14: drive.support must be BODY.start or BODY.end"},
      {"[drive]\nsupport = \"wire.middle\"\ndirection = \"y\"\n",
       "drive.support must be BODY.start or BODY.end"},
      {"[drive]\npoint = \"wire@1.5\"\ndirection = \"y\"\n", "s.toml:14: drive.point must be BODY@FRACTION"},
      {"[drive]\npoint = \"wire@\"\ndirection = \"y\"\n", "drive.point must be BODY@FRACTION"},
      {"[drive]\npoint = \"wire@0.5x\"\ndirection = \"y\"\n", "drive.point must be BODY@FRACTION"},
      {"[drive]\npoint = \"wire@0.5\"\ndirection = \"y\"\nalso = [\"wire.end\"]\n",
       "drive.also names supports"},
      {measure, "s.toml:13: measure.directions is missing"},
      {measure + "directions = []\n", "s.toml:15: measure.directions must be an array"},
      {measure + "directions = \"x\"\n", "s.toml:15: measure.directions must be an array"},
      {measure + "directions = [\"x\", \"x\"]\n",
       "s.toml:15: measure.directions gives the output force_x a second"},
      {measure + "directions = [\"x\"]\nquantity = \"velocity\"\n",
       "s.toml:16: measure.quantity goes with point"},
      {"[measure]\npoint = \"wire@0\"\ndirections = [\"x\"]\nquantity = \"force\"\n",
       "measure.quantity must be one of"},
      {contact, "s.toml:13: contact.gap is missing"},
      {contact + "gap = -1e-4\n", "s.toml:17: contact.gap must be > 0, got -0.0001"},
      {contact + "gap = 1e-4\nlaw = \"sticky\"\n",
       "s.toml:18: contact.law must be one of approach, no_adhesion"},
      {contact + "gap = 1e-4\nlaw = \"hard_stop\"\nrestitution = 1.5\n",
       "s.toml:19: contact.restitution must be between 0 and 1"},
      {contact + "gap = 1e-4\nlaw = \"hard_stop\"\nrestitution = -0.1\n",
       "s.toml:19: contact.restitution must be >= 0"},
      {contact + "gap = 1e-4\nrestitution = 0.5\n",
       "s.toml:18: contact.restitution belongs to law = \"hard_stop\""},
      {contact + "gap = 1e-4\ndamping = -1\n", "s.toml:18: contact.damping must be >= 0"},
      {contact + "gap = 1e-4\nfriction = 1\n", "s.toml:18: contact.friction is not a known key"},
      {"[[contact]]\ninside = \"wire\"\noutside = \"wire\"\n",
       "s.toml:15: contact.outside must be another body"},
      {"[[contact]]\ninside = \"rope\"\noutside = \"wire\"\n",
       "s.toml:14: contact.inside is on a body that is not"},
  };
  for (const auto& [lines, expected] : cases) {
    EXPECT_THAT(fault_of(body_text + band_text + lines), HasSubstr(expected)) << lines;
  }
}

TEST(SceneFile, RefusesWhatIsWrongInASimulation) {
  const std::string sine = "excitation = { kind = \"sine\", frequency = 200, acceleration = 1 }\n";
  const auto excited = [](const std::string& text) {
    return "duration = 1\nexcitation = { " + text + " }\n";
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {sine, "s.toml:6: simulation.duration is missing"},
      {"duration = 0\n" + sine, "s.toml:7: simulation.duration must be > 0"},
      {"duration = 1\n", "simulation.excitation is missing"},
      {"duration = 1\nsample_rate = 300\n" + sine,
       "s.toml:9: simulation.excitation.frequency must be below half"},
      {"duration = 1\n" + sine + "tolerance = 1\n", "s.toml:9: simulation.tolerance is a fraction"},
      {"duration = 1\n" + sine + "step = 0\n", "s.toml:9: simulation.step must be > 0"},
      {"duration = 1\n" + sine + "contact_substeps = 0\n",
       "s.toml:9: simulation.contact_substeps must be at least 1"},
      {"duration = 1\n" + sine + "method = \"euler\"\n",
       "s.toml:9: simulation.method must be one of modal, newmark"},
      {"duration = 1\n" + sine + "gravity = 9.81\n", "s.toml:9: simulation.gravity needs three numbers"},
      {"duration = 1\n" + sine + "sample_rate = -1\n", "s.toml:9: simulation.sample_rate must be > 0"},
      {excited("band = [10, 20]"), "simulation.excitation.kind is missing"},
      {excited("kind = \"noise\""), "excitation.kind must be one of random, multisine, chirp, sine, record"},
      {excited("kind = \"random\", band = [10, 20]"), "excitation.rms_acceleration is missing"},
      {excited("kind = \"random\", band = [20, 10], rms_acceleration = 1"), "excitation.band needs [lo, hi]"},
      {excited("kind = \"random\", band = [0, 10], rms_acceleration = 1"),
       "excitation.band must begin above 0 Hz"},
      {excited("kind = \"chirp\", band = [10, 5000], acceleration = 1"),
       "excitation.band must end below half"},
      {excited("kind = \"chirp\", band = [10, 20], rms_acceleration = 1"),
       "excitation.acceleration is missing"},
      {excited("kind = \"chirp\", band = [1, 2], acceleration = 1, seed = 1"),
       "excitation.seed is not a known key"},
      {excited("kind = \"random\", band = [1, 2], rms_acceleration = 1, seed = -1"),
       "excitation.seed must be >= 0"},
      {excited("kind = \"record\", file = \"a.csv\""), "excitation.column is missing"},
  };
  for (const auto& [lines, expected] : cases) {
    EXPECT_THAT(fault_of(body_text + "[simulation]\n" + lines), HasSubstr(expected)) << lines;
  }
}

const std::string parameters_text = R"(body = "wire"
[rayleigh]
alpha = 43.1
beta = 2e-6
alpha_sigma = 1.0
beta_sigma = 1e-7
[loss_factor]
frequency = [20, 60]
value = [0.03, 0.03]
sigma = [0.001, 0.001]
[loss_factor.law]
kind = "constant"
value = 0.03
[modulus]
frequency = [20, 60]
value = [9e10, 9e10]
sigma = [1e7, 1e7]
[modulus.law]
kind = "constant"
value = 9e10
)";

TEST(SceneFile, ParametersGoIntoTheirOwnBodyAndNoOther) {
  const tests::Folder folder;
  const std::string scene_file = folder.write("s.toml", body_text + band_text);
  const std::string parameters = folder.write("identified.toml", parameters_text);
  fem::Scene scene = read_scene(scene_file);
  apply_parameters(scene, {parameters});
  EXPECT_DOUBLE_EQ(scene.bodies[0].material.youngs_modulus.at(30), 9e10);
  EXPECT_DOUBLE_EQ(scene.bodies[0].material.loss_factor.at(30), 0.03);
  EXPECT_EQ(scene.bodies[0].material.rayleigh.alpha, 43.1);
  EXPECT_FALSE(has_modulus(scene.bodies[1]));
  EXPECT_EQ(scene.bodies[1].material.rayleigh.alpha, 0.0);
}

TEST(SceneFile, RefusesParametersOfABodyThatIsNotThereOrTwiceForOne) {
  const tests::Folder folder;
  const std::string parameters = folder.write("identified.toml", parameters_text);
  fem::Scene band_only = read_scene(folder.write("s.toml", band_text));
  EXPECT_THAT([&] { apply_parameters(band_only, {parameters}); },
              testing::ThrowsMessage<Error>(
                  HasSubstr("identified.toml: belongs to body 'wire', which the scene does not "
                            "have; it has 'band'")));
  fem::Scene wire = read_scene(folder.write("w.toml", body_text));
  EXPECT_THAT(
      [&] {
        apply_parameters(wire, {parameters, parameters});
      },
      testing::ThrowsMessage<Error>(HasSubstr("a second parameter file for body 'wire'")));
}

}  // namespace
}  // namespace struna::apps
