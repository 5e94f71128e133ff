#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ident/transfer_function.hpp"

namespace struna::ident {

/// Several references as one function: the structure was shaken along one direction after the other, and
/// output NAME under reference REFERENCE is called "NAME@REFERENCE" (fem::reference_mark), under the first
/// one NAME alone.
struct References {
  std::vector<std::string> outputs;  ///< without reference, in order of first appearance
  std::vector<std::string> names;    ///< of the references; "" the first one
  Eigen::MatrixXi column;            ///< outputs x references: place among the names; -1: not measured
  bool several() const { return names.size() > 1; }
};
References references_of(const std::vector<std::string>& output_names);
std::vector<std::string> output_names(const TransferFunction& tf);

struct NamedReference {
  std::string name;  ///< "y"; not written for the first one
  std::string file;  ///< told in errors
  TransferFunction function;
};

/// One function of all, on the lines that they share (to 1e-3 of a line spacing). Throws Error for names that
/// are empty, used twice or hold '@', ',' or a blank; outputs, kinds, units or exponential windows that
/// differ; and where the references share less than half of the lines of the band that is common to them.
TransferFunction combine_references(const std::vector<NamedReference>& references);

}  // namespace struna::ident
