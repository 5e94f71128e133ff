#include "ident/modal_assurance.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace struna::ident {
namespace {

using Complex = std::complex<double>;

TEST(ModalAssurance, IsTheSquaredCosineWhateverLengthAndPhase) {
  const Eigen::Vector2cd a(1.0, 0.0), b(std::cos(0.4), std::sin(0.4));
  const double squared_cosine = std::pow(std::cos(0.4), 2.0);
  EXPECT_NEAR(modal_assurance(a, b), squared_cosine, 1e-15);  // rounding
  EXPECT_NEAR(modal_assurance(Complex(0.0, 3.0) * a, Complex(-2.0, 1.0) * b), squared_cosine, 1e-15);
  EXPECT_NEAR(modal_assurance(b, Complex(0.0, 7.0) * b), 1.0, 1e-15);
}

TEST(ModalAssurance, OfNothingIsNoNumber) {
  EXPECT_TRUE(std::isnan(modal_assurance(Eigen::Vector2cd::Zero(), Eigen::Vector2cd::Ones())));
}

}  // namespace
}  // namespace struna::ident
