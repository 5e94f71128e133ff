#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace struna::tests {

/// Shortest of several runs of `work` [s]: the one that other programs disturbed least.
template <class Work>
double best_seconds(int runs, Work work) {
  double best = std::numeric_limits<double>::infinity();
  for (int run = 0; run < runs; ++run) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

}  // namespace struna::tests
