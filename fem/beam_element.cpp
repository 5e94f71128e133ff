#include "fem/beam_element.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "fem/quadrature.hpp"

namespace struna::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix6x3 = Eigen::Matrix<double, 6, 3>;
using Matrix12x6 = Eigen::Matrix<double, 12, 6>;

// Products of these sizes are written lazyProduct: Eigen would send them to its blocked kernel, made for
// large ones.

/// Gauss points per element. Four integrate the straight element exactly (mass: degree 6); on a curve their
/// error, of order (turn of the element)^8, stays below the Hermite error.
constexpr int points = 4;
using PerPoint = Eigen::Matrix<double, 18, points>;  ///< a 6 x 3 matrix per Gauss point

struct FixedRule {
  Eigen::Matrix<double, points, 1> node;
  Eigen::Matrix<double, points, 1> weight;
  Eigen::Matrix<double, points, 1> root_weight;
  Eigen::Matrix<double, points, points> integral_transposed;
};

const FixedRule& fixed_rule() {
  static const FixedRule rule = [] {
    const GaussRule gauss = gauss_legendre(points);
    return FixedRule{gauss.node, gauss.weight, gauss.weight.cwiseSqrt(),
                     integration_matrix(gauss.node).transpose()};
  }();
  return rule;
}

Matrix3d cross(const Vector3d& a) {
  Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

/// Section compliances for unit modulus: stretch 1/A, twist 1/(G J), bending 1/I. With equal second moments
/// the tangent alone splits them: no normal, no frame, so nothing can flip on a straight or inflected piece.
struct Compliance {
  double stretch;
  double bending;
  double twist_excess;  ///< twist - bending

  explicit Compliance(const Body& body)
      : stretch(1.0 / body.section.area),
        bending(1.0 / body.section.second_moment),
        twist_excess(2.0 * (1.0 + body.poisson) / body.section.torsion_constant - bending) {}

  /// Change of curvature, one row per load (F, M_c): M = M_c + lever x F, `lever` from the section to the
  /// centre c.
  Matrix6x3 curvature(const Vector3d& t, const Vector3d& lever) const {
    Matrix6x3 kappa;
    kappa.topRows<3>() = cross(-bending * lever) - (twist_excess * lever.cross(t)) * t.transpose();
    kappa.bottomRows<3>() = (twist_excess * t) * t.transpose();
    kappa.bottomRows<3>().diagonal().array() += bending;
    return kappa;
  }
};

/// Transposed motion of a point `lever` away that goes with a motion (u, theta) of a rigid body:
/// (u + theta x lever, theta).
Matrix6 rigid_transfer(const Vector3d& lever) {
  Matrix6 transfer = Matrix6::Identity();
  transfer.bottomLeftCorner<3, 3>() = cross(lever);
  return transfer;
}

/// The element as a cantilever held at its first end and loaded at its second one. Loads are referred to its
/// centre of gravity c, where forces and moments are all but uncoupled and the flexibility is well scaled.
/// Matrices that belong to end motions or loads have these in their rows, the long side that vector
/// instructions run along.
class Cantilever {
 public:
  Cantilever(const Body& body, double s0, double s1)
      : compliance_(body),
        length_(s1 - s0),
        start_(body.centreline.at(s0).position),
        end_(body.centreline.at(s1).position) {
    const FixedRule& rule = fixed_rule();
    for (int g = 0; g < points; ++g) {
      station_[g] = body.centreline.at(s0 + length_ * rule.node(g));
      centre_ += rule.weight(g) * station_[g].position;
    }
    relative_ << -rigid_transfer(centre_ - start_), rigid_transfer(centre_ - end_);
    load_ = relative_.lazyProduct(centre_stiffness());
  }

  /// K = [-R_a R_b]^T k_c [-R_a R_b].
  Matrix12 stiffness() const {
    const Matrix12 k = load_.lazyProduct(relative_.transpose());
    return 0.5 * (k + k.transpose());
  }

  /// Quadrature of rho A u^T u + 2 rho I (theta . t)^2 over the static displacements.
  Matrix12 mass(const Body& body) const {
    const FixedRule& rule = fixed_rule();
    const Eigen::Matrix<double, points, points> integral = length_ * rule.integral_transposed;
    PerPoint curvature;
    for (int g = 0; g < points; ++g) {
      Matrix6x3::Map(curvature.col(g).data()) =
          compliance_.curvature(station_[g].tangent, centre_ - station_[g].position);
    }
    const PerPoint rotation = curvature.lazyProduct(integral);
    PerPoint slope;  // u' = strain + theta x t
    for (int g = 0; g < points; ++g) {
      const Vector3d& t = station_[g].tangent;
      auto du = Matrix6x3::Map(slope.col(g).data());
      du = Matrix6x3::Map(rotation.col(g).data()).lazyProduct(cross(t));
      du.topRows<3>() += (compliance_.stretch * t) * t.transpose();
    }
    const PerPoint displacement = slope.lazyProduct(integral);

    // Columns: three displacements and the twist at each Gauss point, each times the root of its weight.
    Eigen::Matrix<double, 6, 4 * points> elastic;
    Eigen::Matrix<double, 6, 4 * points> rigid;
    const double u_root = std::sqrt(body.density * body.section.area * length_);
    const double twist_root = std::sqrt(2.0 * body.density * body.section.second_moment * length_);
    for (int g = 0; g < points; ++g) {
      const CurvePoint& at = station_[g];
      const double u_weight = u_root * rule.root_weight(g);
      const double twist_weight = twist_root * rule.root_weight(g);
      elastic.middleCols<3>(4 * g) = u_weight * Matrix6x3::Map(displacement.col(g).data());
      elastic.col(4 * g + 3) = Matrix6x3::Map(rotation.col(g).data()).lazyProduct(twist_weight * at.tangent);
      rigid.middleCols<3>(4 * g) << u_weight * Matrix3d::Identity(), u_weight * cross(at.position - start_);
      rigid.col(4 * g + 3) << Vector3d::Zero(), twist_weight * at.tangent;
    }
    Eigen::Matrix<double, 12, 4 * points> shape = load_.lazyProduct(elastic);
    shape.topRows<6>() += rigid;
    return shape.lazyProduct(shape.transpose());
  }

  /// Displacement at s per unit end motions: rigid motion with the first end, and the integral of strain and
  /// curvature from there to s.
  Matrix3x12 displacement(const Body& body, double s0, double s) const {
    const FixedRule& rule = fixed_rule();
    const Vector3d here = body.centreline.at(s).position;
    Matrix6x3 elastic = Matrix6x3::Zero();
    for (int g = 0; g < points; ++g) {
      const CurvePoint at = body.centreline.at(s0 + (s - s0) * rule.node(g));
      const double weight = (s - s0) * rule.weight(g);
      elastic += compliance_.curvature(at.tangent, centre_ - at.position)
                     .lazyProduct(weight * cross(here - at.position));
      elastic.topRows<3>() += (weight * compliance_.stretch * at.tangent) * at.tangent.transpose();
    }
    Eigen::Matrix<double, 12, 3> shape = load_.lazyProduct(elastic);
    shape.topRows<6>() += rigid_transfer(here - start_).leftCols<3>();
    return shape.transpose();
  }

 private:
  /// Load (F, M_c) per motion of the second end, carried to c: inverse of the flexibility [A B; B^T C] by
  /// blocks.
  Matrix6 centre_stiffness() const {
    const FixedRule& rule = fixed_rule();
    Matrix3d a = Matrix3d::Zero();
    Matrix3d b = Matrix3d::Zero();
    Matrix3d c = Matrix3d::Zero();
    for (int g = 0; g < points; ++g) {
      const double weight = length_ * rule.weight(g);
      const Vector3d& t = station_[g].tangent;
      const Vector3d lever = centre_ - station_[g].position;
      const Vector3d torque = lever.cross(t);
      const Matrix3d axial = (weight * t) * t.transpose();
      a += compliance_.stretch * axial - (weight * compliance_.bending * lever) * lever.transpose() +
           (weight * compliance_.twist_excess * torque) * torque.transpose();
      a.diagonal().array() += weight * compliance_.bending * lever.squaredNorm();
      // The bending part of B, -lever x, sums to zero about the centre of gravity.
      b -= (weight * compliance_.twist_excess * torque) * t.transpose();
      c += compliance_.twist_excess * axial;
      c.diagonal().array() += weight * compliance_.bending;
    }
    const Matrix3d c_inverse = c.inverse();
    const Matrix3d coupling = b * c_inverse;
    const Matrix3d force = (a - coupling * b.transpose()).inverse();
    const Matrix3d mixed = -force * coupling;
    Matrix6 k;
    k << force, mixed, mixed.transpose(), c_inverse - coupling.transpose() * mixed;
    return k;
  }

  Compliance compliance_;
  double length_;
  Vector3d start_;
  Vector3d end_;
  Vector3d centre_ = Vector3d::Zero();
  CurvePoint station_[points];
  Matrix12x6 relative_;  ///< motion of c with the second end less that with the first
  Matrix12x6 load_;      ///< loads at c
};

using Matrix4 = Eigen::Matrix4d;
using Matrix2 = Eigen::Matrix2d;

/// Element matrix from the Hermite matrix over (deflection, slope) of both ends, shared by both planes, and
/// the linear ones of stretch and twist. The slope vector is theta x t, so no transverse axes are needed.
Matrix12 along(const Vector3d& t, const Matrix4& hermite, const Matrix2& stretch, const Matrix2& twist) {
  const Matrix3d axial = t * t.transpose();
  const Matrix3d transverse = Matrix3d::Identity() - axial;
  const Matrix3d spin = cross(t);
  Matrix12 m;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      m.block<3, 3>(6 * i, 6 * j) = hermite(2 * i, 2 * j) * transverse + stretch(i, j) * axial;
      m.block<3, 3>(6 * i, 6 * j + 3) = -hermite(2 * i, 2 * j + 1) * spin;
      m.block<3, 3>(6 * i + 3, 6 * j) = hermite(2 * i + 1, 2 * j) * spin;
      m.block<3, 3>(6 * i + 3, 6 * j + 3) = hermite(2 * i + 1, 2 * j + 1) * transverse + twist(i, j) * axial;
    }
  }
  return m;
}

}  // namespace

