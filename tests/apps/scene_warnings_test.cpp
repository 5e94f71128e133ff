#include "apps/scene_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace struna::apps {
namespace {

using testing::HasSubstr;

/// A steel wire of the size of a laboratory's.
fem::Scene scene(double length = 0.68, double diameter = 0.0032, double modulus = 200e9,
                 double density = 7650) {
  fem::Body body{.name = "wire",
                 .centreline = fem::straight_line({0, 0, 0}, {length, 0, 0}),
                 .section = fem::solid_circle(diameter),
                 .material = {}};
  body.density = density;
  if (modulus > 0.0) body.material.youngs_modulus = fem::constant_law(modulus);
  fem::Scene result;
  result.bodies.push_back(body);
  return result;
}

TEST(SceneWarnings, SoundScenesHaveNone) {
  EXPECT_TRUE(scene_warnings(scene()).empty());
  EXPECT_TRUE(scene_warnings(scene(0.68, 0.0032, 0.0)).empty());        // modulus to be identified
  EXPECT_TRUE(scene_warnings(scene(0.05, 1e-4, 70e9, 19300)).empty());  // a thin string of gold
  EXPECT_TRUE(scene_warnings(scene(0.3, 0.01, 5e6, 1100)).empty());     // a rubber cord
  EXPECT_TRUE(scene_warnings(scene(12.0, 0.1, 210e9, 7850)).empty());   // a mast
}

TEST(SceneWarnings, MillimetresGigapascalsAndGramsAreTold) {
  struct Case {
    fem::Scene scene;
    const char* what;
  };
  for (const Case& tried :
       {Case{scene(0.68, 3.2), "3.2 m thick: lengths are in metres"},
        Case{scene(680.0, 3.2), "680 m long and 3.2 m thick: lengths are in metres"},
        Case{scene(680.0), "680 m long"}, Case{scene(0.68, 0.1), "6.8 times its thickness"},
        Case{scene(0.68, 0.0032, 200.0), "youngs_modulus = 200 Pa is softer than silicone"},
        Case{scene(0.68, 0.0032, 200e12), "harder than diamond"},
        Case{scene(0.68, 0.0032, 200e9, 7.65), "7.65 kg/m^3 is lighter than cork"},
        Case{scene(0.68, 0.0032, 200e9, 7.65e6), "heavier than osmium"}}) {
    const auto warnings = scene_warnings(tried.scene);
    ASSERT_EQ(warnings.size(), 1U) << tried.what;
    EXPECT_THAT(warnings[0], HasSubstr("body 'wire'"));
    EXPECT_THAT(warnings[0], HasSubstr(tried.what));
  }
}

}  // namespace
}  // namespace struna::apps
