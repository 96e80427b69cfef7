#include <gtest/gtest.h>

#include <cmath>

#include "touchstone/contact_core/motion/row_projection.hpp"

namespace touchstone {
namespace {

using Solver = RowProjection<8>;

// Of an arm of five joints with a hand, raised for its bends; two rows differ by their slack alone, and all
// are nearly parallel: rounding has those that hold replace one another for ever.
TEST(RowProjection, RowsThatRoundingKeepsReplacingEnd) {
  Solver::Rows rows;
  rows.count = 4;
  rows.g[0] = {0x1.64601b14323c9p-2, -0x1.03bc5b4500d82p-3, -0x1.1a6dee98fd1d7p-1, 0x1.4f518085c91adp-1,
               -0x1.70a12afd44cf1p-2};
  rows.g[1] = {0x1.3fb9fda137a38p-3, -0x1.bc559b54bd36bp-4, -0x1.b050d4d6ea68ep-2, 0x1.5f434ef4dd715p-1,
               -0x1.1f5536963667bp-1};
  rows.g[2] = {0x1.44fab951c9263p-2, -0x1.fe1580628ee1ap-4, -0x1.10f30b6cb818ep-1, 0x1.545a5fda922e9p-1,
               -0x1.969db2d42480ap-2};
  rows.g[3] = rows.g[1];
  rows.slack = {-0x1.17885734d2883p+0, -0x1.04d9a02e9f1a4p-1, -0x1.d2119f612eda6p-1, -0x1.d1ee4417a0ba1p-2};
  Solver::State state;
  state.x = {-0x1.fd01a44ffd49fp-3, -0x1.2c3437044955dp-6, 0x1.a6a6f3230cb53p-7, 0x1.bcf81ff786655p-7,
             0x1.47ddbb752e021p-8};
  EXPECT_TRUE(Solver::find(rows, state));
  const double length = std::sqrt(Solver::row_product(state.x, state.x));
  for (int i = 0; i < rows.count; ++i)
    EXPECT_GT(Solver::row_product(rows.g[i], state.x) + rows.slack[i], -1e-14 * length);
}

}  // namespace
}  // namespace touchstone
