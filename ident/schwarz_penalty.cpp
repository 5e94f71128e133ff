#include "ident/schwarz_penalty.hpp"

#include <cmath>

namespace struna::ident {

double schwarz_penalty(const SchwarzTerms& terms) {
  return terms.parameters * std::log(terms.data / terms.line_correlation) * terms.scatter *
         terms.line_correlation;
}

}  // namespace struna::ident