ElementMatrices straight_beam_element(const Body& body, double length, const Vector3d& tangent) {
  const double h = length;
  const Section& section = body.section;
  Matrix4 bending;
  bending << 12, 6 * h, -12, 6 * h, 6 * h, 4 * h * h, -6 * h, 2 * h * h, -12, -6 * h, 12, -6 * h, 6 * h,
      2 * h * h, -6 * h, 4 * h * h;
  Matrix4 inertia;
  inertia << 156, 22 * h, 54, -13 * h, 22 * h, 4 * h * h, 13 * h, -3 * h * h, 54, 13 * h, 156, -22 * h,
      -13 * h, -3 * h * h, -22 * h, 4 * h * h;
  const Matrix2 spring{{1.0, -1.0}, {-1.0, 1.0}};
  const Matrix2 rod{{2.0, 1.0}, {1.0, 2.0}};
  const double shear_modulus = 0.5 / (1.0 + body.poisson);
  return {along(tangent, section.second_moment / (h * h * h) * bending, section.area / h * spring,
                shear_modulus * section.torsion_constant / h * spring),
          along(tangent, body.density * section.area * h / 420.0 * inertia,
                body.density * section.area * h / 6.0 * rod,
                body.density * section.second_moment * h / 3.0 * rod)};
}

ElementMatrices beam_element(const Body& body, double s0, double s1) {
  const Cantilever cantilever(body, s0, s1);
  return {cantilever.stiffness(), cantilever.mass(body)};
}

Matrix3x12 beam_displacement(const Body& body, double s0, double s1, double s) {
  return Cantilever(body, s0, s1).displacement(body, s0, s);
}

}  // namespace struna::fem
