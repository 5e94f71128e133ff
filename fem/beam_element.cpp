#include "fem/beam_element.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fem/quadrature.hpp"

namespace struna::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector3L = Eigen::Matrix<Lane, 3, 1>;
using Matrix3L = Eigen::Matrix<Lane, 3, 3>;
using Matrix6L = Eigen::Matrix<Lane, 6, 6>;
using Matrix6x3L = Eigen::Matrix<Lane, 6, 3>;
using Matrix6x4L = Eigen::Matrix<Lane, 6, 4>;

// Products of these sizes are written lazyProduct: Eigen would send them to its blocked kernel, made for
// large ones.

/// Gauss points per element. Four integrate the straight element exactly (mass: degree 6); on a curve their
/// error, of order (turn of the element)^8, stays below the Hermite error.
constexpr int points = 4;

struct FixedRule {
  Eigen::Matrix<double, points, 1> node;
  Eigen::Matrix<double, points, 1> weight;
  Eigen::Matrix<double, points, points> integral;
};

const FixedRule& fixed_rule() {
  static const FixedRule rule = [] {
    const GaussRule gauss = gauss_legendre(points);
    return FixedRule{gauss.node, gauss.weight, integration_matrix(gauss.node)};
  }();
  return rule;
}

template <class Scalar>
Eigen::Matrix<Scalar, 3, 3> cross(const Eigen::Matrix<Scalar, 3, 1>& a) {
  Eigen::Matrix<Scalar, 3, 3> m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

/// a x each row.
template <class Matrix>
Matrix cross_rows(const Vector3L& a, const Matrix& m) {
  Matrix product;
  product.col(0) = m.col(2) * a.y() - m.col(1) * a.z();
  product.col(1) = m.col(0) * a.z() - m.col(2) * a.x();
  product.col(2) = m.col(1) * a.x() - m.col(0) * a.y();
  return product;
}

/// Rows of motions at a point to rows of motions `lever` before it: T m, T = [1 0; lever x 1].
template <class Matrix>
Matrix rows_carried(const Vector3L& lever, const Matrix& m) {
  Matrix t = m;
  for (int j = 0; j < m.cols(); ++j) t.col(j).template tail<3>() += lever.cross(m.col(j).template head<3>());
  return t;
}

/// Rows and columns: T m S^T, S with `column_lever`.
Matrix6L carried(const Vector3L& row_lever, const Matrix6L& m, const Vector3L& column_lever) {
  Matrix6L t = m;
  t.rightCols<3>() += cross_rows<Matrix6x3L>(column_lever, m.leftCols<3>());
  return rows_carried(row_lever, t);
}

struct LanePoint {
  Vector3L position;
  Vector3L tangent;
};

void put(const Vector3d& value, int lane, Vector3L& into) {
  for (int i = 0; i < 3; ++i) into(i).set(lane, value(i));
}

/// Where the elements run, each in its lane.
struct Stations {
  Lane length;
  Vector3L start;
  Vector3L end;
  LanePoint gauss[points];

  /// Elements `first` and following between the nodes; lanes beyond the last one repeat it.
  Stations(const Centreline& curve, const std::vector<double>& arc_length, const std::vector<Vector3d>& node,
           int first) {
    const FixedRule& rule = fixed_rule();
    const int last = static_cast<int>(node.size()) - 2;
    for (int lane = 0; lane < Lane::count; ++lane) {
      const auto element = static_cast<std::size_t>(std::min(first + lane, last));
      const double s = arc_length[element];
      const double h = arc_length[element + 1] - s;
      length.set(lane, h);
      put(node[element], lane, start);
      put(node[element + 1], lane, end);
      for (int g = 0; g < points; ++g) {
        const CurvePoint at = curve.at(s + h * rule.node(g));
        put(at.position, lane, gauss[g].position);
        put(at.tangent, lane, gauss[g].tangent);
      }
    }
  }
};

/// Section compliances for unit modulus, times the element's length so that integrals run from 0 to 1:
/// stretch 1/A, twist 1/(G J), bending 1/I. With equal second moments the tangent alone splits them: no
/// normal, no frame, so nothing can flip on a straight or inflected piece.
struct Compliance {
  Lane stretch;
  Lane bending;
  Lane twist_excess;  ///< twist - bending

  Compliance(const Body& body, const Lane& length)
      : stretch(length / body.section.area),
        bending(length / body.section.second_moment),
        twist_excess(length * (2.0 * (1.0 + body.poisson) / body.section.torsion_constant -
                               1.0 / body.section.second_moment)) {}

  /// Change of curvature, one row per load (F, M_c): M = M_c + lever x F, `lever` from the section to the
  /// centre c.
  Matrix6x3L curvature(const Vector3L& t, const Vector3L& lever) const {
    Matrix6x3L kappa;
    const Vector3L excess = twist_excess * t;
    kappa.topRows<3>() = cross<Lane>(-bending * lever) - lever.cross(t).lazyProduct(excess.transpose());
    kappa.bottomRows<3>() = excess.lazyProduct(t.transpose());
    kappa.bottomRows<3>().diagonal().array() += bending;
    return kappa;
  }
};

/// Elements as cantilevers held at their first end and loaded at their second one. Loads are referred to the
/// centre of gravity c, where forces and moments are all but uncoupled and the flexibility is well scaled.
/// Matrices that belong to motions or loads have these in their rows.
class Cantilever {
 public:
  Cantilever(const Body& body, const Stations& stations)
      : body_(body),
        at_(stations),
        compliance_(body, stations.length),
        twist_arm_(std::sqrt(2.0 * body.section.second_moment / body.section.area)) {
    const FixedRule& rule = fixed_rule();
    centre_.setZero();
    for (int g = 0; g < points; ++g) centre_ += Lane(rule.weight(g)) * at_.gauss[g].position;
    set_stiffness();
  }

  /// K = [-R_a R_b]^T k_c [-R_a R_b].
  Matrix12L stiffness() const { return carried_to_ends(k_, -k_, k_); }

  /// Quadrature of rho A u^T u + 2 rho I (theta . t)^2 over the static displacements: R - D per motion of the
  /// first end and D per motion of the second one, both at c; R is rigid motion.
  Matrix12L mass() const {
    const FixedRule& rule = fixed_rule();
    Matrix6x4L elastic[points];
    set_displacement(elastic);
    Matrix6L dd = Matrix6L::Zero();
    Matrix6L dr = Matrix6L::Zero();
    Matrix6L rr = Matrix6L::Zero();
    for (int g = 0; g < points; ++g) {
      const Lane weight = rule.weight(g) * body_.density * body_.section.area * at_.length;
      const Matrix6x4L d = k_.lazyProduct(elastic[g]);
      const Matrix6x4L weighted = weight * d;
      dd += weighted.lazyProduct(d.transpose());
      const Vector3L lever = at_.gauss[g].position - centre_;
      const Vector3L spin = twist_arm_ * at_.gauss[g].tangent;
      dr.leftCols<3>() += weighted.leftCols<3>();
      dr.rightCols<3>() += cross_rows<Matrix6x3L>(lever, weighted.leftCols<3>()) +
                           weighted.col(3).lazyProduct(spin.transpose());
      // Rigid motions; those of translation and rotation do not couple about the centre of gravity.
      rr.bottomRightCorner<3, 3>() +=
          weight * (spin.lazyProduct(spin.transpose()) - lever.lazyProduct(lever.transpose()));
      rr.diagonal().head<3>().array() += weight;
      rr.diagonal().tail<3>().array() += weight * lever.squaredNorm();
    }
    return carried_to_ends(rr - dr - dr.transpose() + dd, dr - dd, dd);
  }

  /// Displacement at s per unit end motions, of the same element in all lanes: rigid motion with the first
  /// end, and the integral of strain and curvature from there to s.
  Eigen::Matrix<Lane, 3, 12> displacement(double s0, double s) const {
    const FixedRule& rule = fixed_rule();
    const Vector3L here = body_.centreline.at(s).position.cast<Lane>();
    const Compliance compliance(body_, s - s0);
    Matrix6x3L elastic = Matrix6x3L::Zero();
    for (int g = 0; g < points; ++g) {
      const CurvePoint at = body_.centreline.at(s0 + (s - s0) * rule.node(g));
      const Lane weight = rule.weight(g);
      const Vector3L t = at.tangent.cast<Lane>();
      const Vector3L position = at.position.cast<Lane>();
      elastic +=
          cross_rows<Matrix6x3L>(weight * (position - here), compliance.curvature(t, centre_ - position));
      elastic.topRows<3>() += (weight * compliance.stretch * t).lazyProduct(t.transpose());
    }
    const Matrix6x3L relative = k_.lazyProduct(elastic);
    Matrix6x3L rigid;
    rigid << Matrix3L::Identity(), cross<Lane>(here - centre_);
    Eigen::Matrix<Lane, 12, 3> shape;
    shape << rows_carried<Matrix6x3L>(centre_ - at_.start, rigid - relative),
        rows_carried(centre_ - at_.end, relative);
    return shape.transpose();
  }

 private:
  /// The lower half of a symmetric matrix over the motions of both ends, from one over those carried to c.
  Matrix12L carried_to_ends(const Matrix6L& aa, const Matrix6L& ba, const Matrix6L& bb) const {
    const Vector3L a = centre_ - at_.start;
    const Vector3L b = centre_ - at_.end;
    Matrix12L m;
    m.topLeftCorner<6, 6>() = carried(a, aa, a);
    m.bottomLeftCorner<6, 6>() = carried(b, ba, a);
    m.bottomRightCorner<6, 6>() = carried(b, bb, b);
    return m;
  }

  /// Displacement (three columns) and twist times its arm (fourth) at each Gauss point per load.
  void set_displacement(Matrix6x4L (&elastic)[points]) const {
    Matrix6x3L curvature[points];
    for (int g = 0; g < points; ++g)
      curvature[g] = compliance_.curvature(at_.gauss[g].tangent, centre_ - at_.gauss[g].position);
    Matrix6x3L slope[points];
    for (int g = 0; g < points; ++g) {
      const Vector3L& t = at_.gauss[g].tangent;
      const Matrix6x3L rotation = integral(curvature, g);
      elastic[g].col(3) = rotation.lazyProduct(twist_arm_ * t);
      slope[g] = cross_rows<Matrix6x3L>(Vector3L(-at_.length * t), rotation);
      slope[g].topRows<3>() += (compliance_.stretch * t).lazyProduct(t.transpose());
    }
    for (int g = 0; g < points; ++g) elastic[g].leftCols<3>() = integral(slope, g);
  }

  Matrix6x3L integral(const Matrix6x3L (&value)[points], int g) const {
    const auto& w = fixed_rule().integral;
    return Lane(w(g, 0)) * value[0] + Lane(w(g, 1)) * value[1] + Lane(w(g, 2)) * value[2] +
           Lane(w(g, 3)) * value[3];
  }

  /// Inverse of the flexibility [A B; B^T C] at c by blocks.
  void set_stiffness() {
    const FixedRule& rule = fixed_rule();
    Matrix3L a = Matrix3L::Zero();
    Matrix3L b = Matrix3L::Zero();
    Matrix3L c = Matrix3L::Zero();
    for (int g = 0; g < points; ++g) {
      const Lane weight = rule.weight(g);
      const Vector3L& t = at_.gauss[g].tangent;
      const Vector3L lever = centre_ - at_.gauss[g].position;
      const Vector3L torque = lever.cross(t);
      const Vector3L bend = weight * compliance_.bending * lever;
      const Vector3L excess = weight * compliance_.twist_excess * torque;
      const Matrix3L axial = (weight * t).lazyProduct(t.transpose());
      a += compliance_.stretch * axial - bend.lazyProduct(lever.transpose()) +
           excess.lazyProduct(torque.transpose());
      a.diagonal().array() += bend.dot(lever);
      // The bending part of B, -lever x, sums to zero about the centre of gravity.
      b -= excess.lazyProduct(t.transpose());
      c += compliance_.twist_excess * axial;
    }
    c.diagonal().array() += compliance_.bending;
    const Matrix3L c_inverse = c.inverse();
    const Matrix3L coupling = b.lazyProduct(c_inverse);
    const Matrix3L force = Matrix3L(a - coupling.lazyProduct(b.transpose())).inverse();
    const Matrix3L mixed = -force.lazyProduct(coupling);
    k_.topLeftCorner<3, 3>() = force;
    k_.topRightCorner<3, 3>() = mixed;
    k_.bottomLeftCorner<3, 3>() = mixed.transpose();
    k_.bottomRightCorner<3, 3>() = c_inverse - coupling.transpose().lazyProduct(mixed);
  }

  const Body& body_;
  const Stations& at_;
  Compliance compliance_;
  Lane twist_arm_;  ///< a twist times it is a displacement of the same inertia
  Vector3L centre_;
  Matrix6L k_;  ///< load (F, M_c) per motion of the second end, carried to c
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

std::vector<Vector3d> ends(const Body& body, double s0, double s1) {
  return {body.centreline.at(s0).position, body.centreline.at(s1).position};
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

LaneElementMatrices beam_elements(const Body& body, const std::vector<double>& arc_length,
                                  const std::vector<Vector3d>& node, int first) {
  const Stations stations(body.centreline, arc_length, node, first);
  const Cantilever cantilever(body, stations);
  return {cantilever.stiffness(), cantilever.mass()};
}

ElementMatrices beam_element(const Body& body, double s0, double s1) {
  const LaneElementMatrices lanes = beam_elements(body, {s0, s1}, ends(body, s0, s1), 0);
  const auto symmetric = [](const Matrix12L& m) -> Matrix12 {
    return m.unaryExpr([](const Lane& entry) { return entry[0]; }).selfadjointView<Eigen::Lower>();
  };
  return {symmetric(lanes.stiffness), symmetric(lanes.mass)};
}

Matrix3x12 beam_displacement(const Body& body, double s0, double s1, double s) {
  const Stations stations(body.centreline, {s0, s1}, ends(body, s0, s1), 0);
  return Cantilever(body, stations).displacement(s0, s).unaryExpr([](const Lane& entry) { return entry[0]; });
}

}  // namespace struna::fem
