#include "fem/scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/error.hpp"
#include "tests/message_of.hpp"

namespace struna::fem {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using tests::message_of;

Body body(const std::string& name, double length) {
  return {.name = name,
          .centreline = straight_line({0, 0, 0}, {length, 0, 0}),
          .section = solid_circle(0.0032),
          .density = 7650,
          .material = {}};
}

/// Wire shaken at its start along y, force read at its end; a band around it.
Scene wire_and_band() {
  Scene scene;
  scene.bodies = {body("wire", 0.68), body("band", 0.3)};
  scene.drive = SceneDrive{Support{"wire", End::start}, Eigen::Vector3d::UnitY(), {}};
  scene.measurement = SceneMeasurement{Support{"wire", End::end},
                                       MotionQuantity::displacement,
                                       {"force_x", "force_y"},
                                       {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()}};
  return scene;
}

TEST(Scene, BodyIsFoundByItsName) {
  const Scene scene = wire_and_band();
  EXPECT_EQ(&body_named(scene, "band"), &scene.bodies[1]);
  EXPECT_THAT(message_of([&] { body_named(scene, "rope"); }), HasSubstr("'rope'; there is: wire, band"));
  EXPECT_THAT(message_of([&] { body_named({}, "rope"); }), HasSubstr("there is: none"));
}

TEST(Scene, LinearPathIsTheBodyDrivenAndMeasured) {
  const LinearPath path = linear_path(wire_and_band());
  EXPECT_EQ(path.body.name, "wire");
  const auto& motion = std::get<SupportMotion>(path.drive);
  EXPECT_THAT(motion.ends, ElementsAre(End::start));
  EXPECT_EQ(motion.direction, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(std::get<SupportForce>(path.measurement.what).end, End::end);
  EXPECT_EQ(path.measurement.directions.size(), 2U);
}

TEST(Scene, SupportsThatMoveAlongCountOnTheMeasuredBodyOnly) {
  Scene scene = wire_and_band();
  scene.drive->also = {{"wire", End::end}, {"band", End::start}, {"wire", End::start}};
  EXPECT_THAT(std::get<SupportMotion>(linear_path(scene).drive).ends, ElementsAre(End::start, End::end));
  // The drive stands on the band, the wire's end moves along: the wire is driven at its end.
  scene.drive->at = Support{"band", End::start};
  scene.drive->also = {{"wire", End::end}};
  EXPECT_THAT(std::get<SupportMotion>(linear_path(scene).drive).ends, ElementsAre(End::end));
}

TEST(Scene, PointsBecomeForceAndDisplacementAtTheirFraction) {
  Scene scene = wire_and_band();
  scene.drive = SceneDrive{BodyPoint{"wire", 0.25}, Eigen::Vector3d::UnitZ(), {}};
  scene.measurement->at = BodyPoint{"wire", 0.75};
  const LinearPath path = linear_path(scene);
  EXPECT_EQ(std::get<PointForce>(path.drive).fraction, 0.25);
  EXPECT_EQ(std::get<PointForce>(path.drive).direction, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(std::get<PointDisplacement>(path.measurement.what).fraction, 0.75);
}

TEST(Scene, LinearPathRefusesAMeasuredBodyThatIsNotDriven) {
  Scene scene = wire_and_band();
  scene.measurement->at = Support{"band", End::end};
  EXPECT_THAT(message_of([&] { linear_path(scene); }), HasSubstr("'band' must be driven too"));
  scene.drive->at = BodyPoint{"wire", 0.5};
  EXPECT_THAT(message_of([&] { linear_path(scene); }), HasSubstr("the drive is on 'wire'"));
}

TEST(Scene, TellsWhichBodyIsOnTheLinearPath) {
  Scene scene = wire_and_band();
  EXPECT_TRUE(is_on_linear_path(scene, "wire"));
  EXPECT_FALSE(is_on_linear_path(scene, "band"));
  scene.measurement->at = Support{"band", End::end};
  EXPECT_FALSE(is_on_linear_path(scene, "wire"));
  EXPECT_FALSE(is_on_linear_path(scene, "band"));
  scene.drive->also = {{"band", End::start}};
  EXPECT_TRUE(is_on_linear_path(scene, "band"));
  scene.drive.reset();
  EXPECT_FALSE(is_on_linear_path(scene, "band"));
}

TEST(Scene, LinearPathRefusesASceneWithoutDriveOrMeasurement) {
  Scene scene = wire_and_band();
  scene.drive.reset();
  EXPECT_THAT(message_of([&] { linear_path(scene); }), HasSubstr("needs a [drive]"));
  scene = wire_and_band();
  scene.measurement.reset();
  EXPECT_THAT(message_of([&] { linear_path(scene); }), HasSubstr("needs a [measure]"));
  EXPECT_THROW(select_outputs(scene, {"force_x"}), Error);
}

TEST(Scene, SelectedOutputsComeInTheOrderAskedForWithTheirDirections) {
  Scene scene = wire_and_band();
  select_outputs(scene, {"force_y", "force_x"});
  EXPECT_THAT(scene.measurement->names, ElementsAre("force_y", "force_x"));
  EXPECT_EQ(scene.measurement->directions[0], Eigen::Vector3d(0, 1, 0));
  select_outputs(scene, {"force_x"});
  EXPECT_THAT(scene.measurement->names, ElementsAre("force_x"));
  EXPECT_EQ(scene.measurement->directions[0], Eigen::Vector3d(1, 0, 0));
  EXPECT_THAT(message_of([&] { select_outputs(scene, {"force_y"}); }), HasSubstr("it reads: force_x"));
}

TEST(Scene, OutputsOfAReferenceAreReadWhileTheDriveActsAlongIt) {
  Scene scene = wire_and_band();
  scene.drive->direction = Eigen::Vector3d::UnitY();
  scene.drive->references["oblique"] = Eigen::Vector3d(0, 0.6, 0.8);
  const Scene before = scene;
  select_outputs(scene, {"force_x", "force_y@z", "force_x@oblique"});
  EXPECT_THAT(scene.measurement->names, ElementsAre("force_x", "force_y@z", "force_x@oblique"));
  const auto& along = linear_path(scene).measurement.drive_directions;
  EXPECT_THAT(along,
              ElementsAre(Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0.6, 0.8)));
  scene = before;
  select_outputs(scene, {"force_x"});
  EXPECT_TRUE(scene.measurement->drive_directions.empty());
  EXPECT_THAT(message_of([&] { select_outputs(scene, {"force_x@2"}); }),
              HasSubstr("the direction of reference '2' is not known; known: x, y, z, oblique"));
}

}  // namespace
}  // namespace struna::fem
