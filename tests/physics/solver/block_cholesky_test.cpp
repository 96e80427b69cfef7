#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "touchstone/physics/solver/block_cholesky.hpp"

namespace touchstone::physics {
namespace {

TEST(BlockCholesky, SolvesWhatItsBlocksSay) {
  // Units of 6 and 7 rows in a ring with a chord: A = 1 + sum of v v^T over pairs.
  const std::vector<std::uint32_t> sizes{6, 7, 6, 6, 7};
  const std::vector<BlockCholesky::Pair> pairs{{0, 1}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {3, 4}};
  const std::vector<std::size_t> first{0, 6, 13, 19, 25};
  constexpr std::size_t n = 32;
  std::vector<double> A(n * n, 0.0), x(n), right(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) A[i * n + i] = 1.0, x[i] = std::cos(static_cast<double>(3 * i));
  std::mt19937 random(5);
  for (const auto& [a, b] : pairs) {
    std::vector<double> v(n, 0.0);
    for (const std::uint32_t unit : {a, b})
      for (std::size_t k = 0; k < sizes[unit]; ++k)
        v[first[unit] + k] = static_cast<double>(random() % 100) - 50.0;
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t c = 0; c < n; ++c) A[r * n + c] += v[r] * v[c];
  }
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t c = 0; c < n; ++c) right[r] += A[r * n + c] * x[c];
  BlockCholesky cholesky;
  for (int again = 0; again < 2; ++again) {
    cholesky.analyse(sizes, pairs);
    cholesky.clear();
    for (std::uint32_t u = 0; u < sizes.size(); ++u)
      for (std::size_t r = 0; r < sizes[u]; ++r)
        for (std::size_t c = 0; c < sizes[u]; ++c)
          cholesky.diagonal(u)[r * sizes[u] + c] = A[(first[u] + r) * n + first[u] + c];
    for (const auto& [a, b] : pairs) {
      bool is_transposed = false;
      double* const block = cholesky.block(a, b, is_transposed);
      const std::uint32_t row = is_transposed ? b : a, column = is_transposed ? a : b;
      for (std::size_t r = 0; r < sizes[row]; ++r)
        for (std::size_t c = 0; c < sizes[column]; ++c)
          block[r * sizes[column] + c] = A[(first[row] + r) * n + first[column] + c];
    }
    ASSERT_TRUE(cholesky.factor());
    std::vector<double> y = right;
    cholesky.solve(y, first);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(y[i], x[i], 1e-9);
  }
}

}  // namespace
}  // namespace touchstone::physics
